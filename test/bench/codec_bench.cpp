// SPDX-License-Identifier: Apache-2.0
// The cost of each codec: bytes of a frame on the wire, and the time to encode and to decode them, as means of ten OSD
// frames or, if there are none, of ten synthetic frames. The peer is the codec planar in the same run.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/codec_message.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::bench {
namespace {

constexpr int kFrames = 10;
constexpr int kRounds = 5;  // The fastest round counts.
constexpr codec::DecodeLimits kLimits{.draco = true};

/// The CPU time of this thread, so that other programs on the machine do not count.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

/// Every second scene from learn19 to learn37: 640 x 480, 189,129 finite points on average.
std::vector<Cloud> real_frames() {
  std::vector<Cloud> frames;
  for (int scene = 19; scene < 19 + 2 * kFrames; scene += 2) {
    const auto path = std::filesystem::path(SEGSERVE_DATA_DIR) / fmt::format("osd/learn/learn{}.pcd", scene);
    auto frame = codec::load_cloud(path);
    if (!frame.ok()) return {};
    frames.push_back(std::move(frame->cloud));
  }
  return frames;
}

std::vector<Cloud> synthetic_frames() {
  std::vector<Cloud> frames;
  for (std::uint64_t seed = 1; seed <= kFrames; ++seed) {
    frames.push_back(synth::make_tabletop({.seed = seed})->cloud);
  }
  return frames;
}

double finite_points(const std::vector<Cloud>& frames) {
  double finite = 0;
  for (const Cloud& cloud : frames) {
    for (std::size_t i = 0; i < cloud.size(); ++i) finite += is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) ? 1 : 0;
  }
  return finite / static_cast<double>(frames.size());
}

/// Means over the frames.
struct Cost {
  double bytes = 0;  ///< Size of the whole message.
  double encode_ms = 0;
  double decode_ms = 0;
};

absl::StatusOr<Cost> measure(const std::vector<Cloud>& frames, const wire::CodecOptions& options) {
  Cost sum;
  for (const Cloud& cloud : frames) {
    double encode_ms = std::numeric_limits<double>::max();
    double decode_ms = encode_ms;
    for (int round = 0; round < kRounds; ++round) {
      const double start = cpu_ms();
      const auto message = wire::to_message(cloud, options);
      const double encoded = cpu_ms();
      if (!message.ok()) return message.status();
      const auto decoded = wire::decode_cloud(*message, kLimits);
      const double end = cpu_ms();
      if (!decoded.ok()) return decoded.status();
      encode_ms = std::min(encode_ms, encoded - start);
      decode_ms = std::min(decode_ms, end - encoded);
      if (round == 0) sum.bytes += static_cast<double>(message->ByteSizeLong());
    }
    sum.encode_ms += encode_ms;
    sum.decode_ms += decode_ms;
  }
  const auto count = static_cast<double>(frames.size());
  return Cost{sum.bytes / count, sum.encode_ms / count, sum.decode_ms / count};
}

struct Row {
  std::string name;
  wire::CodecOptions options;
};

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const wire::CodecInfo& codec : wire::codecs()) {
    if (codec.codec == wire::Codec::kQuantised) {
      for (const double millimeters : {0.1, 0.5, 1.0, 10.0}) {
        all.push_back({fmt::format("{}, {} mm", codec.name, millimeters),
                       {.codec = codec.codec, .error_bound = millimeters / 1000}});
      }
    } else {
      all.push_back({std::string(codec.name), {.codec = codec.codec}});
    }
  }
  return all;
}

int run() {
  std::vector<Cloud> frames = real_frames();
  const bool real = !frames.empty();
  if (!real) frames = synthetic_frames();
  const double finite = finite_points(frames);
  fmt::print("mean of {} {} frames, {} points, {:.0f} of them finite; CPU time of one thread\n\n", frames.size(),
             real ? "OSD" : "synthetic", frames[0].size(), finite);
  fmt::print("| codec | kB | bytes/finite point | of planar | encode ms | decode ms |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- |\n");
  double planar_bytes = 0;
  for (const Row& row : rows()) {
    const auto cost = measure(frames, row.options);
    if (!cost.ok()) {
      fmt::print(stderr, "{}: {}\n", row.name, std::string(cost.status().message()));
      return 1;
    }
    if (planar_bytes == 0) planar_bytes = cost->bytes;
    fmt::print("| {} | {:.0f} | {:.2f} | {:.3f} | {:.1f} | {:.1f} |\n", row.name, cost->bytes / 1000,
               cost->bytes / finite, cost->bytes / planar_bytes, cost->encode_ms, cost->decode_ms);
  }
  return 0;
}

}  // namespace
}  // namespace segserve::bench

int main() { return segserve::bench::run(); }
