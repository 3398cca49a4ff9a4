// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <type_traits>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/typed_rows.hpp"
#include "core/codec/ply/ply_header.hpp"
#include "core/codec/ply/ply_values.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("PLY body: " + fmt::format(format, std::forward<Args>(args)...));
}

/// The properties of the vertices that are kept.
template <typename Rows>
struct Vertices {
  Rows rows;
  std::array<std::size_t, 3> position;
  std::set<std::size_t> used;  ///< the properties that make points and colors, whose types are those of the header
  UnreadableFields unreadable;

  /// Keeps all properties but lists, or only those that have a role.
  Vertices(const PlyElement& vertex, const FieldRoles& roles, bool keep_all) : position(roles.position) {
    const auto with_role = roles.fields();
    used = {with_role.begin(), with_role.end()};
    const std::set<std::size_t> kept = used;
    if (roles.label) used.erase(*roles.label);
    for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
      const PlyProperty& property = vertex.properties[i];
      if (kept.contains(i) || (keep_all && !property.length_type)) {
        if constexpr (std::is_same_v<Rows, TypedRows>) {
          rows.add_field(property.type, 1, roles.is_position(i));
        } else {
          rows.add_field(property.type);
        }
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
    if (!is_kept || std::ranges::count(vertices->position, i) > 0 || !values.was_unreadable()) return false;
    vertices->unreadable.try_emplace(i, values.place());
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
/// Returns false if it is damaged.
template <typename Values>
bool check_rest(const PlyHeader& header, Values& values, StopCheck& check, std::vector<Warning>& warnings) {
  for (std::size_t i = header.vertex + 1; i < header.elements.size(); ++i) {
    const absl::Status damage = read_element<Values>(header.elements[i], values, check, nullptr);
    if (check.stopped()) return true;
    if (!damage.ok()) {
      warnings.push_back(
          {WarningReason::kRowsNotUsed,
           fmt::format("what follows the vertices is not used, and damaged: {}", std::string(damage.message()))});
      return false;
    }
  }
  values.warn_of_surplus(header.elements.back(), warnings);
  return true;
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
    const bool is_whole = check_rest(header_, values, check, out_.warnings);
    if (options_.keep_everything) {
      warn_of_lists(vertex);
      // Damaged elements behind the vertices were mentioned.
      warn_of_elements(is_whole ? header_.elements.size() : header_.vertex);
    }
    const auto column = [&](std::size_t property) {
      Column values_of_property = vertices.rows.column(property);
      values_of_property.order = values.order();
      return values_of_property;
    };
    PointTable table{fields_of(vertex), header_.roles, static_cast<std::uint32_t>(vertex.rows), 1, column,
                     header_.stated};
    if constexpr (std::is_same_v<typename Values::Rows, TypedRows>) {
      for (std::size_t i = 0; i < table.fields.size(); ++i) {
        if (vertices.used.contains(i) || !vertices.rows.is_kept(i)) continue;
        table.fields[i].type = vertices.rows.fitting_type(i, check);
      }
    }
    RETURN_IF_ERROR(check.status());
    leave_out(std::move(vertices.unreadable), table, out_.warnings);
    return read_points(table, {}, options_, stop_, out_);
  }

  void warn_not_kept(std::string message) {
    out_.warnings.push_back({WarningReason::kAttributeNotKept, std::move(message)});
  }

  void warn_of_lists(const PlyElement& vertex) {
    for (const PlyProperty& property : vertex.properties) {
      if (property.length_type) warn_not_kept(fmt::format("the list {} is not kept", quoted(property.name)));
    }
  }

  /// Warns of the elements before `end` other than the vertices.
  void warn_of_elements(std::size_t end) {
    for (std::size_t i = 0; i < end; ++i) {
      const PlyElement& element = header_.elements[i];
      if (i == header_.vertex || element.rows == 0) continue;
      warn_not_kept(fmt::format("the element {} is not kept, which has {} row{}", quoted(element.name), element.rows,
                                element.rows == 1 ? "" : "s"));
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
