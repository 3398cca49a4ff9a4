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
#include "core/codec/common/typed_rows.hpp"
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

/// A body that is binary_compressed.
struct CompressedBody {
  std::span<const std::byte> compressed;
  bool has_padding = false;  ///< whether the fields that are padding are among those that were compressed
};

/// Finds the compressed bytes. The two sizes in front of them are checked against the header, the limits and the bytes
/// at hand.
absl::StatusOr<CompressedBody> compressed_body(const PcdHeader& header, std::span<const std::byte> body,
                                               const DecodeLimits& limits) {
  constexpr std::size_t kSizes = 8;
  if (body.size() < kSizes) {
    return fault("it has {} bytes, but binary_compressed begins with two sizes of 4 bytes", body.size());
  }
  const std::size_t compressed = load<std::uint32_t>(body.data());
  const std::uint64_t claimed = load<std::uint32_t>(body.data() + 4);
  const auto is_claimed = [&](std::size_t point_bytes) {
    return claimed % point_bytes == 0 && claimed / point_bytes == header.points;
  };
  const std::size_t point_bytes = header.point_bytes(false);
  const bool has_padding = !is_claimed(point_bytes) && is_claimed(header.point_bytes(true));
  if (compressed > body.size() - kSizes) {
    return fault("it claims {} compressed bytes, but has {}", compressed, body.size() - kSizes);
  }
  if (!has_padding && !is_claimed(point_bytes)) {
    return fault("it claims {} bytes when decompressed, which is not POINTS {} of {} bytes each", claimed,
                 header.points, point_bytes);
  }
  RETURN_IF_ERROR(check_bytes("PCD body: its decompressed ", claimed, limits));
  constexpr std::uint64_t kBestRatio = 88;  // An LZF reference of 3 bytes stands for at most 264 bytes.
  if (claimed > kBestRatio * compressed) {
    return fault("it claims {} bytes when decompressed, more than {} compressed bytes can hold", claimed, compressed);
  }
  return CompressedBody{body.subspan(kSizes, compressed), has_padding};
}

/// A word of a line of text that is kept.
struct Slot {
  std::size_t word = 0;   ///< which word of the line it is
  std::size_t field = 0;  ///< index of its field
  std::size_t index = 0;  ///< which of the field's words it is
};

/// The rows of a text body.
struct TextBody {
  TypedRows rows;
  std::vector<Slot> slots;     ///< in the order of the words
  std::size_t words = 0;       ///< number of words in a line
  std::set<std::size_t> used;  ///< the fields that make points and colors, whose types are those of the header
  UnreadableFields unreadable;

  /// Keeps all fields, or only those that have a role.
  TextBody(const PcdHeader& header, bool keep_all) {
    const auto with_role = header.roles.fields();
    used = {with_role.begin(), with_role.end()};
    const std::set<std::size_t> kept = used;
    if (header.roles.label) used.erase(*header.roles.label);
    for (std::size_t i = 0; i < header.fields.size(); ++i) {
      const PcdField& field = header.fields[i];
      if (kept.contains(i) || (keep_all && !field.is_padding())) {
        rows.add_field(field.type, field.count, header.roles.is_position(i));
        for (std::size_t k = 0; k < field.count; ++k) slots.push_back({words + k, i, k});
      } else {
        rows.add_skipped_field();
      }
      words += field.count;
    }
  }
};

/// Reads the words of a line. A line can be as long as the file, so that each word counts as work.
absl::Status parse_row(const PcdHeader& header, const LineReader::Line& line, std::size_t row, StopCheck& check,
                       TextBody& body) {
  std::string_view rest = line.text;
  std::size_t words = 0;
  auto slot = body.slots.begin();
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++words) {
    if (check.after(1)) return check.status();
    if (words == body.words) {
      return fault("line {} has more values than the {} that FIELDS and COUNT promise", line.number, body.words);
    }
    if (slot == body.slots.end() || slot->word != words) continue;
    const PcdField& field = header.fields[slot->field];
    if (!body.rows.put(row, slot->field, slot->index, word) && !body.unreadable.contains(slot->field)) {
      std::string explanation =
          fmt::format("line {}: {} is not a value of field {} ({} of {} bytes)", line.number, quoted(word),
                      quoted(field.name), is_float(field.type) ? "a float" : "an integer", field.bytes());
      if (header.roles.is_position(slot->field)) return fault("{}", explanation);
      body.unreadable.emplace(slot->field, std::move(explanation));
    }
    ++slot;
  }
  if (words != body.words) {
    return fault("line {} has {} values, but FIELDS and COUNT promise {}", line.number, words, body.words);
  }
  return absl::OkStatus();
}

/// Reads the header.points lines of a text body. Warns of more lines.
absl::Status parse_rows(const PcdHeader& header, std::string_view text, StopCheck& check, TextBody& body,
                        std::vector<Warning>& warnings) {
  LineReader lines(text, header.body_line);
  std::size_t read = 0, left_out = 0;
  while (const auto line = lines.next()) {
    if (check.after(1)) return check.status();
    if (is_blank(line->text) || line->text.starts_with('#')) continue;
    if (read == header.points) {
      ++left_out;
      continue;
    }
    RETURN_IF_ERROR(parse_row(header, *line, read, check, body));
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
  absl::Status read_ascii(std::span<const std::byte> bytes);
  PointTable make_table(std::function<Column(std::size_t field)> column) const;
  absl::Status read_table(const PointTable& table);

  const PcdHeader& header_;
  const ReadOptions& options_;
  const DecodeLimits& limits_;
  const StopToken& stop_;
  LabeledCloud& out_;
};

PointTable BodyReader::make_table(std::function<Column(std::size_t field)> column) const {
  return {header_.point_fields(), header_.roles, header_.width, header_.height, std::move(column), header_.stated};
}

absl::Status BodyReader::read_table(const PointTable& table) {
  ViewEvidence evidence{.position = std::nullopt, .entry = "VIEWPOINT"};
  if (header_.viewpoint) evidence.position = header_.viewpoint->translation;
  evidence.has_entry = true;
  return read_points(table, evidence, options_, stop_, out_);
}

absl::Status BodyReader::read_binary(std::span<const std::byte> body) {
  const std::size_t point_bytes = header_.point_bytes(true);
  if (header_.points > body.size() / point_bytes) {
    return fault("it has {} bytes, but POINTS {} of {} bytes each need more", body.size(), header_.points, point_bytes);
  }
  warn_of_surplus_bytes(body.subspan(header_.points * point_bytes), point_bytes, out_.warnings);
  return read_table(make_table([&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) offset += header_.fields[i].bytes();
    return Column{body.data() + offset, point_bytes, header_.fields[field].type};
  }));
}

absl::Status BodyReader::read_compressed(std::span<const std::byte> body) {
  ASSIGN_OR_RETURN(const CompressedBody block, compressed_body(header_, body, limits_));
  const std::span<const std::byte> compressed = block.compressed;
  const std::size_t size = header_.points * header_.point_bytes(block.has_padding);
  const auto planes = allocate(size);
  if (size > 0) {
    const unsigned written = lzf_decompress(compressed.data(), static_cast<unsigned>(compressed.size()), planes.get(),
                                            static_cast<unsigned>(size));
    if (written != size) return fault("the {} compressed bytes are damaged", compressed.size());
  }
  return read_table(make_table([&](std::size_t field) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < field; ++i) {
      if (block.has_padding || !header_.fields[i].is_padding()) offset += header_.fields[i].bytes() * header_.points;
    }
    return Column{planes.get() + offset, header_.fields[field].bytes(), header_.fields[field].type};
  }));
}

absl::Status BodyReader::read_ascii(std::span<const std::byte> bytes) {
  TextBody body(header_, options_.keep_everything);
  if (header_.points > most_values(bytes.size()) / body.words) {
    return fault("it has {} bytes, but POINTS {} of {} values each need more", bytes.size(), header_.points,
                 body.words);
  }
  body.rows.allocate(header_.points);
  StopCheck check(stop_);
  RETURN_IF_ERROR(parse_rows(header_, without_byte_order_mark(as_text(bytes)), check, body, out_.warnings));
  PointTable table = make_table([&](std::size_t field) { return body.rows.column(field); });
  for (std::size_t i = 0; i < table.fields.size(); ++i) {
    if (!body.used.contains(i) && body.rows.is_kept(i)) table.fields[i].type = body.rows.fitting_type(i, check);
  }
  RETURN_IF_ERROR(check.status());
  leave_out(std::move(body.unreadable), table, out_.warnings);
  return read_table(table);
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("PCD file: ", bytes.size(), limits));
  const std::string_view file = without_byte_order_mark(as_text(bytes));
  ASSIGN_OR_RETURN(PcdHeader header, parse_pcd_header(file, limits));
  LabeledCloud out;
  out.warnings = std::move(header.warnings);
  const auto& viewpoint = header.viewpoint;
  if (viewpoint && (viewpoint->is_turned() || !viewpoint->translation.isZero(0))) out.viewpoint = viewpoint;
  RETURN_IF_ERROR(
      BodyReader(header, options, limits, stop, out).read(as_bytes(std::span(file.substr(header.body_offset)))));
  return out;
}

}  // namespace segserve::codec
