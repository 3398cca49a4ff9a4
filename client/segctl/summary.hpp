// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/segctl/json_flag.hpp"
#include "client/segctl/staged_output.hpp"
#include "nlohmann/json_fwd.hpp"
#include "segserve/client/client.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::segctl {

/// A named time in milliseconds.
struct Timing {
  std::string name;
  double ms = 0;
};

/// The facts that a command tells about a segmented cloud.
struct Summary {
  const client::Result& result;
  std::string input;            ///< For people: where the points came from.
  std::string server;           ///< Its address; empty if no server took part.
  std::vector<Timing> timings;  ///< In the order in which they are told.
  bool with_segments = false;   ///< Whether the JSON tells the statistics of the segments.
};

/// Sets what only the reader of a file knows and a server, which got the points, does not: why the cloud has its view,
/// and what of the file was not used.
void take_file_facts(const codec::LabeledCloud& file, client::Result& result);

/// An array of objects with `reason` and `message`.
nlohmann::ordered_json warnings_json(const std::vector<codec::Warning>& warnings);

/// The times that the server, or the local run, measured. The last one is the total.
std::vector<Timing> stage_timings(const client::Result& result);

/// An object with at least points, finite, segmented, support_plane, supervoxels, segments, method, threshold, warnings
/// and timings_ms. support_plane is null unless its removal was asked for, and has 0 points if none was found;
/// threshold is null after a cut at a number of regions. If asked for, segment_statistics is an array of objects,
/// largest segment first.
nlohmann::ordered_json to_json(const Summary& summary);

/// A few lines for people.
std::string to_text(const Summary& summary);

/// Writes the JSON if --json asks for it, and the text to standard output unless a file goes there or `quiet` is set.
/// Warnings that would show nowhere then go to standard error.
/// Call it after all files were added.
absl::Status report(const Summary& summary, const JsonFlag& json, bool quiet, StagedOutput& output);

}  // namespace segserve::segctl
