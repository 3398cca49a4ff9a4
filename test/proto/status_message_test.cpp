// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/status_message.hpp"

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "segserve/v1/error_reason.pb.h"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

absl::Status full_status() {
  return with_details(absl::ResourceExhaustedError("full"), {.reason = ErrorReason::kQueueFull,
                                                             .metadata = {{"limit", "max_queue"}},
                                                             .fields = {{"a.b", "wrong"}, {"c", "too"}},
                                                             .quotas = {{"subject:a", "frames_per_second is 1"}},
                                                             .retry_delay = std::chrono::milliseconds(1500)});
}

TEST(WireStatus, OkIsOkBothWays) {
  EXPECT_TRUE(to_grpc(absl::OkStatus()).ok());
  EXPECT_TRUE(from_grpc(grpc::Status::OK).ok());
  EXPECT_TRUE(with_reason(absl::OkStatus(), ErrorReason::kInternal).ok());
  EXPECT_TRUE(invalid_fields({}).ok());
}

TEST(WireStatus, EveryDetailSurvivesTheWire) {
  const absl::Status status = from_grpc(to_grpc(full_status()));
  EXPECT_EQ(status, full_status());
  const ErrorDetails details = details_of(status);
  EXPECT_EQ(details.reason, ErrorReason::kQueueFull);
  EXPECT_EQ(details.metadata.at("limit"), "max_queue");
  ASSERT_EQ(details.fields.size(), 2U);
  EXPECT_EQ(details.fields[0].field, "a.b");
  EXPECT_EQ(details.fields[1].description, "too");
  ASSERT_EQ(details.quotas.size(), 1U);
  EXPECT_EQ(details.quotas[0].subject, "subject:a");
  EXPECT_EQ(details.quotas[0].description, "frames_per_second is 1");
  EXPECT_EQ(details.retry_delay, std::chrono::milliseconds(1500));
}

TEST(WireStatus, RetryDelaysAreBetweenNothingAndADay) {
  const auto read = [](std::int64_t seconds, std::int32_t nanos) {
    google::rpc::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(seconds);
    retry.mutable_retry_delay()->set_nanos(nanos);
    google::rpc::Status message;
    message.set_code(static_cast<int>(absl::StatusCode::kUnavailable));
    message.add_details()->PackFrom(retry);
    return details_of(from_message(message)).retry_delay;
  };
  using std::chrono::milliseconds;
  constexpr milliseconds kDay = std::chrono::hours(24);
  EXPECT_EQ(read(1, 5'000'000), milliseconds(1005));
  EXPECT_EQ(read(0, -2'000'000'000), milliseconds(0));
  EXPECT_EQ(read(-5, 999'999'999), milliseconds(0));
  EXPECT_EQ(read(std::numeric_limits<std::int64_t>::max(), 999'999'999), kDay);
}

TEST(WireStatus, DetailsAreWhatGoogleRpcReadersExpect) {
  google::rpc::Status message;
  ASSERT_TRUE(message.ParseFromString(to_grpc(full_status()).error_details()));
  EXPECT_EQ(message.code(), 8);
  EXPECT_EQ(message.message(), "full");
  google::rpc::ErrorInfo info;
  bool found = false;
  for (const auto& detail : message.details()) found = found || detail.UnpackTo(&info);
  ASSERT_TRUE(found);
  EXPECT_EQ(info.reason(), "QUEUE_FULL");
  EXPECT_EQ(info.domain(), "segserve");
}

TEST(WireStatus, ReasonsAreThoseOfTheApi) {
  const auto& api = *v1::ErrorReason_descriptor();
  for (int i = 0; i < api.value_count(); ++i) {
    const auto reason = static_cast<ErrorReason>(api.value(i)->number());
    EXPECT_EQ(api.value(i)->name(), "ERROR_REASON_" + std::string(name(reason)));
    EXPECT_EQ(details_of(with_reason(absl::InternalError("x"), reason)).reason, reason);
  }
}

TEST(WireStatus, TheFirstReasonWins) {
  const absl::Status status = with_reason(full_status(), ErrorReason::kInternal);
  EXPECT_EQ(details_of(status).reason, ErrorReason::kQueueFull);
}

TEST(WireStatus, ACodeImpliesItsReason) {
  const auto reason = [](const absl::Status& status) { return details_of(from_grpc(to_grpc(status))).reason; };
  EXPECT_EQ(reason(absl::CancelledError("x")), ErrorReason::kCancelled);
  EXPECT_EQ(reason(absl::DeadlineExceededError("x")), ErrorReason::kDeadlineExceeded);
  EXPECT_EQ(reason(absl::UnavailableError("x")), ErrorReason::kDraining);
}

TEST(WireStatus, CodesThatTheApiDoesNotListAreInternal) {
  const grpc::Status status = to_grpc(absl::NotFoundError("no such file"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INTERNAL);
  EXPECT_EQ(details_of(from_grpc(status)).reason, ErrorReason::kInternal);
}

TEST(WireStatus, InvalidFieldsListsAllInTheMessage) {
  const absl::Status status = invalid_fields({{"options.lambda", "2 is too much"}, {"cloud", "missing"}});
  EXPECT_EQ(status.message(), "options.lambda: 2 is too much; cloud: missing");
  EXPECT_EQ(details_of(status).fields.size(), 2U);
}

TEST(WireStatus, LimitExceededNamesLimitAndValues) {
  const absl::Status status = limit_exceeded("the cloud has", 7, "points", "max_points", 5);
  EXPECT_EQ(status.message(), "the cloud has 7 points, more than max_points = 5");
  EXPECT_EQ(details_of(status).metadata.at("allowed"), "5");
}

TEST(WireStatus, GrpcsRefusalOfALargeMessageGetsOurReason) {
  const absl::Status status =
      from_grpc({grpc::StatusCode::RESOURCE_EXHAUSTED, "Received message larger than max (10 vs. 9)"});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(details_of(status).reason, ErrorReason::kLimitExceeded);
  EXPECT_THAT(std::string(status.message()), HasSubstr("10 vs. 9"));
}

TEST(WireStatus, ForeignAndBrokenDetailsAreDropped) {
  const absl::Status broken = from_grpc({grpc::StatusCode::UNAVAILABLE, "no route", "\xff\xff garbage"});
  EXPECT_EQ(broken, absl::UnavailableError("no route"));

  google::rpc::Status message;
  google::rpc::ErrorInfo info;
  info.set_reason("QUEUE_FULL");
  info.set_domain("example.com");
  message.add_details()->PackFrom(info);
  message.add_details()->set_type_url("type.googleapis.com/example.Unknown");
  const absl::Status foreign = from_grpc({grpc::StatusCode::UNAVAILABLE, "x", message.SerializeAsString()});
  EXPECT_EQ(details_of(foreign).reason, ErrorReason::kUnspecified);
}

}  // namespace
}  // namespace segserve::wire
