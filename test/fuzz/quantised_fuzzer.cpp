// SPDX-License-Identifier: Apache-2.0
#include <zstd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "segserve/codec/quantised.hpp"
#include "test/fuzz/fuzzed_cloud.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kHeaderBytes = 40;  // before the zstd frame

void decode(std::string_view bytes) {
  const auto decoded = decode_quantised(bytes, View::world(), kFuzzLimits);
  if (!decoded.ok()) {
    expect_sound(decoded.status());
    return;
  }
  LabeledCloud cloud;
  cloud.cloud = decoded->cloud;
  expect_sound(cloud);
  // What our encoder makes of a decoded cloud has the same shape.
  const auto encoded = encode_quantised(decoded->cloud, decoded->error_bound);
  if (!encoded.ok()) return;  // Coordinates that are too large for the bound.
  const auto again = decode_quantised(*encoded, View::world(), kFuzzLimits);
  if (!again.ok() || again->cloud.width != decoded->cloud.width || again->cloud.height != decoded->cloud.height) {
    std::abort();
  }
}

}  // namespace
}  // namespace segserve::codec

// A quantised cloud as it is, and a header followed by what its frame holds, because a fuzzer makes no zstd frames.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::codec;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  decode(bytes);
  const std::string_view content = bytes.substr(std::min(kHeaderBytes, size));
  std::string packed(bytes.substr(0, kHeaderBytes));
  packed.resize(packed.size() + ZSTD_compressBound(content.size()));
  const std::size_t header_bytes = size - content.size();
  const std::size_t frame_bytes = ZSTD_compress(packed.data() + header_bytes, packed.size() - header_bytes,
                                                content.data(), content.size(), /*compressionLevel=*/1);
  if (ZSTD_isError(frame_bytes) != 0) std::abort();
  packed.resize(header_bytes + frame_bytes);
  decode(packed);
  return 0;
}
