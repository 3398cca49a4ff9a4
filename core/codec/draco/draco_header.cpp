// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco/draco_header.hpp"

#include <fmt/format.h>

#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

// Numbers of Draco's bitstream.
constexpr std::uint8_t kPointCloud = 0;
constexpr std::uint8_t kSequential = 0;
constexpr std::uint8_t kPosition = 0;
constexpr std::uint8_t kColor = 2;
constexpr std::uint8_t kUint8 = 2;
constexpr std::uint8_t kFloat32 = 9;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("Draco: {}", message)); }

/// Reads little-endian numbers one after the other; after the end, zeros.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T read() {
    if (bytes_.size() < sizeof(T)) {
      bytes_ = {};
      at_end_ = true;
      return T{};
    }
    const T value = load<T>(reinterpret_cast<const std::byte*>(bytes_.data()));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }
  bool at_end() const { return at_end_; }

 private:
  std::string_view bytes_;
  bool at_end_ = false;
};

absl::Status check_kind(Reader& reader) {
  const auto major = reader.read<std::uint8_t>();
  const auto minor = reader.read<std::uint8_t>();
  if (major != 2 || minor != 3) return fault(fmt::format("bitstream {}.{}; only 2.3 is known", major, minor));
  if (reader.read<std::uint8_t>() != kPointCloud) return fault("it is a mesh, not a point cloud");
  if (reader.read<std::uint8_t>() != kSequential) {
    return fault("it is not sequentially encoded, so its points are not in their order");
  }
  if (reader.read<std::uint16_t>() != 0) return fault("it has flags or metadata, which are not read");
  return absl::OkStatus();
}

absl::Status read_attribute(Reader& reader, bool& has_position, DracoHeader& header) {
  const auto kind = reader.read<std::uint8_t>();
  const auto type = reader.read<std::uint8_t>();
  const auto components = reader.read<std::uint8_t>();
  reader.read<std::uint8_t>();  // normalized
  reader.read<std::uint8_t>();  // its id: a varint, but so small that it is one byte
  if (kind == kPosition && type == kFloat32 && components == 3 && !has_position) {
    has_position = true;
    return absl::OkStatus();
  }
  if (kind == kColor && type == kUint8 && (components == 3 || components == 4) && header.color_components == 0) {
    header.color_components = components;
    return absl::OkStatus();
  }
  return fault(
      fmt::format("an attribute of kind {}, type {} with {} components; POSITION (3 floats) and COLOR (3 or 4 "
                  "unsigned bytes) are possible, once each",
                  kind, type, components));
}

}  // namespace

absl::StatusOr<DracoHeader> read_draco_header(std::string_view bytes) {
  constexpr std::string_view kMagic = "DRACO";
  if (!bytes.starts_with(kMagic)) return fault("the bytes do not begin with DRACO");
  Reader reader(bytes.substr(kMagic.size()));
  if (absl::Status status = check_kind(reader); !status.ok()) return status;
  DracoHeader header;
  header.points = reader.read<std::uint32_t>();
  if (const auto decoders = reader.read<std::uint8_t>(); decoders != 1) {
    return fault(fmt::format("{} groups of attributes; 1 is possible", decoders));
  }
  const auto attributes = reader.read<std::uint8_t>();
  if (attributes < 1 || attributes > 2) return fault(fmt::format("{} attributes; 1 or 2 are possible", attributes));
  bool has_position = false;
  for (unsigned i = 0; i < attributes; ++i) {
    if (absl::Status status = read_attribute(reader, has_position, header); !status.ok()) return status;
  }
  if (reader.at_end()) return fault("the bytes end within the header");
  if (!has_position) return fault("it has no POSITION");
  return header;
}

}  // namespace segserve::codec
