// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/stream_arguments.hpp"

#include <chrono>

#include "client/segctl/input_file.hpp"
#include "client/segctl/view_flag.hpp"
#include "command_line/number_range.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr double kStreamTimeout = 10;
/// The credit that is asked of the server: the largest frame is not known before it is read.
constexpr std::uint64_t kWantedStreamBytes = std::uint64_t{256} << 20U;
constexpr std::chrono::seconds kLongestStreamOutage{10};

}  // namespace

void StreamArguments::add_to(CLI::App& app) {
  app.add_option("INPUT", inputs, "files of clouds, a folder of them, or a recording (MCAP, ROS 1 bag)")
      ->type_name("FILE");
  const std::string scene = "Synthetic scene";
  CLI::Option* moving_flag =
      app.add_flag("--moving", moving, "a table that moves, as segctl synth --moving makes it, instead of INPUT")
          ->group(scene);
  app.add_option("--frames", frames, "how many frames, 1 to 100000")
      ->needs(moving_flag)
      ->capture_default_str()
      ->group(scene);
  app.add_option("--seed", seed, "seed of everything that is random")
      ->needs(moving_flag)
      ->capture_default_str()
      ->group(scene);
  app.add_option("--width", width, "width of the image, pixels")
      ->needs(moving_flag)
      ->capture_default_str()
      ->group(scene);
  app.add_option("--height", height, "height of the image, pixels")
      ->needs(moving_flag)
      ->capture_default_str()
      ->group(scene);

  const std::string timing = "Timing";
  CLI::Option* rate_flag =
      app.add_option(
             "--rate", rate,
             "frames a second, 0.01 to 1000; default: the times of a recording, of a folder's sequence.json or names, "
             "and of --moving, else 10")
          ->type_name("HZ")
          ->check(number_range(0.01, 1000.0))
          ->group(timing);
  app.add_option("--speed", speed, "factor on the speed of these times, 0.01 to 1000")
      ->check(number_range(0.01, 1000.0))
      ->capture_default_str()
      ->excludes(rate_flag)
      ->group(timing);
  app.add_flag("--loop", loop, "begin again at the end, until Ctrl-C or --duration")->group(timing);
  app.add_option("--duration", duration, "end after so many seconds")
      ->type_name("SECONDS")
      ->check(number_range(0.1, 1e7))
      ->group(timing);
  app.add_flag("--wait", waits,
               "when the server is behind, frames wait and the stream gets late; default: the oldest frame that waits "
               "is dropped")
      ->group(timing);

  options.add_to(app);
  app.add_flag("--track", track, "let objects keep their ids from frame to frame")->group("Segmentation");
  app.add_option("--view", view, "where the sensor is: camera, world, or world:X,Y,Z in meters")
      ->type_name("VIEW")
      ->group("Segmentation");
  recording.add_to(app);
  server.add_to(app, kStreamTimeout);
  app.add_flag("--fallback-local", fallback_local, "segment in this process if no server is in reach")->group("Server");
  codec.add_to(app, "default: planar", "Server");
  app.add_option("--html-live", html_live,
                 "serve a page that shows the newest frame in 3D, such as 127.0.0.1:8081; a browser that is slow skips "
                 "frames")
      ->type_name("HOST:PORT")
      ->group("Output");
  app.add_flag("--html-live-for-anyone", html_live_for_anyone,
               "let --html-live listen beyond this machine: whoever reaches it sees the frames")
      ->group("Output");
  json.add_to(app, "write how the stream went as one JSON object");
  app.add_flag("-q,--quiet", quiet, "print no table and no summary")->group("Output");
}

absl::Status StreamArguments::check_combination() const {
  if (moving == !inputs.empty()) {
    return absl::InvalidArgumentError(moving ? "INPUT and --moving exclude each other"
                                             : "INPUT is required, or --moving (see segctl stream --help)");
  }
  if (moving && (!view.empty() || recording.given())) {
    return absl::InvalidArgumentError("--view and --topic do not go with --moving");
  }
  for (const std::string& input : inputs) {
    if (loop && input == "-") return absl::InvalidArgumentError("--loop cannot read standard input twice");
  }
  if (html_live_for_anyone && html_live.empty()) {
    return absl::InvalidArgumentError("--html-live-for-anyone needs --html-live");
  }
  return absl::OkStatus();
}

absl::StatusOr<FeedOptions> StreamArguments::feed_options() const {
  FeedOptions feed{.inputs = inputs, .recording = recording, .view = std::nullopt, .moving = std::nullopt};
  if (!view.empty()) {
    ASSIGN_OR_RETURN(feed.view, parse_view(view));
  }
  if (!moving) return feed;
  synth::MovingOptions& scene = feed.moving.emplace();
  scene.frames = frames;
  scene.scene.seed = seed;
  scene.scene.width = width;
  scene.scene.height = height;
  return feed;
}

absl::StatusOr<client::StreamOptions> StreamArguments::stream_options() const {
  client::StreamOptions stream;
  stream.client_name = "segctl stream";
  ASSIGN_OR_RETURN(stream.options, options.options());
  ASSIGN_OR_RETURN(const auto encoding, codec.options());
  stream.codec = encoding.value_or(wire::CodecOptions{});
  const bool draws = !html_live.empty();
  stream.outputs = {.labels = true, .supervoxels = draws, .tree = draws};
  stream.outputs.compression = answer_compression(encoding);
  if (track) stream.tracking = TrackOptions();
  stream.order = client::Order::kSent;
  stream.when_behind = waits ? client::WhenBehind::kBlock : client::WhenBehind::kDropOldest;
  stream.max_in_flight = 2;
  stream.max_waiting = 1;
  stream.wanted_bytes = kWantedStreamBytes;
  stream.fallback_to_local = fallback_local;
  stream.longest_outage = kLongestStreamOutage;
  ASSIGN_OR_RETURN(stream.frame_timeout, server.timeout());
  return stream;
}

absl::StatusOr<std::optional<AgentAddress>> StreamArguments::page_address() const {
  if (html_live.empty()) return std::nullopt;
  ASSIGN_OR_RETURN(const AgentAddress address, parse_agent_address("--html-live", html_live));
  if (!html_live_for_anyone && !address.is_loopback()) {
    return absl::InvalidArgumentError(fmt::format(
        "--html-live {}: whoever reaches this address sees the frames; --html-live-for-anyone allows that", html_live));
  }
  return address;
}

std::string StreamArguments::title() const {
  if (moving) return "a moving table";
  return inputs.size() == 1 ? input_name(inputs.front()) : fmt::format("{} files", inputs.size());
}

}  // namespace segserve::segctl
