// SPDX-License-Identifier: Apache-2.0
#include "core/codec/pcd/pcd_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "PCD header: ";

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

/// One line of the header: its number, and its words after the keyword.
struct Entry {
  std::size_t line = 0;
  std::vector<std::string_view> words;
};
using Entries = std::map<std::string_view, Entry>;

constexpr std::array<std::string_view, 10> kKeywords{"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                     "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return upper;
}

absl::Status check_keyword(std::string_view keyword, std::size_t line, const Entries& entries) {
  if (std::find(kKeywords.begin(), kKeywords.end(), keyword) == kKeywords.end()) {
    if (entries.empty()) {
      return absl::InvalidArgumentError(fmt::format(
          "not a PCD file: line {} begins with {}, which is no entry of a PCD header", line, quoted(keyword)));
    }
    return fault("line {} begins with {}, which is no entry of a PCD header", line, quoted(keyword));
  }
  if (entries.contains(keyword)) {
    return fault("{} occurs twice, in lines {} and {}", keyword, entries.at(keyword).line, line);
  }
  return absl::OkStatus();
}

/// Collects the entries up to DATA, and notes in `header` where the body begins.
absl::StatusOr<Entries> split_header(std::string_view file, PcdHeader& header) {
  Entries entries;
  LineReader lines(header_part(file));
  while (const auto line = lines.next()) {
    std::string_view text = line->text;
    std::string_view keyword = take_word(text);
    if (keyword.starts_with('#')) {
      const std::size_t begin = line->text.find_first_not_of("# \t");
      header.stated.take(line->text.substr(std::min(begin, line->text.size())));
      continue;
    }
    if (keyword.empty()) continue;
    if (const auto known = std::ranges::find(kKeywords, upper_case(keyword)); known != kKeywords.end()) {
      keyword = *known;
    }
    if (keyword == "COLUMNS") keyword = "FIELDS";  // The entry had this name before version 0.6.
    RETURN_IF_ERROR(check_keyword(keyword, line->number, entries));
    if (!line->terminated) break;
    entries[keyword] = {line->number, split_words(text.substr(0, text.find('#')))};
    if (keyword == "DATA") {
      header.body_offset = lines.offset();
      header.body_line = line->number + 1;
      return entries;
    }
  }
  if (entries.empty()) return absl::InvalidArgumentError("not a PCD file: it has no entry of a PCD header");
  if (file.size() > kMostHeaderBytes) return fault("no line DATA is in the first {} bytes", kMostHeaderBytes);
  return fault("it ends without a line DATA");
}

const Entry* find_entry(const Entries& entries, std::string_view keyword) {
  const auto found = entries.find(keyword);
  return found == entries.end() ? nullptr : &found->second;
}

absl::StatusOr<std::optional<std::uint64_t>> read_count(const Entries& entries, std::string_view keyword) {
  const Entry* entry = find_entry(entries, keyword);
  if (entry == nullptr) return std::nullopt;
  const auto count = entry->words.size() == 1 ? parse_count(entry->words[0]) : std::nullopt;
  if (!count) return fault("{} in line {} must be one whole number", keyword, entry->line);
  return count;
}

std::optional<ScalarType> scalar_type(std::string_view type, std::string_view size) {
  constexpr std::array<std::pair<std::string_view, ScalarType>, 10> kTypes{{{"F4", ScalarType::kFloat32},
                                                                            {"F8", ScalarType::kFloat64},
                                                                            {"U1", ScalarType::kUint8},
                                                                            {"U2", ScalarType::kUint16},
                                                                            {"U4", ScalarType::kUint32},
                                                                            {"U8", ScalarType::kUint64},
                                                                            {"I1", ScalarType::kInt8},
                                                                            {"I2", ScalarType::kInt16},
                                                                            {"I4", ScalarType::kInt32},
                                                                            {"I8", ScalarType::kInt64}}};
  const std::string name = fmt::format("{}{}", type, size);
  for (const auto& [known, scalar] : kTypes) {
    if (known == name) return scalar;
  }
  return std::nullopt;
}

/// The entry `keyword`, which must have one word for each of the `fields` fields.
absl::StatusOr<const Entry*> per_field_entry(const Entries& entries, std::string_view keyword, std::size_t fields) {
  const Entry* entry = find_entry(entries, keyword);
  if (entry == nullptr) return fault("{} is missing", keyword);
  if (entry->words.size() != fields) {
    return fault("{} in line {} has {} values for {} FIELDS", keyword, entry->line, entry->words.size(), fields);
  }
  return entry;
}

/// Parses one field from its words in FIELDS, TYPE, SIZE and COUNT.
absl::StatusOr<PcdField> parse_field(std::string_view name, std::string_view type_word, std::string_view size_word,
                                     std::string_view count_word) {
  const auto type = scalar_type(type_word, size_word);
  if (!type) {
    return fault("field {} has TYPE {} and SIZE {}; they must be F4, F8, U1, U2, U4, U8, I1, I2, I4 or I8",
                 quoted(name), quoted(type_word), quoted(size_word));
  }
  const auto count = parse_count(count_word);
  if (!count || *count == 0) {
    return fault("COUNT of field {} is {}; it must be a whole number of at least 1", quoted(name), quoted(count_word));
  }
  return PcdField{std::string(name), *type, static_cast<std::size_t>(*count)};
}

absl::Status read_fields(const Entries& entries, const DecodeLimits& limits, PcdHeader& header) {
  const Entry* names = find_entry(entries, "FIELDS");
  if (names == nullptr || names->words.empty()) return fault("FIELDS is missing");
  const std::size_t n = names->words.size();
  if (n > kMostHeaderFields) return fault("{} FIELDS are more than the {} that are accepted", n, kMostHeaderFields);
  ASSIGN_OR_RETURN(const Entry* const sizes, per_field_entry(entries, "SIZE", n));
  ASSIGN_OR_RETURN(const Entry* const types, per_field_entry(entries, "TYPE", n));
  const Entry ones{names->line, std::vector<std::string_view>(n, "1")};
  const Entry* counts = &ones;
  if (find_entry(entries, "COUNT") != nullptr) {
    ASSIGN_OR_RETURN(counts, per_field_entry(entries, "COUNT", n));
  }
  std::uint64_t bytes_left = limits.max_bytes;
  for (std::size_t i = 0; i < n; ++i) {
    ASSIGN_OR_RETURN(PcdField field, parse_field(names->words[i], types->words[i], sizes->words[i], counts->words[i]));
    if (field.count > bytes_left / size_of(field.type)) {
      const std::uint64_t bytes_before = limits.max_bytes - bytes_left;
      return over_limit(
          fmt::format("{}COUNT {} of field {} makes one point larger than the limit of {} bytes", kPrefix, field.count,
                      quoted(field.name), limits.max_bytes),
          {"max_bytes", saturating_sum(bytes_before, saturating_product(field.count, size_of(field.type))),
           limits.max_bytes});
    }
    bytes_left -= field.bytes();
    header.fields.push_back(std::move(field));
  }
  return absl::OkStatus();
}

absl::Status read_shape(const Entries& entries, const DecodeLimits& limits, PcdHeader& header) {
  ASSIGN_OR_RETURN(const auto given_points, read_count(entries, "POINTS"));
  ASSIGN_OR_RETURN(const auto given_width, read_count(entries, "WIDTH"));
  ASSIGN_OR_RETURN(const auto given_height, read_count(entries, "HEIGHT"));
  if (!given_points && !given_width) return fault("POINTS and WIDTH are missing");
  const std::uint64_t width = given_width ? *given_width : *given_points;
  // Some programs write HEIGHT 0 for a cloud that is not organized.
  const bool is_flat = given_height == 0 && given_points.value_or(width) == width;
  const std::uint64_t height = is_flat ? 1 : given_height.value_or(1);
  constexpr std::uint64_t kMaxSide = std::numeric_limits<std::uint32_t>::max();
  if (width > kMaxSide || height > kMaxSide) {
    return over_limit(
        fmt::format("{}WIDTH {} x HEIGHT {} exceeds the limit of {} points", kPrefix, width, height, limits.max_points),
        {"max_points", std::max(width, height), limits.max_points});
  }
  const std::uint64_t points = width * height;  // less than 2^64
  if (given_points.value_or(points) != points) {
    return fault("POINTS {} is not WIDTH {} x HEIGHT {}", *given_points, width, height);
  }
  RETURN_IF_ERROR(check_points(kPrefix, points, limits));
  header.width = static_cast<std::uint32_t>(width);
  header.height = static_cast<std::uint32_t>(height);
  header.points = static_cast<std::size_t>(points);
  return absl::OkStatus();
}

absl::Status read_viewpoint(const Entries& entries, PcdHeader& header) {
  const Entry* entry = find_entry(entries, "VIEWPOINT");
  if (entry == nullptr) return absl::OkStatus();
  std::array<double, 7> pose{};  // translation x y z, rotation w x y z
  bool good = entry->words.size() == pose.size();
  for (std::size_t i = 0; good && i < pose.size(); ++i) {
    good = parse_scalar(entry->words[i], ScalarType::kFloat64, reinterpret_cast<std::byte*>(&pose[i])) &&
           std::isfinite(pose[i]);
  }
  if (!good) return fault("VIEWPOINT in line {} must be 7 finite numbers: tx ty tz qw qx qy qz", entry->line);
  header.viewpoint = {{pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5], pose[6]}};
  return absl::OkStatus();
}

absl::Status read_encoding(const Entries& entries, PcdHeader& header) {
  const Entry& entry = entries.at("DATA");
  const std::string word = lower_case(entry.words.size() == 1 ? entry.words[0] : "");
  if (word == "ascii") {
    header.encoding = PcdEncoding::kAscii;
  } else if (word == "binary") {
    header.encoding = PcdEncoding::kBinary;
  } else if (word == "binary_compressed") {
    header.encoding = PcdEncoding::kBinaryCompressed;
  } else {
    return fault("DATA in line {} is {}; it must be ascii, binary or binary_compressed", entry.line,
                 quoted(entry.words.empty() ? "" : entry.words[0]));
  }
  return absl::OkStatus();
}

absl::Status assign_roles(PcdHeader& header) {
  auto roles = find_field_roles(header.point_fields(), header.warnings);
  if (!roles.ok()) return with_prefix("PCD header: FIELDS", roles.status());
  header.roles = *std::move(roles);
  return absl::OkStatus();
}

}  // namespace

std::vector<Field> PcdHeader::point_fields() const {
  std::vector<Field> all;
  all.reserve(fields.size());
  for (const PcdField& field : fields) all.push_back({field.name, field.type, field.count});
  return all;
}

std::size_t PcdHeader::point_bytes(bool with_padding) const {
  std::size_t sum = 0;
  for (const PcdField& field : fields) sum += with_padding || !field.is_padding() ? field.bytes() : 0;
  return sum;
}

absl::StatusOr<PcdHeader> parse_pcd_header(std::string_view file, const DecodeLimits& limits) {
  PcdHeader header;
  ASSIGN_OR_RETURN(const Entries entries, split_header(file, header));
  RETURN_IF_ERROR(read_fields(entries, limits, header));
  RETURN_IF_ERROR(read_shape(entries, limits, header));
  RETURN_IF_ERROR(read_viewpoint(entries, header));
  RETURN_IF_ERROR(read_encoding(entries, header));
  RETURN_IF_ERROR(assign_roles(header));
  return header;
}

}  // namespace segserve::codec
