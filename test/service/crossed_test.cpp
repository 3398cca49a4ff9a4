// SPDX-License-Identifier: Apache-2.0
// Combines every way of asking with every codec, every output and every place where a frame may be computed. Every
// combination must give the result of segserve::segment for the cloud that the payload decodes to, or the same error.
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "gtest/gtest.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/request_message.hpp"
#include "segserve/client/client.hpp"
#include "segserve/codec/draco.hpp"
#include "segserve/prompts.hpp"
#include "segserve/segment.hpp"
#include "server/server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve {
namespace {

using client::Client;
using client::Result;
using wire::Outputs;

// The options differ from the defaults, so that a way of asking that loses them gives another result.
constexpr Options kOptions{.voxel_resolution = 0.012, .seed_resolution = 0.09, .threshold = 0.4, .threads = 2};

/// A way of asking for a frame.
enum class Way { kCall, kStream, kStreamWithOwnFrames };
constexpr std::array kWays{Way::kCall, Way::kStream, Way::kStreamWithOwnFrames};

std::string_view name(Way way) {
  switch (way) {
    case Way::kCall:
      return "unary call";
    case Way::kStream:
      return "stream";
    case Way::kStreamWithOwnFrames:
      return "stream whose frames say outputs and options";
  }
  return "";
}

struct OutputsRow {
  std::string_view name;
  Outputs outputs;
};
constexpr Outputs kNothing{.labels = false};
constexpr std::array kOutputs{
    OutputsRow{"labels", {.labels = true}},
    OutputsRow{"supervoxels", {.labels = false, .supervoxels = true}},
    OutputsRow{"tree", {.labels = false, .tree = true}},
    OutputsRow{"segments", {.labels = false, .segments = true}},
    OutputsRow{"everything", {.labels = true, .supervoxels = true, .tree = true, .segments = true}},
    OutputsRow{
        "everything, zstd",
        {.labels = true, .supervoxels = true, .tree = true, .segments = true, .compression = wire::Compression::kZstd}},
    OutputsRow{"nothing", kNothing},
};

/// The scene in one codec, and its segmentation.
struct EncodedScene {
  std::string_view codec;
  client::Payload payload;
  Segmentation expected;       ///< the segmentation of the decoded payload
  PromptedSelection selected;  ///< by prompts()
};

/// On the box, and on the wall beside it.
Prompts prompts() { return {.include = {Pixel{40, 30}, Eigen::Vector3d(-0.1, -0.1, 0.8)}, .exclude = {Pixel{80, 60}}}; }

EncodedScene encode(const CloudView& cloud, const wire::CodecInfo& codec) {
  const v1::Cloud message = wire::to_message(cloud, {.codec = codec.codec}).value();
  const wire::DecodedCloud decoded = wire::decode_cloud(message, {.draco = true}).value();
  Segmentation expected = segment(decoded.cloud, kOptions).value();
  EXPECT_TRUE(describe(decoded.cloud, 1, {}, expected).ok());
  EXPECT_GE(expected.segments, 2U) << codec.name << ": the scene tests nothing";
  PromptedSelection selected = select_by_prompts(decoded.cloud, expected, std::nullopt, prompts()).value();
  EXPECT_TRUE(describe(decoded.cloud, 1, {}, selected).ok());
  return {codec.name, client::cloud_payload(cloud, {.codec = codec.codec}).value(), std::move(expected),
          std::move(selected)};
}

/// The scene in every codec that this build has.
const std::vector<EncodedScene>& encoded_scenes() {
  static const std::vector<EncodedScene> scenes = [] {
    std::vector<EncodedScene> made;
    const Cloud cloud = server::wall_with_box(96, 72);
    for (const wire::CodecInfo& codec : wire::codecs()) made.push_back(encode(cloud, codec));
    return made;
  }();
  return scenes;
}

/// The names of the parts of a result that are wrong; empty if there are none. A part that was not asked for must be
/// absent, except that a result that was computed in this process has all arrays.
std::string differences(const Result& result, const Segmentation& expected, const Outputs& asked) {
  const Segmentation& actual = result.segmentation;
  std::string names;
  const auto check = [&names](std::string_view part, bool is_right) {
    if (!is_right) names += fmt::format("{}{}", names.empty() ? "" : ", ", part);
  };
  const auto check_array = [&](std::string_view part, bool is_asked, const auto& array, const auto& wanted) {
    const bool may_be_absent = !is_asked && !result.in_this_process;
    check(part, may_be_absent ? array.empty() : array == wanted);
  };
  check_array("labels", asked.labels, actual.labels, expected.labels);
  check_array("supervoxels", asked.supervoxels, actual.supervoxels, expected.supervoxels);
  check("tree", actual.tree == (asked.tree || result.in_this_process ? expected.tree : MergeTree()));
  check("statistics", asked.segments ? actual.statistics == expected.statistics : actual.statistics.empty());
  check("number of segments", actual.segments == expected.segments);
  check("number of supervoxels", result.supervoxels == expected.tree.leaf_count());
  check("number of voxels", actual.voxels == expected.voxels);
  check("numbers of points", result.points == expected.labels.size() &&
                                 actual.finite_points == expected.finite_points &&
                                 actual.segmented_points == expected.segmented_points);
  check("threshold", actual.threshold == expected.threshold);
  check("lambda", actual.lambda == expected.lambda);
  return names;
}

/// Asks in one way for frames.
class Asker {
 public:
  Asker(const Client& client, Way way, const Outputs& outputs, bool fallback_to_local,
        std::optional<Prompts> prompts = std::nullopt)
      : client_(client), way_(way), outputs_(outputs), prompts_(std::move(prompts)) {
    if (way == Way::kCall) return;
    client::StreamOptions options{.wait_for_server = false, .fallback_to_local = fallback_to_local};
    if (way == Way::kStream) {
      options.options = kOptions;
      options.outputs = outputs;
    } else {
      options.outputs = kNothing;
    }
    stream_ = client.open_stream(std::move(options)).value();
  }

  absl::StatusOr<Result> ask(const client::Payload& payload) {
    if (!stream_) return client_.segment_payload(payload, kOptions, {.outputs = outputs_, .prompts = prompts_});
    client::FrameOptions frame{.prompts = prompts_};
    if (way_ == Way::kStreamWithOwnFrames) {
      frame.options = kOptions;
      frame.outputs = outputs_;
    }
    if (const auto sequence = stream_->send(payload, std::move(frame)); !sequence.ok()) return sequence.status();
    std::optional<client::Outcome> outcome = stream_->next();
    if (outcome->kind != client::OutcomeKind::kResult) return outcome->status;
    return *std::move(outcome->result);
  }

 private:
  const Client& client_;
  const Way way_;
  const Outputs outputs_;
  const std::optional<Prompts> prompts_;
  std::optional<client::Stream> stream_;
};

/// The places where a frame may be computed.
struct Place {
  std::string_view name;
  bool has_server;
  bool fallback_to_local;
};
void PrintTo(const Place& place, std::ostream* out) { *out << place.name; }

class Crossed : public testing::TestWithParam<Place> {
 protected:
  Crossed() : client_(connect(enable_draco(true))), client_without_draco_(connect(enable_draco(false))) {}

  /// Asks for the payload in every way and for every output. `judge` returns what is wrong with an answer, or an empty
  /// string.
  template <typename Judge>
  void ask_all(const Client& client, std::string_view codec, const client::Payload& payload, Judge judge,
               const std::optional<Prompts>& asked = std::nullopt) const {
    for (const Way way : kWays) {
      for (const OutputsRow& row : kOutputs) {
        Asker asker(client, way, row.outputs, GetParam().fallback_to_local, asked);
        const std::string fault = judge(asker.ask(payload), row.outputs);
        if (!fault.empty()) ADD_FAILURE() << fmt::format("{}, {}, {}: {}", name(way), codec, row.name, fault);
      }
    }
  }

  std::vector<std::unique_ptr<server::Server>> servers_;
  Client client_, client_without_draco_;

 private:
  static server::ServerOptions enable_draco(bool enable) {
    server::ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.workers = 1;
    options.threads = 2;
    options.drain_delay = std::chrono::milliseconds(0);
    options.enable_draco = enable;
    return options;
  }

  Client connect(const server::ServerOptions& options) {
    std::string address = "127.0.0.1:1";  // Nothing listens here.
    if (GetParam().has_server) {
      servers_.push_back(server::Server::start(options).value());
      address = servers_.back()->address();
    }
    return Client::connect({.address = address, .fallback_to_local = GetParam().fallback_to_local}).value();
  }
};

constexpr Place kServer{"Server", true, false};
constexpr Place kServerAndFallback{"ServerAndFallback", true, true};
constexpr Place kFallback{"FallbackWithoutServer", false, true};
constexpr Place kNowhere{"NeitherServerNorFallback", false, false};

std::string place_name(const testing::TestParamInfo<Place>& info) { return std::string(info.param.name); }

/// Says which status came instead of the expected one.
std::string unexpected_status(const absl::Status& status) { return fmt::format("got {}", status.ToString()); }

/// Empty if a status has the expected code and message; else what unexpected_status says.
std::string compare(const absl::Status& status, const absl::Status& expected) {
  const bool is_expected = status.code() == expected.code() && status.message() == expected.message();
  return is_expected ? "" : unexpected_status(status);
}

class CrossedResults : public Crossed {};
INSTANTIATE_TEST_SUITE_P(Places, CrossedResults, testing::Values(kServer, kServerAndFallback, kFallback), place_name);

TEST_P(CrossedResults, AreThoseOfSegmentOnTheDecodedPayload) {
  for (const EncodedScene& scene : encoded_scenes()) {
    ask_all(client_, scene.codec, scene.payload, [&](const absl::StatusOr<Result>& result, const Outputs& outputs) {
      if (!result.ok()) return unexpected_status(result.status());
      if (result->in_this_process == GetParam().has_server) return std::string("it was computed in the wrong place");
      const std::string parts = differences(*result, scene.expected, outputs);
      return parts.empty() ? "" : fmt::format("it differs in {}", parts);
    });
  }
}

/// The server selects the same as this process, however and in whichever codec the cloud comes.
TEST_P(CrossedResults, SelectAsHere) {
  for (const EncodedScene& scene : encoded_scenes()) {
    ask_all(
        client_, scene.codec, scene.payload,
        [&](const absl::StatusOr<Result>& result, const Outputs& outputs) {
          if (!result.ok()) return unexpected_status(result.status());
          if (!result->selection) return std::string("it has no selection");
          PromptedSelection expected = scene.selected;
          if (!outputs.labels && !result->in_this_process) expected.labels.clear();
          if (!outputs.segments) expected.statistics.reset();
          if (*result->selection != expected) return std::string("the selection differs");
          const std::string parts = differences(*result, scene.expected, outputs);
          return parts.empty() ? "" : fmt::format("it differs in {}", parts);
        },
        prompts());
  }
}

TEST_P(CrossedResults, PromptsThatSelectNothingAreRefusedAlike) {
  const EncodedScene& scene = encoded_scenes().front();
  const std::vector<Prompt> many(kMostPrompts + 1, Pixel{0, 0});
  const std::pair<Prompts, std::string_view> cases[] = {
      {{}, "prompts.include: is empty"},
      {{.include = many}, "prompts.include: has 65 places, but may have at most 64"},
      {{.include = {Pixel{95, 0}, Pixel{0, 72}}},
       "prompts: pixel 95,0 has no segmented point; pixel 0,72 is outside the image of 96 x 72 pixels"}};
  for (const auto& [asked, text] : cases) {
    ask_all(
        client_, scene.codec, scene.payload,
        [&text](const absl::StatusOr<Result>& result, const Outputs&) {
          const bool is_expected = absl::IsInvalidArgument(result.status()) &&
                                   wire::details_of(result.status()).reason == wire::ErrorReason::kInvalidField &&
                                   std::string(result.status().message()).find(text) != std::string::npos;
          return is_expected ? "" : unexpected_status(result.status());
        },
        asked);
  }
}

/// The error of a cloud that cannot be segmented has the same message, whichever way the cloud comes.
TEST_P(CrossedResults, CloudsThatCannotBeSegmentedAreRefusedAlike) {
  const std::vector<Cloud> clouds = {server::equal_points(9, 0, 0, -1),
                                     server::equal_points(9, 1e30F, 0, 0, View::world())};
  for (const Cloud& cloud : clouds) {
    const absl::Status expected = segment(cloud, kOptions).status();
    ASSERT_EQ(expected.code(), absl::StatusCode::kInvalidArgument);
    const client::Payload payload = client::cloud_payload(cloud).value();
    ask_all(client_, "a bad cloud", payload,
            [&](const absl::StatusOr<Result>& result, const Outputs&) { return compare(result.status(), expected); });
  }
}

class CrossedRefusals : public Crossed {};
INSTANTIATE_TEST_SUITE_P(Places, CrossedRefusals, testing::Values(kServer, kServerAndFallback), place_name);

TEST_P(CrossedRefusals, OfDracoWhereItIsNotEnabled) {
  if (!codec::draco_is_built()) GTEST_SKIP() << "built without Draco";
  const Cloud cloud = server::wall_with_box(96, 72);
  const v1::Cloud message = wire::to_message(cloud, {.codec = wire::Codec::kDraco}).value();
  const absl::Status expected = wire::check_kind(message, {.draco = false});
  ASSERT_EQ(expected.code(), absl::StatusCode::kInvalidArgument);
  ask_all(client_without_draco_, "draco", client::cloud_payload(cloud, {.codec = wire::Codec::kDraco}).value(),
          [&](const absl::StatusOr<Result>& result, const Outputs&) { return compare(result.status(), expected); });
}

class CrossedAbsence : public Crossed {};
INSTANTIATE_TEST_SUITE_P(Places, CrossedAbsence, testing::Values(kNowhere), place_name);

TEST_P(CrossedAbsence, IsUnavailable) {
  for (const EncodedScene& scene : encoded_scenes()) {
    ask_all(client_, scene.codec, scene.payload, [](const absl::StatusOr<Result>& result, const Outputs&) {
      return absl::IsUnavailable(result.status()) ? "" : unexpected_status(result.status());
    });
  }
}

}  // namespace
}  // namespace segserve
