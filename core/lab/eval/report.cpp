// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/report.hpp"

#include <algorithm>
#include <utility>

#include "fmt/format.h"

namespace segserve::eval {
namespace {

/// The scenes of `some` whose files are among `others`, too.
std::vector<SceneScores> common_scenes(const std::vector<SceneScores>& some, const std::vector<SceneScores>& others) {
  std::vector<SceneScores> common;
  std::ranges::copy_if(some, std::back_inserter(common), [&](const SceneScores& scene) {
    return std::ranges::find(others, scene.file, &SceneScores::file) != others.end();
  });
  return common;
}

std::string degradation_text(const Degradation& d) {
  std::string text;
  if (d.scale != 1) text += fmt::format(", scaled by {}", d.scale);
  if (d.noise_mm != 0) text += fmt::format(", {} mm depth noise at 1 m", d.noise_mm);
  if (d.keep != 1) text += fmt::format(", {} of the points", d.keep);
  if (!d.color) text += ", no color";
  return text;
}

}  // namespace

Peer compare_with(const Report& report, Report peer) {
  auto differences =
      compare(common_scenes(report.per_scene, peer.per_scene), common_scenes(peer.per_scene, report.per_scene));
  Peer result{std::move(peer), {}};
  if (differences.ok()) result.differences = *std::move(differences);  // the only other fault is too few scenes
  return result;
}

std::string headline(const Report& report) {
  std::string text = fmt::format("{} on {} scenes of {}{}", report.method, report.per_scene.size(), report.folder,
                                 degradation_text(report.degradation));
  if (!report.view.empty()) text += fmt::format(", view {}", report.view);
  if (report.threshold) text += fmt::format(", threshold {}", *report.threshold);
  if (report.learned) {
    text += fmt::format(" (learned on {} scenes of {}, one_to_one tp {:.4f})", report.learned->sweep.scenes(),
                        report.learned->folder, report.learned->sweep.tp(report.learned->sweep.best()));
  }
  return text;
}

}  // namespace segserve::eval
