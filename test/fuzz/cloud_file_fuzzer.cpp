// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include "segserve/codec/cloud_file.hpp"
#include "test/fuzz/fuzzed_cloud.hpp"

// Files of clouds of every format: PCD, PLY, LAS, text, OBJ, NPY, NPZ, and each of them compressed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::codec;
  expect_sound(decode_cloud(std::as_bytes(std::span(data, size)), kFuzzLimits, {.keep_everything = true}));
  return 0;
}
