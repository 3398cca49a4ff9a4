// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
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
#include "core/codec/ply/ply_header.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("PLY body: " + fmt::format(format, std::forward<Args>(args)...));
}

/// The length of a list that begins with `bytes`, or nullopt if it is negative.
std::optional<std::uint64_t> list_length(const std::byte* bytes, ScalarType type, std::endian order) {
  return visit_type(type, [&]<typename T>(T) -> std::optional<std::uint64_t> {
    const T length = load<T>(bytes, order);
    if (length < T{0}) return std::nullopt;
    return static_cast<std::uint64_t>(length);
  });
}

/// The vertices of a binary body, of which some properties are kept in its types and byte order.
class BinaryRows {
 public:
  void add_field(ScalarType type, std::size_t /*count*/, bool /*is_coordinate*/) {
    fields_.push_back({bytes_, type, true});
    bytes_ += size_of(type);
  }
  void add_skipped_field() { fields_.emplace_back(); }
  void allocate(std::size_t rows) { data_ = std::make_unique_for_overwrite<std::byte[]>(rows * bytes_); }
  bool is_kept(std::size_t field) const { return fields_[field].is_kept; }
  void put(std::size_t row, std::size_t field, const std::byte* value) {
    std::memcpy(data_.get() + row * bytes_ + fields_[field].offset, value, size_of(fields_[field].type));
  }
  Column column(std::size_t field) const { return {data_.get() + fields_[field].offset, bytes_, fields_[field].type}; }
  ScalarType fitting_type(std::size_t field, StopCheck& /*check*/) const { return fields_[field].type; }

 private:
  struct BinaryField {
    std::size_t offset = 0;  ///< in a row
    ScalarType type = ScalarType::kFloat32;
    bool is_kept = false;
  };
  std::vector<BinaryField> fields_;
  std::size_t bytes_ = 0;
  std::unique_ptr<std::byte[]> data_;
};

// BinaryValues and TextValues have the same members, so that read_element can walk over either kind of body. A member
// that returns false has found a fault, which place() then describes.

/// Walks over the values of a binary body.
class BinaryValues {
 public:
  using Rows = BinaryRows;
  BinaryValues(std::span<const std::byte> body, std::endian order) : rest_(body), order_(order) {}

  std::endian order() const { return order_; }
  static bool was_unreadable() { return false; }
  /// Whether the rest of the body is long enough for an element that has properties.
  bool can_hold(const PlyElement& element) const { return element.rows <= rest_.size() / element.least_row_bytes(); }
  bool begin_row() { return true; }
  bool end_row() { return true; }
  /// Copies the value of a property to a row, or skips it if `rows` is null.
  bool scalar(const PlyProperty& property, std::size_t field, std::size_t row, BinaryRows* rows) {
    const std::size_t bytes = size_of(property.type);
    if (rest_.size() < bytes) return false;
    if (rows != nullptr) rows->put(row, field, rest_.data());
    rest_ = rest_.subspan(bytes);
    return true;
  }
  bool skip_list(const PlyProperty& property) {
    const std::size_t bytes = size_of(*property.length_type);
    if (rest_.size() < bytes) return false;
    const auto length = list_length(rest_.data(), *property.length_type, order_);
    rest_ = rest_.subspan(bytes);
    if (!length || *length > rest_.size() / size_of(property.type)) return false;
    rest_ = rest_.subspan(static_cast<std::size_t>(*length) * size_of(property.type));
    return true;
  }
  /// Warns of bytes that follow the last element, if they are as many as a row of it has.
  void warn_of_surplus(const PlyElement& last, std::vector<Warning>& warnings) const {
    warn_of_surplus_bytes(rest_, last.least_row_bytes(), warnings);
  }
  /// Describes the last fault.
  static std::string place() { return "the body is too short, or the length of a list is wrong"; }

 private:
  std::span<const std::byte> rest_;
  std::endian order_;
};

/// Walks over the values of a text body, which has a line for each row.
class TextValues {
 public:
  using Rows = TypedRows;
  TextValues(std::string_view body, std::size_t first_line)
      : lines_(without_byte_order_mark(body), first_line), bytes_(body.size()) {}

  static std::endian order() { return std::endian::native; }
  /// Whether the body is long enough for an element that has properties.
  bool can_hold(const PlyElement& element) const {
    return element.rows <= most_values(bytes_) / element.properties.size();
  }
  bool begin_row() {
    std::optional<LineReader::Line> line = lines_.next();
    while (line && (is_blank(line->text) || is_comment(line->text))) line = lines_.next();
    if (!line) return explain("it ends too early");
    line_ = *line;
    return true;
  }
  bool end_row() {
    const std::string_view word = take_word(line_.text);
    return word.empty() || explain(fmt::format("{} is one value too many", quoted(word)));
  }
  bool scalar(const PlyProperty& property, std::size_t field, std::size_t row, TypedRows* rows) {
    const std::string_view word = take_word(line_.text);
    if (word.empty()) return explain(fmt::format("the value of '{}' is missing", property.name));
    if (rows == nullptr || rows->put(row, field, 0, word)) return true;
    is_unreadable_ = true;
    return explain(fmt::format("{} is not a value of '{}'", quoted(word), property.name));
  }
  /// Whether the last fault is a word that is not a value, so that the reader can go on behind it.
  bool was_unreadable() { return std::exchange(is_unreadable_, false); }
  bool skip_list(const PlyProperty& property) {
    const std::string_view word = take_word(line_.text);
    const auto length = parse_count(word);
    if (!length) return explain(fmt::format("{} is not the length of the list '{}'", quoted(word), property.name));
    for (std::uint64_t i = 0; i < *length; ++i) {
      if (take_word(line_.text).empty()) return explain(fmt::format("the list '{}' is too short", property.name));
    }
    return true;
  }
  /// Warns of rows that follow the last element.
  void warn_of_surplus(const PlyElement& /*last*/, std::vector<Warning>& warnings) {
    std::uint64_t rows = 0;
    while (begin_row()) ++rows;
    warn_of_surplus_lines(rows, warnings);
  }
  /// Describes the last fault.
  std::string place() const {
    return line_.number == 0 ? explanation_ : fmt::format("line {}: {}", line_.number, explanation_);
  }

 private:
  static bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with("comment "); }

  bool explain(std::string explanation) {
    explanation_ = std::move(explanation);
    return false;
  }

  LineReader lines_;
  std::size_t bytes_;
  LineReader::Line line_{};
  std::string explanation_;
  bool is_unreadable_ = false;
};

/// The properties of the vertices that are kept.
template <typename Rows>
struct Vertices {
  Rows rows;
  std::set<std::size_t> needed;      ///< the properties that cannot be left out, unlike labels
  std::set<std::size_t> unreadable;  ///< the other properties that have words which are no numbers

  /// Keeps all properties but lists, or only those that have a role.
  Vertices(const PlyElement& vertex, const FieldRoles& roles, bool keep_all) {
    const auto used = roles.fields();
    needed = {used.begin(), used.end()};
    const std::set<std::size_t> kept = needed;
    if (roles.label) needed.erase(*roles.label);
    for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
      const PlyProperty& property = vertex.properties[i];
      if (kept.contains(i) || (keep_all && !property.length_type)) {
        rows.add_field(property.type, 1, std::ranges::count(roles.position, i) > 0);
      } else {
        rows.add_skipped_field();
      }
    }
  }
};

/// Reads one row into `vertices`, if that is not null. Returns false after a fault.
template <typename Values>
bool read_row(const PlyElement& element, std::size_t row, Values& values, Vertices<typename Values::Rows>* vertices) {
  if (!values.begin_row()) return false;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.length_type) {
      if (!values.skip_list(property)) return false;
      continue;
    }
    const bool is_kept = vertices != nullptr && vertices->rows.is_kept(i);
    if (values.scalar(property, i, row, is_kept ? &vertices->rows : nullptr)) continue;
    if (!is_kept || vertices->needed.contains(i) || !values.was_unreadable()) return false;
    vertices->unreadable.insert(i);
  }
  return values.end_row();
}

/// Reads one element. Its values are kept in `keep` unless that is null.
template <typename Values>
absl::Status read_element(const PlyElement& element, Values& values, StopCheck& check,
                          Vertices<typename Values::Rows>* keep) {
  if (element.properties.empty()) return absl::OkStatus();
  if (!values.can_hold(element)) return fault("it is too short for {} rows of {}", element.rows, quoted(element.name));
  if (keep != nullptr) keep->rows.allocate(static_cast<std::size_t>(element.rows));
  for (std::uint64_t row = 0; row < element.rows; ++row) {
    if (check.after(element.properties.size())) return check.status();
    if (!read_row(element, static_cast<std::size_t>(row), values, keep)) {
      return fault("row {} (counted from 0) of {}: {}", row, quoted(element.name), values.place());
    }
  }
  return absl::OkStatus();
}

/// Walks over what follows the vertices, which is not needed, only to warn if it is not what the header promises.
template <typename Values>
void check_rest(const PlyHeader& header, Values& values, StopCheck& check, std::vector<Warning>& warnings) {
  for (std::size_t i = header.vertex + 1; i < header.elements.size(); ++i) {
    const absl::Status damage = read_element<Values>(header.elements[i], values, check, nullptr);
    if (check.stopped()) return;
    if (!damage.ok()) {
      warnings.push_back(
          {WarningReason::kRowsNotUsed,
           fmt::format("what follows the vertices is not used, and damaged: {}", std::string(damage.message()))});
      return;
    }
  }
  values.warn_of_surplus(header.elements.back(), warnings);
}

/// Reads the body of a file, whose header is known.
class BodyReader {
 public:
  BodyReader(const PlyHeader& header, const ReadOptions& options, const StopToken& stop, LabeledCloud& out)
      : header_(header), options_(options), stop_(stop), out_(out) {}

  absl::Status read(std::span<const std::byte> body) {
    switch (header_.format) {
      case PlyFormat::kAscii:
        return read_values(TextValues(as_text(body), header_.body_line));
      case PlyFormat::kLittleEndian:
        return read_values(BinaryValues(body, std::endian::little));
      case PlyFormat::kBigEndian:
        break;
    }
    return read_values(BinaryValues(body, std::endian::big));
  }

 private:
  template <typename Values>
  absl::Status read_values(Values values) {
    const PlyElement& vertex = header_.elements[header_.vertex];
    Vertices<typename Values::Rows> vertices(vertex, header_.roles, options_.keep_everything);
    StopCheck check(stop_);
    for (std::size_t i = 0; i <= header_.vertex; ++i) {
      RETURN_IF_ERROR(read_element(header_.elements[i], values, check, i == header_.vertex ? &vertices : nullptr));
    }
    check_rest(header_, values, check, out_.warnings);
    if (options_.keep_everything) warn_of_lists(vertex);
    const auto column = [&](std::size_t property) {
      Column values_of_property = vertices.rows.column(property);
      values_of_property.order = values.order();
      return values_of_property;
    };
    PointTable table{fields_of(vertex), header_.roles, static_cast<std::uint32_t>(vertex.rows), 1, column};
    for (std::size_t i = 0; i < table.fields.size(); ++i) {
      if (vertices.needed.contains(i) || !vertices.rows.is_kept(i)) continue;
      table.fields[i].type = vertices.rows.fitting_type(i, check);
    }
    RETURN_IF_ERROR(check.status());
    leave_out(vertices.unreadable, table, out_.warnings);
    return read_points(table, {.stated = header_.stated_view}, options_, stop_, out_);
  }

  void warn_of_lists(const PlyElement& vertex) {
    for (const PlyProperty& property : vertex.properties) {
      if (!property.length_type) continue;
      out_.warnings.push_back(
          {WarningReason::kAttributeNotKept, fmt::format("the list {} is not kept", quoted(property.name))});
    }
  }

  const PlyHeader& header_;
  const ReadOptions& options_;
  const StopToken& stop_;
  LabeledCloud& out_;
};

}  // namespace

absl::StatusOr<LabeledCloud> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("PLY file: ", bytes.size(), limits));
  const std::string_view file = without_byte_order_mark(as_text(bytes));
  ASSIGN_OR_RETURN(PlyHeader header, parse_ply_header(file, limits));
  LabeledCloud out;
  out.warnings = std::move(header.warnings);
  RETURN_IF_ERROR(BodyReader(header, options, stop, out).read(as_bytes(std::span(file.substr(header.body_offset)))));
  return out;
}

}  // namespace segserve::codec
