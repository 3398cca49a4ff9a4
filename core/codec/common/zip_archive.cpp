// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/zip_archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/compressed_file.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

constexpr std::uint32_t kEndSignature = 0x06054b50, kEntrySignature = 0x02014b50, kLocalSignature = 0x04034b50;
constexpr std::size_t kEndBytes = 22, kEntryBytes = 46, kLocalBytes = 30;

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("zip archive: " + fmt::format(format, std::forward<Args>(args)...));
}

/// Where the central directory's end stands: it is the last thing in the file but for a comment.
std::optional<std::size_t> find_end(std::span<const std::byte> archive) {
  constexpr std::size_t kMostComment = 65535;
  if (archive.size() < kEndBytes) return std::nullopt;
  const std::size_t last = archive.size() - kEndBytes, first = last - std::min(last, kMostComment);
  for (std::size_t at = last + 1; at-- > first;) {
    if (load<std::uint32_t>(archive.data() + at) == kEndSignature) return at;
  }
  return std::nullopt;
}

/// Takes an entry off the front of the central directory.
absl::Status take_entry(std::span<const std::byte>& directory, ZipMember& member) {
  constexpr std::size_t kFlags = 8, kMethod = 10, kCompressed = 20, kBytes = 24, kName = 28, kExtra = 30, kComment = 32,
                        kOffset = 42;
  constexpr std::uint16_t kEncrypted = 1;
  constexpr std::uint32_t kElsewhere = std::numeric_limits<std::uint32_t>::max();
  const std::byte* const entry = directory.data();
  if (directory.size() < kEntryBytes || load<std::uint32_t>(entry) != kEntrySignature) {
    return fault("its list of members is damaged");
  }
  const std::size_t name_bytes = load<std::uint16_t>(entry + kName);
  const std::size_t bytes =
      kEntryBytes + name_bytes + load<std::uint16_t>(entry + kExtra) + load<std::uint16_t>(entry + kComment);
  if (directory.size() < bytes) return fault("its list of members is damaged");
  member.name = as_text(directory.subspan(kEntryBytes, name_bytes));
  member.method = load<std::uint16_t>(entry + kMethod);
  const auto compressed = load<std::uint32_t>(entry + kCompressed), plain = load<std::uint32_t>(entry + kBytes),
             offset = load<std::uint32_t>(entry + kOffset);
  if (compressed == kElsewhere || plain == kElsewhere || offset == kElsewhere) {
    return fault("{} is 4 GiB or larger", quoted(member.name));
  }
  if ((load<std::uint16_t>(entry + kFlags) & kEncrypted) != 0) return fault("{} is encrypted", quoted(member.name));
  member.compressed_bytes = compressed;
  member.bytes = plain;
  member.header_offset = offset;
  directory = directory.subspan(bytes);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<ZipMember>> list_zip(std::span<const std::byte> archive, const DecodeLimits& limits) {
  constexpr std::size_t kCount = 10, kDirectoryBytes = 12, kDirectoryOffset = 16;
  const auto end = find_end(archive);
  if (!end) return fault("it is cut off: its list of members is missing");
  const std::byte* const record = archive.data() + *end;
  const std::size_t count = load<std::uint16_t>(record + kCount);
  const std::size_t bytes = load<std::uint32_t>(record + kDirectoryBytes);
  const std::size_t offset = load<std::uint32_t>(record + kDirectoryOffset);
  if (offset > *end || bytes > *end - offset) return fault("its list of members does not lie within it");
  if (count > kMostHeaderFields) return fault("it has {} members; at most {} are read", count, kMostHeaderFields);
  std::span<const std::byte> directory = archive.subspan(offset, bytes);
  std::vector<ZipMember> members(count);
  std::uint64_t sum = 0;
  for (ZipMember& member : members) {
    RETURN_IF_ERROR(take_entry(directory, member));
    sum += member.bytes;
  }
  RETURN_IF_ERROR(check_bytes("zip archive: decompressed ", sum, limits));
  return members;
}

absl::StatusOr<std::vector<std::byte>> read_zip_member(std::span<const std::byte> archive, const ZipMember& member,
                                                       StopCheck& check) {
  constexpr std::size_t kName = 26, kExtra = 28;
  constexpr std::uint16_t kStored = 0, kDeflated = 8;
  const std::span<const std::byte> rest = archive.subspan(std::min(member.header_offset, archive.size()));
  if (rest.size() < kLocalBytes || load<std::uint32_t>(rest.data()) != kLocalSignature) {
    return fault("{} is not where the list of members says", quoted(member.name));
  }
  const std::size_t begin =
      kLocalBytes + load<std::uint16_t>(rest.data() + kName) + load<std::uint16_t>(rest.data() + kExtra);
  if (rest.size() < begin || rest.size() - begin < member.compressed_bytes) {
    return fault("{} is cut off", quoted(member.name));
  }
  const std::span<const std::byte> stream = rest.subspan(begin, member.compressed_bytes);
  if (member.method == kDeflated) {
    return inflate_exactly(stream, member.bytes, "zip archive: " + quoted(member.name), check);
  }
  if (member.method != kStored) {
    return fault("{} is compressed by method {}; 0 and 8 can be read", quoted(member.name), member.method);
  }
  if (member.bytes != member.compressed_bytes) {
    return fault("{} has {} bytes, not the claimed {}", quoted(member.name), member.compressed_bytes, member.bytes);
  }
  return std::vector<std::byte>(stream.begin(), stream.end());
}

}  // namespace segserve::codec
