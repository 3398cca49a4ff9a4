// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "segserve/codec/strided.hpp"
#include "test/fuzz/fuzzed_cloud.hpp"

namespace segserve::codec {
namespace {

/// Takes numbers from the front of an input. What is not there reads as 0.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : bytes_(bytes) {}

  /// A little-endian number of `count` bytes.
  std::uint32_t take(unsigned count) {
    std::uint32_t value = 0;
    for (unsigned i = 0; i < count && !bytes_.empty(); ++i) {
      value |= std::uint32_t{static_cast<std::uint8_t>(bytes_.front())} << (8 * i);
      bytes_.remove_prefix(1);
    }
    return value;
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

constexpr std::array<std::string_view, 14> kNames{"x", "y",     "z", "rgb", "rgba",      "r",   "g",
                                                  "b", "label", "a", "",    "intensity", "red", "f_dc_0"};

}  // namespace
}  // namespace segserve::codec

// A layout and its data: flags (1 byte), width and height (2 each), point_step (2), row_step (4), the number of fields
// (1), for each of them its name, datatype, count (1 each) and offset (2), and the data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::codec;
  Numbers numbers(std::string_view(reinterpret_cast<const char*>(data), size));
  StridedLayout layout;
  const std::uint32_t flags = numbers.take(1);
  layout.is_bigendian = (flags & 1U) != 0;
  layout.width = numbers.take(2);
  layout.height = numbers.take(2);
  layout.point_step = numbers.take(2);
  layout.row_step = numbers.take(4);
  layout.fields.resize(numbers.take(1));
  for (PointField& field : layout.fields) {
    field.name = kNames.at(numbers.take(1) % kNames.size());
    field.datatype = static_cast<PointDatatype>(numbers.take(1));
    field.count = numbers.take(1);
    field.offset = numbers.take(2);
  }
  const bool layout_is_right = check_layout(layout, kFuzzLimits).ok();
  const auto decoded = decode_strided(layout, numbers.rest(), {.keep_everything = (flags & 2U) != 0}, kFuzzLimits);
  if (decoded.ok() && !layout_is_right) std::abort();
  expect_sound(decoded);
  return 0;
}
