// SPDX-License-Identifier: Apache-2.0
// Runs one warm segmentation of a synthetic frame, whose instructions callgrind counts. test/bench/instructions.py runs
// it.
//
//   count_instructions METHOD
#include <valgrind/callgrind.h>

#include <cstdio>

#include "core/lab/synth/scene.hpp"
#include "segserve/segment.hpp"

int main(int argc, char** argv) {
  const auto method = segserve::method_from_name(argc == 2 ? argv[1] : "");
  if (!method) {
    std::fputs("count_instructions METHOD, e.g. border\n", stderr);
    return 2;
  }
  segserve::synth::SceneOptions scene_options;
  scene_options.width = 320;
  scene_options.height = 240;
  const auto scene = segserve::synth::make_tabletop(scene_options);
  if (!scene.ok()) return 1;
  segserve::Options options;
  options.method = *method;

  segserve::Segmenter segmenter;
  if (!segmenter.segment(scene->cloud, options).ok()) return 1;  // This allocates the workspace.
  CALLGRIND_START_INSTRUMENTATION;
  const auto result = segmenter.segment(scene->cloud, options);
  CALLGRIND_DUMP_STATS;  // The name of the file ends in .1.
  return result.ok() ? 0 : 1;
}
