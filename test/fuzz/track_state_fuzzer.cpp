// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "segserve/tracking.hpp"
#include "test/core/tracking/hand_made_scene.hpp"

namespace segserve {
namespace {

const Segmentation& scene() {
  static const Segmentation kScene = [] {
    test::HandMadeScene scene;
    for (int i = 0; i < 6; ++i) scene.add_row({0, 0.1 * i, 0}, 5, {40.0 * i, 100, 50});
    return scene.segmentation();
  }();
  return kScene;
}

/// A fuzzer does not find the checksum by itself.
void append_checksum(std::string& bytes) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001B3U;
  for (unsigned shift = 0; shift < 64; shift += 8) bytes += static_cast<char>(hash >> shift & 0xFFU);
}

}  // namespace
}  // namespace segserve

// The bytes of a state without its checksum. What is accepted is written as it was read, and can be followed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve;
  std::string bytes(data, data + size);
  (void)TrackState::parse(bytes);
  append_checksum(bytes);
  const auto state = TrackState::parse(bytes);
  if (!state.ok()) return 0;
  if (state->bytes() != bytes) std::abort();
  const auto tracking = track(scene(), View::world(), *state, {});
  if (!tracking.ok() || !TrackState::parse(tracking->state.bytes()).ok()) std::abort();
  return 0;
}
