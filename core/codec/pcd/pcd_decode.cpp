// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <lzf.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/surplus_lines.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/pcd/pcd_header.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("PCD body: " + fmt::format(format, std::forward<Args>(args)...));
}

/// Memory that is not cleared, because the caller writes each byte before reading it.
std::unique_ptr<std::byte[]> allocate(std::size_t bytes) { return std::make_unique_for_overwrite<std::byte[]>(bytes); }

/// Reads a binary body: points one after the other, each with all its fields.
absl::Status read_binary(const PcdHeader& header, std::span<const std::byte> body, const StopToken& stop,
                         LabeledCloud& out) {
  const std::size_t point_bytes = header.point_bytes();
  if (header.points > body.size() / point_bytes) {
    return fault("it has {} bytes, but POINTS {} of {} bytes each need more", body.size(), header.points, point_bytes);
  }
  const auto column = [&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) offset += header.fields[i].bytes();
    return Column{body.data() + offset, point_bytes, header.fields[field].type};
  };
  return read_columns(header.roles, column, header.points, out, stop);
}

/// The compressed bytes of a binary_compressed body. The two sizes in front of them are checked against the header, the
/// limits and the bytes at hand.
absl::StatusOr<std::span<const std::byte>> compressed_bytes(const PcdHeader& header, std::span<const std::byte> body,
                                                            const DecodeLimits& limits) {
  constexpr std::size_t kSizes = 8;
  if (body.size() < kSizes) {
    return fault("it has {} bytes, but binary_compressed begins with two sizes of 4 bytes", body.size());
  }
  const std::size_t compressed = load<std::uint32_t>(body.data());
  const std::uint64_t claimed = load<std::uint32_t>(body.data() + 4);
  const std::size_t point_bytes = header.point_bytes();
  if (compressed > body.size() - kSizes) {
    return fault("it claims {} compressed bytes, but has {}", compressed, body.size() - kSizes);
  }
  if (claimed % point_bytes != 0 || claimed / point_bytes != header.points) {
    return fault("it claims {} bytes when decompressed, which is not POINTS {} of {} bytes each", claimed,
                 header.points, point_bytes);
  }
  RETURN_IF_ERROR(check_bytes("PCD body: its decompressed ", claimed, limits));
  constexpr std::uint64_t kBestRatio = 88;  // An LZF reference of 3 bytes stands for at most 264 bytes.
  if (claimed > kBestRatio * compressed) {
    return fault("it claims {} bytes when decompressed, more than {} compressed bytes can hold", claimed, compressed);
  }
  return body.subspan(kSizes, compressed);
}

/// Reads a binary_compressed body: fields one after the other, each with all its points, as one LZF block.
absl::Status read_compressed(const PcdHeader& header, std::span<const std::byte> body, const DecodeLimits& limits,
                             const StopToken& stop, LabeledCloud& out) {
  ASSIGN_OR_RETURN(const auto compressed, compressed_bytes(header, body, limits));
  const std::size_t size = header.points * header.point_bytes();
  const auto planes = allocate(size);
  if (size > 0) {
    const unsigned written = lzf_decompress(compressed.data(), static_cast<unsigned>(compressed.size()), planes.get(),
                                            static_cast<unsigned>(size));
    if (written != size) return fault("the {} compressed bytes are damaged", compressed.size());
  }
  const auto column = [&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) {
      if (!header.fields[i].is_padding()) offset += header.fields[i].bytes() * header.points;
    }
    return Column{planes.get() + offset, header.fields[field].bytes(), header.fields[field].type};
  };
  return read_columns(header.roles, column, header.points, out, stop);
}

/// A value of a line of text that is kept.
struct Slot {
  std::size_t word = 0;                    ///< which word of the line it is
  std::size_t field = 0;                   ///< index of its field
  std::size_t offset = 0;                  ///< bytes from the start of the binary row
  ScalarType type = ScalarType::kFloat32;  ///< in the binary row
};

/// How a line of text becomes a row of binary values. Only the fields that have a role are kept.
struct RowPlan {
  std::vector<Slot> slots;  ///< in the order of the words
  std::size_t words = 0;    ///< number of words in a line
  std::size_t bytes = 0;    ///< length of a row

  explicit RowPlan(const PcdHeader& header) {
    const auto wanted = header.roles.fields();
    for (std::size_t i = 0; i < header.fields.size(); ++i) {
      if (std::find(wanted.begin(), wanted.end(), i) != wanted.end()) {
        const ScalarType type = text_type(header.fields[i].type);
        slots.push_back({words, i, bytes, type});
        bytes += size_of(type);
      }
      words += header.fields[i].count;
    }
  }
};

/// Writes the values of a line to `row`, which has plan.bytes bytes. A line can be as long as the file, so that each
/// word counts as work.
absl::Status parse_row(const PcdHeader& header, const RowPlan& plan, const LineReader::Line& line, StopCheck& check,
                       std::byte* row) {
  std::string_view rest = line.text;
  std::size_t words = 0;
  auto slot = plan.slots.begin();
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++words) {
    if (check.after(1)) return check.status();
    if (words == plan.words) {
      return fault("line {} has more values than the {} that FIELDS and COUNT promise", line.number, plan.words);
    }
    if (slot == plan.slots.end() || slot->word != words) continue;
    const PcdField& field = header.fields[slot->field];
    if (!parse_scalar(word, slot->type, row + slot->offset)) {
      return fault("line {}: {} is not a value of field {} ({} of {} bytes)", line.number, quoted(word),
                   quoted(field.name), is_float(field.type) ? "a float" : "an integer", field.bytes());
    }
    ++slot;
  }
  if (words != plan.words) {
    return fault("line {} has {} values, but FIELDS and COUNT promise {}", line.number, words, plan.words);
  }
  return absl::OkStatus();
}

/// Writes the header.points lines of a text body to `rows`, each as a row of plan.bytes bytes. Warns of more lines.
absl::Status parse_rows(const PcdHeader& header, const RowPlan& plan, std::string_view body, const StopToken& stop,
                        std::byte* rows, std::vector<Warning>& warnings) {
  LineReader lines(body, header.body_line);
  std::size_t read = 0, left_out = 0;
  StopCheck check(stop);
  while (const auto line = lines.next()) {
    if (check.after(1)) return check.status();
    if (is_blank(line->text) || line->text.starts_with('#')) continue;
    if (read == header.points) {
      ++left_out;
      continue;
    }
    RETURN_IF_ERROR(parse_row(header, plan, *line, check, rows + read * plan.bytes));
    ++read;
  }
  if (read != header.points) return fault("it ends after {} of POINTS {}", read, header.points);
  warn_of_surplus_lines(left_out, warnings);
  return absl::OkStatus();
}

/// Reads an ascii body: a line for each point, with the values of all its fields.
absl::Status read_ascii(const PcdHeader& header, std::span<const std::byte> body, const StopToken& stop,
                        LabeledCloud& out) {
  const RowPlan plan(header);
  if (header.points > most_values(body.size()) / plan.words) {
    return fault("it has {} bytes, but POINTS {} of {} values each need more", body.size(), header.points, plan.words);
  }
  const auto rows = allocate(header.points * plan.bytes);
  RETURN_IF_ERROR(parse_rows(header, plan, without_byte_order_mark(as_text(body)), stop, rows.get(), out.warnings));
  const auto column = [&](std::size_t field) {
    const auto slot =
        std::find_if(plan.slots.begin(), plan.slots.end(), [&](const Slot& s) { return s.field == field; });
    return Column{rows.get() + slot->offset, plan.bytes, slot->type};
  };
  return read_columns(header.roles, column, header.points, out, stop);
}

absl::Status read_body(const PcdHeader& header, std::span<const std::byte> body, const DecodeLimits& limits,
                       const StopToken& stop, LabeledCloud& out) {
  switch (header.encoding) {
    case PcdEncoding::kAscii:
      return read_ascii(header, body, stop, out);
    case PcdEncoding::kBinary:
      return read_binary(header, body, stop, out);
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return read_compressed(header, body, limits, stop, out);
}

/// Chooses the view by the rule of decode_pcd, and says so.
void choose_view(const PcdHeader& header, const std::optional<View>& given, LabeledCloud& out) {
  const auto [x, y, z] = header.viewpoint;
  if (given) {
    out.cloud.view = *given;
    out.view_rule = given_view_rule(*given);
  } else if (header.height > 1 && header.identity_viewpoint) {
    out.cloud.view = View::camera();
    out.view_rule = fmt::format("CAMERA: the cloud is organized ({} x {}) and its VIEWPOINT is the identity",
                                header.width, header.height);
  } else {
    out.cloud.view = View::world(x, y, z);
    out.view_rule = fmt::format("WORLD with the sensor at ({}, {}, {}), its VIEWPOINT: {}", x, y, z,
                                header.height > 1 ? "that is not the identity" : "the cloud is not organized");
  }
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        std::optional<View> view, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("PCD file: ", bytes.size(), limits));
  const std::string_view file = without_byte_order_mark(as_text(bytes));
  ASSIGN_OR_RETURN(PcdHeader header, parse_pcd_header(file, limits));
  LabeledCloud out;
  out.warnings = std::move(header.warnings);
  RETURN_IF_ERROR(read_body(header, as_bytes(std::span(file.substr(header.body_offset))), limits, stop, out));
  out.cloud.width = header.width;
  out.cloud.height = header.height;
  choose_view(header, view, out);
  return out;
}

}  // namespace segserve::codec
