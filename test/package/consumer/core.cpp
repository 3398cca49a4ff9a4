// Makes a scene, segments it, saves picture and labels in memory: the libraries of `core` together.
#include <cstdio>

#include "core/lab/picture/picture.hpp"
#include "core/lab/synth/scene.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/segment.hpp"

int main() {
  const auto scene = segserve::synth::make_tabletop({.width = 160, .height = 120});
  if (!scene.ok()) return 1;
  const auto result = segserve::segment(scene->cloud, segserve::Options{});
  if (!result.ok()) return 1;
  const auto picture = segserve::picture::render(scene->cloud, result->labels, {});
  const auto file = segserve::codec::encode_pcd(scene->cloud, result->labels, segserve::codec::PcdEncoding::kBinary);
  std::printf("%u segments, a picture of %u x %u pixels, a file of %zu bytes\n", result->segments, picture.width,
              picture.height, file.size());
  return result->segments > 1 && file.size() > result->labels.size() ? 0 : 1;
}
