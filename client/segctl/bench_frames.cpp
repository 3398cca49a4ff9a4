// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_frames.hpp"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/segctl/batch_inputs.hpp"
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

/// The files that the flags name, themselves or by their folder.
absl::StatusOr<std::vector<std::string>> input_files(const BenchArguments& arguments) {
  std::vector<std::string> files;
  for (const std::string& path : arguments.inputs) {
    std::error_code error;
    if (!std::filesystem::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    ASSIGN_OR_RETURN(const auto found, cloud_files_in(path));
    if (found.empty()) return absl::InvalidArgumentError(fmt::format("there is no file of a cloud in {}", path));
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

absl::StatusOr<SharedClouds> load_files(const BenchArguments& arguments) {
  if (arguments.speed_flag->count() > 0) {
    return absl::InvalidArgumentError("--speed is for one recording, or one folder that tells the times of its clouds");
  }
  SharedClouds clouds;
  ASSIGN_OR_RETURN(const auto files, input_files(arguments));
  for (const std::string& path : files) {
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
  if (!arguments.inputs.empty() && !arguments.has_recording() && arguments.recording.given()) {
    return absl::InvalidArgumentError("--topic, --color-topic and --camera-info-topic are for one recording");
  }
  if (arguments.has_recording()) {
    ASSIGN_OR_RETURN(source, load_recording(arguments.inputs.front(), arguments.recording));
  } else if (arguments.has_sequence()) {
    ASSIGN_OR_RETURN(source, load_sequence(arguments.inputs.front()));
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
