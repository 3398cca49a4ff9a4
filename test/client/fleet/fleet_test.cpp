// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/fleet.hpp"

#include <chrono>
#include <future>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

HostLookup answers(std::vector<HostAddress> addresses) {
  return [addresses = std::move(addresses)](const HostName&) { return addresses; };
}

TEST(Fleet, KnowsAddressesWithoutALookup) {
  Fleet fleet({"10.0.0.1:7", "localhost:7"}, true, [](const HostName&) -> absl::StatusOr<std::vector<HostAddress>> {
    ADD_FAILURE() << "there is nothing to look up";
    return absl::InternalError("");
  });
  EXPECT_EQ(fleet.servers().servers.size(), 2U);
}

TEST(Fleet, WaitsForTheFirstAnswer) {
  Fleet fleet({"robots:7"}, true, answers({{.text = "10.0.0.1"}, {.text = "10.0.0.2"}}));
  EXPECT_EQ(fleet.wait_for_servers(Clock::now() + seconds(60), false).servers.size(), 2U);
}

TEST(Fleet, TellsOfTroubleUnlessTheCallerIsPatient) {
  Fleet fleet({"robots:7"}, true, [](const HostName&) { return absl::UnavailableError("no such name"); });
  const ServerList list = fleet.wait_for_servers(Clock::now() + seconds(60), false);
  EXPECT_TRUE(list.servers.empty());
  EXPECT_THAT(std::string(list.trouble.message()), HasSubstr("no such name"));
  const Time until = Clock::now() + milliseconds(50);
  EXPECT_TRUE(fleet.wait_for_servers(until, true).servers.empty());
  EXPECT_GE(Clock::now(), until);
}

TEST(Fleet, TellsSubscribersOfChanges) {
  std::promise<void> may_answer;
  Fleet fleet({"robots:7"}, true,
              [ready = may_answer.get_future().share()](const HostName&) -> absl::StatusOr<std::vector<HostAddress>> {
                ready.wait();
                return std::vector<HostAddress>{{.text = "10.0.0.1"}};
              });
  std::promise<std::size_t> told;
  const auto subscription = fleet.subscribe([&] { told.set_value(fleet.servers().servers.size()); });
  may_answer.set_value();
  EXPECT_EQ(told.get_future().get(), 1U);
  fleet.unsubscribe(subscription);
}

TEST(Fleet, DoesNotWaitForALookupWhenItIsDestroyed) {
  auto may_end = std::make_shared<std::promise<void>>();
  std::promise<void> began;
  {
    Fleet fleet(
        {"robots:7"}, true,
        [&began, end = may_end->get_future().share()](const HostName&) -> absl::StatusOr<std::vector<HostAddress>> {
          began.set_value();
          end.wait();
          return absl::UnavailableError("too late");
        });
    began.get_future().wait();
  }  // a fleet that waits never gets any further
  may_end->set_value();
}

TEST(HostLookup, FindsThisMachine) {
  const auto addresses = look_up_host({.host = "localhost", .port = "1"});
  ASSERT_TRUE(addresses.ok()) << addresses.status();
  EXPECT_FALSE(addresses->empty());
  EXPECT_TRUE(absl::IsUnavailable(look_up_host({.host = "no.such.host.invalid", .port = "1"}).status()));
}

}  // namespace
}  // namespace segserve::client
