// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/npy_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/npy/python_literal.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;
using Kind = PythonLiteral::Kind;

constexpr std::string_view kMagic = "\x93NUMPY"sv;

absl::Status npy_fault(std::string_view words) { return absl::InvalidArgumentError(std::string(words)); }

/// The type of numbers of a kind of NumPy, and of so many bytes.
std::optional<ScalarType> type_of(char kind, std::uint64_t bytes) {
  if (bytes != 1 && bytes != 2 && bytes != 4 && bytes != 8) return std::nullopt;
  const auto log2 = static_cast<std::uint8_t>(std::countr_zero(bytes));
  const auto from = [log2](ScalarType first) {
    return static_cast<ScalarType>(static_cast<std::uint8_t>(first) + log2);
  };
  if (kind == 'i') return from(ScalarType::kInt8);
  if (kind == 'u') return from(ScalarType::kUint8);
  if (kind == 'b' && bytes == 1) return ScalarType::kUint8;
  if (kind == 'f' && bytes >= 4) return bytes == 4 ? ScalarType::kFloat32 : ScalarType::kFloat64;
  return std::nullopt;
}

/// Reads a type such as "<f4" into the field.
absl::Status read_type(std::string_view text, NpyField& field) {
  constexpr std::uint64_t kMostBytes = 1U << 16U;
  if (text.size() >= 2 && text[1] == 'O') {
    return npy_fault("its elements are Python objects, which cannot be read; save an array of numbers");
  }
  const std::uint64_t bytes = text.size() >= 3 ? parse_count(text.substr(2, text.find('[') - 2)).value_or(0) : 0;
  const bool has_order = !text.empty() && std::string_view("<>|=").find(text[0]) != std::string_view::npos;
  if (bytes == 0 || !has_order || bytes > kMostBytes) {
    return npy_fault(fmt::format("{} is no type of NumPy", quoted(text)));
  }
  const char kind = text[1];
  field.order = text[0] == '>' ? std::endian::big : std::endian::little;
  field.bytes = static_cast<std::size_t>(bytes) * (kind == 'U' ? 4 : 1);  // text has 4 bytes a character
  if (const auto type = type_of(kind, bytes)) {
    field.type = *type;
  } else {
    field.kind = kind == 'f' && bytes == 2 ? NpyKind::kHalf : NpyKind::kOther;
  }
  return absl::OkStatus();
}

/// The number of numbers in a field's own shape.
absl::StatusOr<std::size_t> field_count(const PythonLiteral& shape) {
  std::uint64_t count = 1;
  if (shape.kind == Kind::kCount) {
    count = shape.count;
  } else if (shape.kind == Kind::kSequence) {
    for (const PythonLiteral& size : shape.items) {
      if (size.kind != Kind::kCount) return npy_fault("the shape of a field is no tuple of numbers");
      count = saturating_product(count, size.count);
    }
  } else {
    return npy_fault("the shape of a field is no tuple of numbers");
  }
  if (count > kMostHeaderFields) return npy_fault(fmt::format("a field has more than {} numbers", kMostHeaderFields));
  return static_cast<std::size_t>(count);
}

/// Reads a field such as ('x', '<f4'), (('title', 'x'), '<f4') or ('rgb', '|u1', (3,)).
absl::StatusOr<NpyField> read_field(const PythonLiteral& entry) {
  const bool fits = entry.kind == Kind::kSequence && (entry.items.size() == 2 || entry.items.size() == 3);
  if (!fits) return npy_fault("a field is not a tuple of name, type and perhaps shape");
  NpyField field;
  const PythonLiteral& name = entry.items[0];
  if (name.kind == Kind::kText) {
    field.name = name.text;
  } else if (name.kind == Kind::kSequence && name.items.size() == 2) {
    field.title = name.items[0].text;
    field.name = name.items[1].text;
  }
  if (entry.items[1].kind != Kind::kText) {
    return npy_fault(fmt::format("the field {} has fields of its own, which cannot be read", quoted(field.name)));
  }
  RETURN_IF_ERROR(read_type(entry.items[1].text, field));
  if (entry.items.size() == 3) {
    ASSIGN_OR_RETURN(field.count, field_count(entry.items[2]));
  }
  return field;
}

absl::Status read_fields(const PythonLiteral& description, NpyHeader& header) {
  if (description.kind == Kind::kText) {
    NpyField& field = header.fields.emplace_back();
    RETURN_IF_ERROR(read_type(description.text, field));
    header.element_bytes = field.bytes;
  } else {
    header.is_structured = true;
    if (description.items.size() > kMostHeaderFields) {
      return npy_fault(fmt::format("it has more than {} fields", kMostHeaderFields));
    }
    for (const PythonLiteral& entry : description.items) {
      ASSIGN_OR_RETURN(NpyField field, read_field(entry));
      field.offset = header.element_bytes;
      header.element_bytes += field.count * field.bytes;
      header.fields.push_back(std::move(field));
    }
  }
  return header.element_bytes == 0 ? npy_fault("its elements have no bytes") : absl::OkStatus();
}

absl::Status read_dict(std::string_view text, NpyHeader& header) {
  const auto dict = parse_python_literal(text);
  if (!dict || dict->kind != Kind::kDict) return npy_fault("its header is not a dictionary of Python");
  const PythonLiteral* const description = dict->find("descr");
  const PythonLiteral* const order = dict->find("fortran_order");
  const PythonLiteral* const shape = dict->find("shape");
  if (description == nullptr || order == nullptr || shape == nullptr || shape->kind != Kind::kSequence) {
    return npy_fault("its header lacks 'descr', 'fortran_order' or 'shape'");
  }
  RETURN_IF_ERROR(read_fields(*description, header));
  header.fortran_order = order->count != 0;
  for (const PythonLiteral& size : shape->items) {
    if (size.kind != Kind::kCount) return npy_fault("its shape is no tuple of numbers");
    header.shape.push_back(size.count);
  }
  return absl::OkStatus();
}

absl::StatusOr<NpyHeader> parse(std::string_view file) {
  constexpr std::size_t kMajor = 6, kLength = 8;
  if (file.size() < kLength + 4) return npy_fault("its header is cut off");
  const auto* const bytes = reinterpret_cast<const std::byte*>(file.data());
  const unsigned major = static_cast<unsigned char>(file[kMajor]);
  if (major < 1 || major > 3) return npy_fault(fmt::format("version {} is not known; 1 to 3 are", major));
  const std::size_t begin = major == 1 ? kLength + 2 : kLength + 4;
  const std::size_t length = major == 1 ? load<std::uint16_t>(bytes + kLength) : load<std::uint32_t>(bytes + kLength);
  if (length > kMostHeaderBytes) return npy_fault(fmt::format("its header has more than {} bytes", kMostHeaderBytes));
  if (file.size() - begin < length) return npy_fault("its header is cut off");
  NpyHeader header;
  header.body_offset = begin + length;
  RETURN_IF_ERROR(read_dict(file.substr(begin, length), header));
  return header;
}

}  // namespace

std::uint64_t NpyHeader::elements() const {
  std::uint64_t count = 1;
  for (const std::uint64_t size : shape) count = saturating_product(count, size);
  return count;
}

bool is_npy(std::string_view file) { return file.starts_with(kMagic); }

absl::StatusOr<NpyHeader> parse_npy_header(std::string_view file, std::string_view name) {
  if (!is_npy(file)) return npy_fault(fmt::format("{}: it is no array of NumPy", name));
  auto header = parse(file);
  if (!header.ok()) return npy_fault(fmt::format("{}: {}", name, std::string(header.status().message())));
  return header;
}

}  // namespace segserve::codec
