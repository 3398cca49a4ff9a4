// SPDX-License-Identifier: Apache-2.0
// The load test behind `segctl bench`, in one process with the server.
#include "client/load_test/load.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/lab/synth/scene.hpp"
#include "gmock/gmock.h"
#include "proto/wire/codec_message.hpp"
#include "server/server.hpp"

namespace segserve::bench {
namespace {

std::vector<std::shared_ptr<const Cloud>> scenes(std::size_t count) {
  std::vector<std::shared_ptr<const Cloud>> clouds;
  for (std::size_t i = 0; i < count; ++i) {
    synth::SceneOptions options;
    options.width = 160;
    options.height = 120;
    options.seed = i + 1;
    clouds.push_back(std::make_shared<const Cloud>(synth::make_tabletop(options).value().cloud));
  }
  return clouds;
}

/// All encodings that a server accepts without flags.
std::vector<Encoding> all_encodings() {
  std::vector<Encoding> encodings;
  for (const wire::CodecInfo& info : wire::codecs()) {
    if (info.codec == wire::Codec::kDraco) continue;
    const wire::CodecOptions options{.codec = info.codec};
    encodings.push_back(
        {.name = std::string(info.name),
         .encode =
             [options](std::shared_ptr<const Cloud> cloud) { return client::cloud_payload(std::move(cloud), options); },
         .answer_compression = wire::Compression::kZstd});
  }
  return encodings;
}

TEST(Load, ManyClientsWithAllCodecsGetTheirLabelsAndTheirShare) {
  server::ServerOptions settings;
  settings.listen = "127.0.0.1:0";
  settings.workers = 2;
  const auto server = server::Server::start(settings).value();
  LoadOptions options;
  options.client.address = server->address();
  options.stream.outputs = {.labels = true};
  options.stream.max_in_flight = 2;
  options.stream.frame_timeout = std::chrono::seconds(120);
  options.clients = 32;
  options.warm_up = std::chrono::seconds(2);  // all of them are connected then
  options.duration = std::chrono::seconds(5);
  options.verify = true;

  const FrameSource source{scenes(3), all_encodings()};
  const auto result = run_load(options, source, prepare_frames(options, source).value(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  const Report& report = result->total;
  EXPECT_THAT(report.errors, testing::IsEmpty());
  EXPECT_EQ(report.mismatches, 0U);
  EXPECT_EQ(report.verified, report.sent);
  ASSERT_EQ(report.finished_of_client.size(), 32U);
  EXPECT_GE(std::ranges::min(report.finished_of_client), 2U);
  // On a quiet machine it is about 90; one that does other work delays the threads of single clients.
  EXPECT_GE(report.least_share_percent(), 30);
  ASSERT_EQ(result->codecs.size(), source.encodings.size());
  for (const Report& codec : result->codecs) EXPECT_GT(codec.results, 0U);
}

TEST(Load, AFrameThatCannotBeEncodedIsAnErrorBeforeTheRun) {
  Cloud cloud = *scenes(1).front();
  cloud.x.resize(cloud.x.size() - 1);
  LoadOptions options;
  options.client.address = "127.0.0.1:1";
  const auto frames = prepare_frames(options, {{std::make_shared<const Cloud>(cloud)}, all_encodings()});
  EXPECT_TRUE(absl::IsInvalidArgument(frames.status())) << frames.status();
}

}  // namespace
}  // namespace segserve::bench
