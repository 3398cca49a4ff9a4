// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "segserve/codec/rgbd.hpp"
#include "test/fuzz/fuzzed_cloud.hpp"

// Color images: PNG, JPEG, PGM and PPM, of any size.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::codec;
  constexpr std::string_view kDepth = "P2 4 3 1000 1 2 3 4 5 6 7 8 9 10 11 0";
  constexpr Intrinsics kCamera{.fx = 5, .fy = 5, .cx = 2, .cy = 1};
  constexpr Intrinsics kColorCamera{.fx = 12, .fy = 12, .cx = 5, .cy = 3};
  const std::string_view image(reinterpret_cast<const char*>(data), size);
  expect_sound(decode_rgbd({kDepth, image, 0.001, kCamera, kColorCamera}, kFuzzLimits));
  return 0;
}
