// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/segctl/json_flag.hpp"
#include "client/segctl/staged_output.hpp"
#include "nlohmann/json.hpp"
#include "proto/text/result_json.hpp"
#include "segserve/client/client.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

using text::stage_timings;
using text::Timing;
using text::warnings_json;

/// The facts that a command tells about a segmented cloud.
struct Summary {
  const client::Result& result;
  std::string input;                              ///< For people: where the points came from.
  std::string server;                             ///< Its address; empty if no server took part.
  std::vector<Timing> timings;                    ///< In the order in which they are told.
  bool with_segments = false;                     ///< Whether the JSON tells the statistics of the segments.
  std::optional<Prompts> prompts = std::nullopt;  ///< If the result has a selection.
};

/// Sets what only the reader of a file knows and a server, which got the points, does not: why the cloud has its view,
/// and what of the file was not used.
void take_file_facts(const codec::LabeledCloud& file, client::Result& result);

/// See text::to_json.
nlohmann::ordered_json to_json(const Summary& summary);

/// Describes the segment that prompts have picked, in two lines for people.
std::string selection_text(const PromptedSelection& picked);

/// A few lines for people, without the warnings.
std::string to_text(const Summary& summary);

/// The report of a command about its work.
struct Told {
  nlohmann::ordered_json json;  ///< without the warnings
  std::string text;             ///< a few lines for people, without the warnings
  std::vector<codec::Warning> warnings = {};
};

/// Writes the JSON if --json asks for it, and the text to standard output unless a file goes there or `quiet` is set,
/// both with the warnings. Warnings that would show nowhere then go to standard error. Call it after all files were
/// added.
absl::Status report(Told told, const JsonFlag& json, bool quiet, StagedOutput& output);
absl::Status report(const Summary& summary, const JsonFlag& json, bool quiet, StagedOutput& output);

}  // namespace segserve::segctl
