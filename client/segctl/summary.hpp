#pragma once

#include <string>
#include <vector>

#include "client/segctl/staged_output.hpp"
#include "nlohmann/json_fwd.hpp"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// One named time in milliseconds.
struct Timing {
  std::string name;
  double ms = 0;
};

/// What a command tells about a segmented cloud.
struct Summary {
  const client::Result& result;
  std::string input;            ///< for people: where the points came from
  std::string server;           ///< address; empty: no server took part
  std::vector<Timing> timings;  ///< in order
  bool with_segments = false;   ///< tell the segments' statistics in JSON
};

/// The times of a result as the server (or the local run) took them; the last one is the total.
std::vector<Timing> stage_timings(const client::Result& result);

/// One object with at least points, finite, segmented, support_plane (null unless its removal was asked for; with 0
/// points if none was found), supervoxels, segments, method, threshold (null after a
/// cut at a number of regions), timings_ms; and, if asked for, segment_statistics: an array of objects, largest first.
nlohmann::ordered_json to_json(const Summary& summary);

/// A few lines for people.
std::string to_text(const Summary& summary);

/// Writes JSON to `json_path` unless it is empty, and the text to standard output unless that is
/// taken by some file. Call after all files were added.
absl::Status report(const Summary& summary, const std::string& json_path, bool quiet, StagedOutput& output);

}  // namespace segserve::segctl
