// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/page_array.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

#include "absl/strings/escaping.h"
#include "fmt/format.h"

namespace segserve::view_page {
namespace {

/// The bytes as a gzip. More than level 4 takes long and gains little.
std::string gzip(const std::string& bytes) {
  constexpr int kLevel = 4, kGzipWindow = 15 + 16, kMemory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzipWindow, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string result(deflateBound(&stream, bytes.size()), '\0');
  // zlib counts in 32 bits, so that a large array goes in and out in parts.
  constexpr std::size_t kPart = 1U << 30U;
  std::size_t read = 0, written = 0;
  for (int status = Z_OK; status != Z_STREAM_END;) {
    const std::size_t in = std::min(kPart, bytes.size() - read), out = std::min(kPart, result.size() - written);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + read));  // zlib does not change it.
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(result.data() + written);
    stream.avail_out = static_cast<uInt>(out);
    status = deflate(&stream, read + in == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    read += in - stream.avail_in;
    written += out - stream.avail_out;
  }
  deflateEnd(&stream);
  result.resize(written);
  return result;
}

std::vector<std::uint32_t> bits_of(std::span<const float> values) {
  std::vector<std::uint32_t> bits(values.size());
  std::ranges::transform(values, bits.begin(), [](float value) { return std::bit_cast<std::uint32_t>(value); });
  return bits;
}

}  // namespace

nlohmann::ordered_json PageArrays::add_bytes(const char* type, std::size_t count, const std::string& bytes) {
  const std::string id = fmt::format("array-{}", texts_.size() + 1);
  texts_.emplace_back(id, absl::Base64Escape(gzip(bytes)));
  return {{"type", type}, {"count", count}, {"id", id}};
}

template <std::unsigned_integral T>
nlohmann::ordered_json PageArrays::add_planes(const char* type, std::span<const T> values) {
  std::string planes(values.size_bytes(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto step = static_cast<T>(values[i] - (i == 0 ? T{0} : values[i - 1]));
    for (std::size_t byte = 0; byte < sizeof(T); ++byte) {
      planes[byte * values.size() + i] = static_cast<char>(step >> (8 * byte) & 0xffU);
    }
  }
  return add_bytes(type, values.size(), planes);
}

nlohmann::ordered_json PageArrays::add(std::span<const std::uint8_t> values) { return add_planes("u8", values); }
nlohmann::ordered_json PageArrays::add(std::span<const std::uint16_t> values) { return add_planes("u16", values); }
nlohmann::ordered_json PageArrays::add(std::span<const std::uint32_t> values) { return add_planes("u32", values); }
nlohmann::ordered_json PageArrays::add(std::span<const float> values) {
  return add_planes("f32", std::span<const std::uint32_t>(bits_of(values)));
}

nlohmann::ordered_json PageArrays::add(std::span<const double> values) {
  static_assert(std::endian::native == std::endian::little);
  static_assert(std::numeric_limits<double>::is_iec559);
  std::string bytes(values.size_bytes(), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return add_bytes("f64", values.size(), bytes);
}

}  // namespace segserve::view_page
