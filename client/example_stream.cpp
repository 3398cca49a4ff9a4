// SPDX-License-Identifier: Apache-2.0
// A robot that wants the newest scene. It sends every frame of its camera, drops the oldest when it is behind, and has
// no use for the segments of a scene that it saw more than half a second ago.
//
//     example_stream robot-a:50051,robot-b:50051
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "core/lab/synth/scene.hpp"
#include "segserve/client/client.hpp"

using namespace segserve;  // NOLINT(google-build-using-namespace): an example
using namespace std::chrono_literals;

int main(int argc, char** argv) {
  const auto client = client::Client::connect({.address = argc > 1 ? argv[1] : "127.0.0.1:50051"});
  if (!client.ok()) return 2;
  auto stream = client->open_stream({.when_behind = client::WhenBehind::kDropOldest, .max_in_flight = 2});
  if (!stream.ok()) return 2;

  std::thread camera([&stream] {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto scene = synth::make_tabletop({.seed = seed, .width = 160, .height = 120});
      if (!stream->send(scene->cloud, {.frame_id = "camera", .time_to_live = 500ms}).ok()) break;
    }
    stream->finish();
  });

  while (const auto outcome = stream->next()) {
    if (outcome->kind == client::OutcomeKind::kResult) {
      std::printf("frame %lu: %u segments\n", outcome->sequence, outcome->result->segmentation.segments);
    } else {
      std::printf("frame %lu: %s\n", outcome->sequence, std::string(outcome->status.message()).c_str());
    }
  }
  camera.join();
}
