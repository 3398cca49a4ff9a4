// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <lzf.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <set>
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

/// A value of a line of text that is kept.
struct Slot {
  std::size_t word = 0;                    ///< which word of the line it is
  std::size_t field = 0;                   ///< index of its field
  std::size_t offset = 0;                  ///< bytes from the start of the binary row
  ScalarType type = ScalarType::kFloat32;  ///< in the binary row
  bool is_needed = true;                   ///< whether its field has a role
};

/// How a line of text becomes a row of binary values.
struct RowPlan {
  std::vector<Slot> slots;  ///< in the order of the words
  std::size_t words = 0;    ///< number of words in a line
  std::size_t bytes = 0;    ///< length of a row

  /// Keeps all fields, or only those that have a role.
  RowPlan(const PcdHeader& header, bool keep_all) {
    const auto used = header.roles.fields();
    for (std::size_t i = 0; i < header.fields.size(); ++i) {
      const bool is_used = std::ranges::find(used, i) != used.end();
      const std::size_t kept = is_used || (keep_all && !header.fields[i].is_padding()) ? header.fields[i].count : 0;
      // Values that have no meaning here are kept in the type that the header gives them.
      const ScalarType type = is_used ? text_type(header.fields[i].type) : header.fields[i].type;
      for (std::size_t k = 0; k < kept; ++k) {
        slots.push_back({words + k, i, bytes, type, is_used});
        bytes += size_of(type);
      }
      words += header.fields[i].count;
    }
  }
};

/// The rows of a text body in binary, and the fields without a role that have words which are no values of theirs.
struct BinaryRows {
  std::unique_ptr<std::byte[]> bytes;
  std::set<std::size_t> unreadable;
};

/// Writes the values of a line to `row`, which has plan.bytes bytes. A line can be as long as the file, so that each
/// word counts as work.
absl::Status parse_row(const PcdHeader& header, const RowPlan& plan, const LineReader::Line& line, StopCheck& check,
                       std::byte* row, std::set<std::size_t>& unreadable) {
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
      if (!slot->is_needed) {
        std::fill_n(row + slot->offset, size_of(slot->type), std::byte{0});
        unreadable.insert(slot++->field);
        continue;
      }
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
                        BinaryRows& rows, std::vector<Warning>& warnings) {
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
    RETURN_IF_ERROR(parse_row(header, plan, *line, check, rows.bytes.get() + read * plan.bytes, rows.unreadable));
    ++read;
  }
  if (read != header.points) return fault("it ends after {} of POINTS {}", read, header.points);
  warn_of_surplus_lines(left_out, warnings);
  return absl::OkStatus();
}

/// Reads the body of a file, whose header is known.
class BodyReader {
 public:
  BodyReader(const PcdHeader& header, const ReadOptions& options, const DecodeLimits& limits, const StopToken& stop,
             LabeledCloud& out)
      : header_(header), options_(options), limits_(limits), stop_(stop), out_(out) {}

  absl::Status read(std::span<const std::byte> body) {
    switch (header_.encoding) {
      case PcdEncoding::kAscii:
        return read_ascii(body);
      case PcdEncoding::kBinary:
        return read_binary(body);
      case PcdEncoding::kBinaryCompressed:
        break;
    }
    return read_compressed(body);
  }

 private:
  /// A body has points one after the other, each with all its fields.
  absl::Status read_binary(std::span<const std::byte> body);
  /// A body has fields one after the other, each with all its points, as one LZF block.
  absl::Status read_compressed(std::span<const std::byte> body);
  /// A body has a line for each point, with the values of all its fields.
  absl::Status read_ascii(std::span<const std::byte> body);
  absl::Status read_columns(std::function<Column(std::size_t field)> column,
                            const std::set<std::size_t>& unreadable = {});

  const PcdHeader& header_;
  const ReadOptions& options_;
  const DecodeLimits& limits_;
  const StopToken& stop_;
  LabeledCloud& out_;
};

absl::Status BodyReader::read_columns(std::function<Column(std::size_t field)> column,
                                      const std::set<std::size_t>& unreadable) {
  PointTable table{header_.point_fields(), header_.roles, header_.width, header_.height, std::move(column)};
  leave_out(unreadable, table.fields, out_.warnings);
  ViewEvidence evidence{.stated = header_.stated_view, .position = header_.viewpoint, .entry = "VIEWPOINT"};
  evidence.has_entry = true;
  return read_points(table, evidence, options_, stop_, out_);
}

absl::Status BodyReader::read_binary(std::span<const std::byte> body) {
  const std::size_t point_bytes = header_.point_bytes();
  if (header_.points > body.size() / point_bytes) {
    return fault("it has {} bytes, but POINTS {} of {} bytes each need more", body.size(), header_.points, point_bytes);
  }
  return read_columns([&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) offset += header_.fields[i].bytes();
    return Column{body.data() + offset, point_bytes, header_.fields[field].type};
  });
}

absl::Status BodyReader::read_compressed(std::span<const std::byte> body) {
  ASSIGN_OR_RETURN(const auto compressed, compressed_bytes(header_, body, limits_));
  const std::size_t size = header_.points * header_.point_bytes();
  const auto planes = allocate(size);
  if (size > 0) {
    const unsigned written = lzf_decompress(compressed.data(), static_cast<unsigned>(compressed.size()), planes.get(),
                                            static_cast<unsigned>(size));
    if (written != size) return fault("the {} compressed bytes are damaged", compressed.size());
  }
  return read_columns([&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) {
      if (!header_.fields[i].is_padding()) offset += header_.fields[i].bytes() * header_.points;
    }
    return Column{planes.get() + offset, header_.fields[field].bytes(), header_.fields[field].type};
  });
}

absl::Status BodyReader::read_ascii(std::span<const std::byte> body) {
  const RowPlan plan(header_, options_.keep_everything);
  if (header_.points > most_values(body.size()) / plan.words) {
    return fault("it has {} bytes, but POINTS {} of {} values each need more", body.size(), header_.points, plan.words);
  }
  BinaryRows rows{allocate(header_.points * plan.bytes), {}};
  RETURN_IF_ERROR(parse_rows(header_, plan, without_byte_order_mark(as_text(body)), stop_, rows, out_.warnings));
  const auto column = [&](std::size_t field) {
    const auto slot = std::ranges::find(plan.slots, field, &Slot::field);
    return Column{rows.bytes.get() + slot->offset, plan.bytes, slot->type};
  };
  return read_columns(column, rows.unreadable);
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("PCD file: ", bytes.size(), limits));
  const std::string_view file = without_byte_order_mark(as_text(bytes));
  ASSIGN_OR_RETURN(PcdHeader header, parse_pcd_header(file, limits));
  LabeledCloud out;
  out.warnings = std::move(header.warnings);
  RETURN_IF_ERROR(
      BodyReader(header, options, limits, stop, out).read(as_bytes(std::span(file.substr(header.body_offset)))));
  return out;
}

}  // namespace segserve::codec
