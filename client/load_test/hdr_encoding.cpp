// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/hdr_encoding.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <new>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"

namespace segserve::bench {
namespace {

// The last hexadecimal digit but one says that counts are words of variable length.
constexpr std::uint32_t kCookie = 0x1c849313;
constexpr std::uint32_t kCompressedCookie = 0x1c849314;
constexpr std::size_t kHeaderBytes = 40;
constexpr std::size_t kMostCounts = 30'000;
constexpr std::size_t kMostBytes = kHeaderBytes + 9 * kMostCounts;

template <typename Integer>
void put(std::string& bytes, Integer value) {
  for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<char>((value >> shift) & 0xff));
  }
}

/// Zigzag, and then 7 bits a byte, the lowest first; the ninth byte has 8.
void put_count(std::string& bytes, std::int64_t count) {
  std::uint64_t rest = (static_cast<std::uint64_t>(count) << 1U) ^ static_cast<std::uint64_t>(count >> 63);
  for (int i = 0; i < 8 && rest >= 0x80; ++i) {
    bytes.push_back(static_cast<char>((rest & 0x7f) | 0x80));
    rest >>= 7U;
  }
  bytes.push_back(static_cast<char>(rest));
}

std::string uncompressed(const HdrHistogram& histogram) {
  std::string payload;
  const auto& counts = histogram.counts();
  for (std::size_t i = 0; i < counts.size();) {
    std::size_t zeros = 0;
    while (i + zeros < counts.size() && counts[i + zeros] == 0) ++zeros;
    put_count(payload, zeros > 1 ? -static_cast<std::int64_t>(zeros) : static_cast<std::int64_t>(counts[i]));
    i += std::max<std::size_t>(zeros, 1);
  }
  std::string bytes;
  put(bytes, kCookie);
  put(bytes, static_cast<std::uint32_t>(payload.size()));
  put(bytes, std::uint32_t{0});  // the counts are not shifted
  put(bytes, std::uint32_t{HdrHistogram::kSignificantDigits});
  put(bytes, std::uint64_t{1});  // the lowest value that is told from 0
  put(bytes, std::uint64_t{HdrHistogram::kHighest});
  put(bytes, std::bit_cast<std::uint64_t>(1.0));  // integers stand for themselves
  return bytes + payload;
}

/// Takes numbers from the front of some bytes. After a fault all are 0.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename Integer>
  Integer get() {
    Integer value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) value = static_cast<Integer>(value << 8U) | next();
    return value;
  }
  std::int64_t get_count() {
    std::uint64_t value = 0;
    for (unsigned i = 0; i < 9; ++i) {
      const std::uint64_t byte = next();
      value |= (i < 8 ? byte & 0x7f : byte) << (7 * i);
      if (i < 8 && byte < 0x80) break;
    }
    return static_cast<std::int64_t>((value >> 1U) ^ (~(value & 1U) + 1));
  }
  bool done() const { return bytes_.empty(); }
  bool ok() const { return ok_; }

 private:
  std::uint8_t next() {
    if (bytes_.empty()) {
      ok_ = false;
      return 0;
    }
    const auto byte = static_cast<std::uint8_t>(bytes_.front());
    bytes_.remove_prefix(1);
    return byte;
  }

  std::string_view bytes_;
  bool ok_ = true;
};

absl::Status broken(const char* why) {
  return absl::InvalidArgumentError(std::string("this is no compressed HDR histogram of 3 digits: ") + why);
}

/// The bytes that are compressed in `bytes`; nullopt if they are not, or are too many.
std::optional<std::string> inflated(std::string_view bytes) {
  std::string out(kMostBytes, '\0');
  uLongf size = out.size();
  const int status = uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                                reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  if (status != Z_OK) return std::nullopt;
  out.resize(size);
  return out;
}

absl::StatusOr<HdrHistogram> decoded_counts(Reader reader) {
  HdrHistogram histogram;
  for (std::size_t index = 0; !reader.done();) {
    const std::int64_t count = reader.get_count();
    if (!reader.ok()) return broken("a count is cut off");
    const bool is_run = count < 0;
    const std::uint64_t length = is_run ? std::uint64_t{0} - static_cast<std::uint64_t>(count) : 1;
    if (length > kMostCounts - index) return broken("there are too many counts");
    if (!is_run) histogram.record(HdrHistogram::highest_of(index), static_cast<std::uint64_t>(count));
    index += length;
  }
  return histogram;
}

}  // namespace

std::string to_hdr_base64(const HdrHistogram& histogram) {
  const std::string bytes = uncompressed(histogram);
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string compressed(size, '\0');
  // This fails only if the memory or the bound does not suffice.
  if (compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
               static_cast<uLong>(bytes.size())) != Z_OK) {
    throw std::bad_alloc();
  }
  compressed.resize(size);
  std::string whole;
  put(whole, kCompressedCookie);
  put(whole, static_cast<std::uint32_t>(compressed.size()));
  return absl::Base64Escape(whole + compressed);
}

absl::StatusOr<HdrHistogram> from_hdr_base64(std::string_view text) {
  std::string whole;
  if (!absl::Base64Unescape({text.data(), text.size()}, &whole)) return broken("it is not base64");
  Reader outer(whole);
  if (outer.get<std::uint32_t>() != kCompressedCookie) return broken("it begins with another number");
  const auto size = outer.get<std::uint32_t>();
  if (!outer.ok() || size != whole.size() - 8) return broken("it has another length than it says");
  const auto bytes = inflated(std::string_view(whole).substr(8));
  if (!bytes) return broken("its bytes do not unpack");
  if (bytes->size() < kHeaderBytes) return broken("it is too short");
  Reader header(*bytes);
  if (header.get<std::uint32_t>() != kCookie) return broken("its content begins with another number");
  if (header.get<std::uint32_t>() != bytes->size() - kHeaderBytes) return broken("its content has another length");
  const bool is_plain = header.get<std::uint32_t>() == 0;
  const auto digits = header.get<std::uint32_t>();
  const auto lowest = header.get<std::uint64_t>();
  if (!is_plain || digits != HdrHistogram::kSignificantDigits || lowest != 1) {
    return broken("its counts stand for other values");
  }
  return decoded_counts(Reader(std::string_view(*bytes).substr(kHeaderBytes)));
}

}  // namespace segserve::bench
