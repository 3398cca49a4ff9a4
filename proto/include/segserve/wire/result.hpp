// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/codec/placement.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/segment.hpp"
#include "segserve/wire/tracks.hpp"

namespace segserve::wire {

/// Wall times of a call besides those of the segmentation, milliseconds. The comments of v1.Timings say where each
/// begins and ends.
struct CallTimings {
  double queue = 0;   ///< waiting for a worker; 0 if the result was computed in this process
  double decode = 0;  ///< decoding of the payload
  double encode = 0;  ///< encoding of the answer; 0 if the result was computed in this process
  double total = 0;   ///< everything on the computing side; does not include the network
};

/// The result of one cloud.
struct Result {
  /// If a server computed the result, it holds those of `labels`, `supervoxels`, `tree` and `statistics` that were
  /// asked for; the others and `supervoxel_normals` are empty, and `timings.total` is the sum of the stages. If it was
  /// computed in this process, it holds all of these, but `statistics` only if they were asked for.
  Segmentation segmentation;
  std::size_t points = 0;         ///< points of the cloud, finite or not
  std::uint32_t supervoxels = 0;  ///< number of supervoxels, also if their array was not asked for
  Method method = Method::kBorder;
  std::optional<std::uint32_t> regions;  ///< Options::regions of the request; unset if the cut is at a threshold
  View view;                             ///< the view in which the cloud was segmented, in the payload's frame
  std::string view_rule;                 ///< one line for people that says why it was this view
  std::vector<codec::Warning> warnings;  ///< what the payload or file has that was not used, or is probably wrong
  /// The placement from the coordinates of the payload or file to those in which it was segmented. The statistics are
  /// in those of the payload or file.
  codec::Placement placement;
  /// The selection by the prompts of the request, in the coordinates of the payload. Unset without prompts, or if the
  /// server is too old to know them. From a server, its labels are empty unless labels were asked for.
  std::optional<PromptedSelection> selection;
  /// The ids of the segments over time, if they were asked for. The segments need not be a cut of the tree at one
  /// height.
  std::optional<Tracks> tracks;
  CallTimings timings;
  std::string server_version;    ///< version of the program that computed the result, e.g. "0.1.0"
  std::string options_hash;      ///< 16 hexadecimal digits; a hash of all options that decide results
  bool in_this_process = false;  ///< whether the client computed the result, and not a server
};

}  // namespace segserve::wire
