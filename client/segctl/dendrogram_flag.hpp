// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

/// The flag --dendrogram: a picture of the merge tree. It must outlive the parsing of the command line.
class DendrogramFlag {
 public:
  void add_to(CLI::App& app);
  bool given() const { return !path_.empty(); }
  absl::Status announce(StagedOutput& output) const;

  /// Adds the picture if the flag asks for it. Segments have the colors of --picture, if the scene is known; `scene`
  /// may be null.
  absl::Status add(StagedOutput& output, const client::Result& result, const codec::LabeledCloud* scene,
                   const SceneOutput& scene_output) const;

 private:
  std::string path_;
};

}  // namespace segserve::segctl
