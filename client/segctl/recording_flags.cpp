// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/recording_flags.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "segserve/client/topic_reader.hpp"

namespace segserve::segctl {

void RecordingFlags::add_to(CLI::App& app) {
  app.add_option("--topic", topic, "topic whose clouds or depth images are taken; default: the only one that can be")
      ->type_name("NAME")
      ->group(kGroup);
  app.add_option("--color-topic", color_topic, "topic with the colors of depth images, aligned and of the same size")
      ->type_name("NAME")
      ->group(kGroup);
  app.add_option("--camera-info-topic", camera_info_topic,
                 "topic with the camera of depth images; default: camera_info beside their topic")
      ->type_name("NAME")
      ->group(kGroup);
}

void RecordingFlags::add_output_to(CLI::App& app) {
  app.add_flag("--only-topic", only_topic, "leave the other topics out of the recording that -o writes")->group(kGroup);
}

bool is_recording_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::array<char, 16> begin{};
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), begin.size());
  return client::is_recording(std::string_view(begin.data(), static_cast<std::size_t>(file.gcount())));
}

}  // namespace segserve::segctl
