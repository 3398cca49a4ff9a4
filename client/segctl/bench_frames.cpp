// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_frames.hpp"

#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/bench_recording.hpp"
#include "client/segctl/input_file.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

using SharedClouds = std::vector<std::shared_ptr<const Cloud>>;

absl::StatusOr<SharedClouds> load_files(const BenchArguments& arguments) {
  if (arguments.recording.given() || arguments.speed_flag->count() > 0) {
    return absl::InvalidArgumentError("--topic, --color-topic, --camera-info-topic and --speed are for one recording");
  }
  SharedClouds clouds;
  for (const std::string& path : arguments.inputs) {
    ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
    auto scene = codec::decode_cloud(std::as_bytes(std::span(bytes)), {});
    if (!scene.ok()) return with_prefix(input_name(path), scene.status());
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene->cloud)));
  }
  return clouds;
}

absl::StatusOr<SharedClouds> make_scenes(const BenchArguments& arguments) {
  synth::SceneOptions options;
  int end = 0;
  const bool parsed = std::sscanf(arguments.size.c_str(), "%5ux%5u%n", &options.width, &options.height, &end) == 2;
  if (!parsed || static_cast<std::size_t>(end) != arguments.size.size()) {
    return absl::InvalidArgumentError(fmt::format("--size {}: must be WIDTHxHEIGHT, e.g. 640x480", arguments.size));
  }
  SharedClouds clouds;
  for (std::size_t i = 0; i < arguments.scenes; ++i) {
    options.seed = arguments.seed + i;
    ASSIGN_OR_RETURN(auto scene, synth::make_tabletop(options));
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene.cloud)));
  }
  return clouds;
}

}  // namespace

absl::StatusOr<bench::FrameSource> frame_source(const BenchArguments& arguments) {
  bench::FrameSource source;
  if (arguments.has_recording()) {
    ASSIGN_OR_RETURN(source, load_recording(arguments.inputs.front(), arguments.recording));
  } else {
    ASSIGN_OR_RETURN(source.clouds, arguments.inputs.empty() ? make_scenes(arguments) : load_files(arguments));
  }
  ASSIGN_OR_RETURN(const auto codecs, arguments.codec.list());
  for (const wire::CodecOptions& options : codecs) {
    source.encodings.push_back(
        {std::string(wire::info(options.codec).name),
         [options](std::shared_ptr<const Cloud> cloud) { return client::cloud_payload(std::move(cloud), options); },
         answer_compression(options)});
  }
  return source;
}

}  // namespace segserve::segctl
