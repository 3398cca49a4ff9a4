#include "test/bench/frames.hpp"

#include <cstdio>
#include <filesystem>

#include "segserve/codec/cloud_file.hpp"
#include "segserve/synth/scene.hpp"

namespace segserve::bench {
namespace {

void add_real(std::vector<Frame>& frames) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "osd/learn";
  for (const char* scene : {"learn5", "learn20", "learn30", "learn40"}) {
    auto frame = codec::load_cloud(folder / (std::string(scene) + ".pcd"));
    if (!frame.ok()) {
      std::fprintf(stderr, "no real frame: %s\n", std::string(frame.status().message()).c_str());
      continue;
    }
    frames.push_back({std::string("osd-") + scene, std::move(frame->cloud)});
  }
}

}  // namespace

const std::vector<Frame>& frames() {
  static const std::vector<Frame> all = [] {
    std::vector<Frame> frames;
    add_real(frames);
    frames.push_back({"synthetic", synth::make_tabletop({.seed = 1})->cloud});
    frames.push_back({"synthetic-full", synth::make_tabletop({.seed = 1, .all_finite = true})->cloud});
    return frames;
  }();
  return all;
}

}  // namespace segserve::bench
