// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/track_flags.hpp"

#include <algorithm>

#include "command_line/number_range.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

void TrackFlags::add_to(CLI::App& app, const std::string& description) {
  const std::string group = "Objects over time";
  CLI::Option* flag = app.add_flag("--track", track, description)->group(group);
  app.add_option("--rate", rate, "frames a second of a folder without sequence.json and without times as names")
      ->check(number_range(0.01, 1000.0))
      ->capture_default_str()
      ->needs(flag)
      ->group(group);
  app.add_flag("--no-poses", no_poses, "do not use the poses of sequence.json: estimate how the view moves")
      ->needs(flag)
      ->group(group);
  app.add_option("--max-speed", options.max_speed, "highest speed of an object, m/s, 0 to 100")
      ->capture_default_str()
      ->needs(flag)
      ->group(group);
  app.add_option("--keep-lost", options.keep_lost, "frames for which an object out of sight keeps its id, 0 to 1000")
      ->capture_default_str()
      ->needs(flag)
      ->group(group);
}

absl::Status TrackFlags::check() const {
  std::string text;
  for (const FieldViolation& fault : violations(options)) {
    std::string flag = fault.field;
    std::ranges::replace(flag, '_', '-');
    text += fmt::format("{}--{}: {}", text.empty() ? "" : "; ", flag, fault.description);
  }
  return text.empty() ? absl::OkStatus() : absl::InvalidArgumentError(text);
}

std::vector<std::uint32_t> shown_labels(const client::Result& result) {
  std::vector<std::uint32_t> labels = result.segmentation.labels;
  if (!result.tracks) return labels;
  const std::vector<std::uint64_t>& ids = result.tracks->track_of_segment;
  for (std::uint32_t& label : labels) label = label == 0 ? 0 : static_cast<std::uint32_t>(ids[label - 1]);
  return labels;
}

}  // namespace segserve::segctl
