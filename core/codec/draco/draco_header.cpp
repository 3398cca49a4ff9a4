// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco/draco_header.hpp"

#include <fmt/format.h>

#include "core/base/status_macros.hpp"
#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

// These numbers are those of Draco's bitstream 2.3 (https://google.github.io/draco/spec).
constexpr std::uint8_t kPointCloud = 0;
constexpr std::uint8_t kSequential = 0;
constexpr std::uint8_t kPosition = 0;
constexpr std::uint8_t kColor = 2;
constexpr std::uint8_t kUint8 = 2;
constexpr std::uint8_t kFloat32 = 9;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("Draco: {}", message)); }

/// Reads little-endian numbers one after the other. Beyond the end of the bytes it reads zeros.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T read() {
    if (bytes_.size() < sizeof(T)) {
      bytes_ = {};
      past_end_ = true;
      return T{};
    }
    const T value = load<T>(reinterpret_cast<const std::byte*>(bytes_.data()));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }
  /// Whether it has read beyond the end.
  bool past_end() const { return past_end_; }

 private:
  std::string_view bytes_;
  bool past_end_ = false;
};

absl::Status check_kind(Reader& reader) {
  const auto major = reader.read<std::uint8_t>();
  const auto minor = reader.read<std::uint8_t>();
  if (major != 2 || minor != 3) {
    return fault(fmt::format("it has bitstream {}.{}, but only 2.3 can be read", major, minor));
  }
  if (reader.read<std::uint8_t>() != kPointCloud) return fault("it is a mesh, not a point cloud");
  if (reader.read<std::uint8_t>() != kSequential) {
    return fault("it is not sequentially encoded, so its points may be in another order");
  }
  if (reader.read<std::uint16_t>() != 0) return fault("it has flags or metadata, which cannot be read");
  return absl::OkStatus();
}

absl::Status read_attribute(Reader& reader, bool& has_position, DracoHeader& header) {
  const auto kind = reader.read<std::uint8_t>();
  const auto type = reader.read<std::uint8_t>();
  const auto components = reader.read<std::uint8_t>();
  reader.read<std::uint8_t>();  // normalized
  reader.read<std::uint8_t>();  // The id is a varint, but so small that it takes one byte.
  if (kind == kPosition && type == kFloat32 && components == 3 && !has_position) {
    has_position = true;
    return absl::OkStatus();
  }
  if (kind == kColor && type == kUint8 && (components == 3 || components == 4) && header.color_components == 0) {
    header.color_components = components;
    return absl::OkStatus();
  }
  return fault(fmt::format(
      "it has an attribute of kind {} and type {} with {} components, but only POSITION (3 floats) and COLOR "
      "(3 or 4 unsigned bytes) are possible, once each",
      kind, type, components));
}

}  // namespace

absl::StatusOr<DracoHeader> read_draco_header(std::string_view bytes) {
  constexpr std::string_view kMagic = "DRACO";
  if (!bytes.starts_with(kMagic)) return fault("the bytes do not begin with DRACO");
  Reader reader(bytes.substr(kMagic.size()));
  RETURN_IF_ERROR(check_kind(reader));
  DracoHeader header;
  header.points = reader.read<std::uint32_t>();
  if (const auto decoders = reader.read<std::uint8_t>(); decoders != 1) {
    return fault(fmt::format("it has {} groups of attributes, but only 1 is possible", decoders));
  }
  const auto attributes = reader.read<std::uint8_t>();
  if (attributes < 1 || attributes > 2) {
    return fault(fmt::format("it has {} attributes, but only 1 or 2 are possible", attributes));
  }
  bool has_position = false;
  for (unsigned i = 0; i < attributes; ++i) RETURN_IF_ERROR(read_attribute(reader, has_position, header));
  if (reader.past_end()) return fault("the bytes end within the header");
  if (!has_position) return fault("it has no POSITION");
  return header;
}

}  // namespace segserve::codec
