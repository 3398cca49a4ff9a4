// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "segserve/codec/rgbd.hpp"
#include "test/fuzz/fuzzed_cloud.hpp"

// Depth images: PNG, PGM, PFM and NPY.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::codec;
  const std::string_view image(reinterpret_cast<const char*>(data), size);
  expect_sound(decode_rgbd({image, "", 0.001, {.fx = 5, .fy = 5, .cx = 2, .cy = 1}}, kFuzzLimits));
  return 0;
}
