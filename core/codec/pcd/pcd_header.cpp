// SPDX-License-Identifier: Apache-2.0
#include "core/codec/pcd/pcd_header.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("PCD header: " + fmt::format(format, std::forward<Args>(args)...));
}

/// One line of the header, split: its words after the keyword.
struct Entry {
  std::size_t line = 0;
  std::vector<std::string_view> words;
};
using Entries = std::map<std::string_view, Entry>;

constexpr std::array<std::string_view, 10> kKeywords{"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                     "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

absl::Status check_keyword(std::string_view keyword, std::size_t line, const Entries& entries) {
  if (std::find(kKeywords.begin(), kKeywords.end(), keyword) == kKeywords.end()) {
    if (entries.empty()) {
      return absl::InvalidArgumentError(fmt::format(
          "not a PCD file: line {} begins with {}, not with an entry of a PCD header", line, quoted(keyword)));
    }
    return fault("line {} begins with {}, which is no entry of a PCD header", line, quoted(keyword));
  }
  if (entries.contains(keyword)) {
    return fault("{} in line {} is there already in line {}", keyword, line, entries.at(keyword).line);
  }
  return absl::OkStatus();
}

/// Collects the entries up to DATA and notes where the body begins.
absl::StatusOr<Entries> split_header(std::string_view file, PcdHeader& header) {
  Entries entries;
  LineReader lines(file);
  while (const auto line = lines.next()) {
    std::string_view text = line->text;
    std::string_view keyword = take_word(text);
    if (keyword.empty() || keyword.starts_with('#')) continue;
    if (keyword == "COLUMNS") keyword = "FIELDS";  // its name before 0.6
    if (auto status = check_keyword(keyword, line->number, entries); !status.ok()) return status;
    if (!line->terminated) break;
    entries[keyword] = {line->number, split_words(text)};
    if (keyword == "DATA") {
      header.body_offset = lines.offset();
      header.body_line = line->number + 1;
      return entries;
    }
  }
  if (entries.empty()) return absl::InvalidArgumentError("not a PCD file: it has no entry of a PCD header");
  return fault("it ends without a line DATA");
}

const Entry* find(const Entries& entries, std::string_view keyword) {
  const auto found = entries.find(keyword);
  return found == entries.end() ? nullptr : &found->second;
}

absl::StatusOr<std::optional<std::uint64_t>> read_count(const Entries& entries, std::string_view keyword) {
  const Entry* entry = find(entries, keyword);
  if (entry == nullptr) return std::nullopt;
  const auto count = entry->words.size() == 1 ? parse_count(entry->words[0]) : std::nullopt;
  if (!count) return fault("{} in line {} must be one whole number", keyword, entry->line);
  return count;
}

absl::Status read_version(const Entries& entries) {
  constexpr std::array<std::string_view, 6> kVersions{"0.7", ".7", "0.6", ".6", "0.5", ".5"};
  const Entry* entry = find(entries, "VERSION");
  if (entry == nullptr) return absl::OkStatus();
  if (entry->words.size() != 1 || std::find(kVersions.begin(), kVersions.end(), entry->words[0]) == kVersions.end()) {
    return fault("VERSION in line {} is {}; 0.5, 0.6 and 0.7 can be read", entry->line,
                 entry->words.empty() ? "missing" : quoted(entry->words[0]));
  }
  return absl::OkStatus();
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

absl::StatusOr<const Entry*> per_field_entry(const Entries& entries, std::string_view keyword, std::size_t fields) {
  const Entry* entry = find(entries, keyword);
  if (entry == nullptr) return fault("{} is missing", keyword);
  if (entry->words.size() != fields) {
    return fault("{} in line {} has {} values for {} FIELDS", keyword, entry->line, entry->words.size(), fields);
  }
  return entry;
}

absl::Status read_fields(const Entries& entries, const DecodeLimits& limits, PcdHeader& header) {
  const Entry* names = find(entries, "FIELDS");
  if (names == nullptr || names->words.empty()) return fault("FIELDS is missing");
  const std::size_t n = names->words.size();
  const auto sizes = per_field_entry(entries, "SIZE", n);
  if (!sizes.ok()) return sizes.status();
  const auto types = per_field_entry(entries, "TYPE", n);
  if (!types.ok()) return types.status();
  const Entry ones{names->line, std::vector<std::string_view>(n, "1")};
  const auto counts = find(entries, "COUNT") == nullptr ? &ones : per_field_entry(entries, "COUNT", n);
  if (!counts.ok()) return counts.status();
  std::uint64_t point_bytes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string_view name = names->words[i];
    const auto type = scalar_type((*types)->words[i], (*sizes)->words[i]);
    if (!type) {
      return fault("field {} has TYPE {} and SIZE {}; known are F4 F8 U1 U2 U4 U8 I1 I2 I4 I8", quoted(name),
                   quoted((*types)->words[i]), quoted((*sizes)->words[i]));
    }
    const auto count = parse_count((*counts)->words[i]);
    if (!count || *count == 0) {
      return fault("COUNT of field {} is {}; it must be a whole number from 1", quoted(name),
                   quoted((*counts)->words[i]));
    }
    if (*count > (limits.max_bytes - point_bytes) / size_of(*type)) {
      const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
      return over_limit(
          fmt::format("PCD header: COUNT {} of field {} makes one point larger than the limit of {} bytes", *count,
                      quoted(name), limits.max_bytes),
          {"max_bytes", *count > (most - point_bytes) / size_of(*type) ? most : point_bytes + *count * size_of(*type),
           limits.max_bytes});
    }
    header.fields.push_back({std::string(name), *type, static_cast<std::size_t>(*count)});
    point_bytes += header.fields.back().bytes();
  }
  return absl::OkStatus();
}

absl::Status read_shape(const Entries& entries, const DecodeLimits& limits, PcdHeader& header) {
  const auto points = read_count(entries, "POINTS");
  if (!points.ok()) return points.status();
  const auto given_width = read_count(entries, "WIDTH");
  if (!given_width.ok()) return given_width.status();
  const auto given_height = read_count(entries, "HEIGHT");
  if (!given_height.ok()) return given_height.status();
  if (!*points && !*given_width) return fault("POINTS and WIDTH are missing");
  const std::uint64_t width = given_width->value_or(points->value_or(0));
  const std::uint64_t height = given_height->value_or(1);
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint32_t>::max();
  if (width > kLargest || height > kLargest) {
    return over_limit(fmt::format("PCD header: WIDTH {} x HEIGHT {} exceeds the limit of {} points", width, height,
                                  limits.max_points),
                      {"max_points", std::max(width, height), limits.max_points});
  }
  if (points->value_or(width * height) != width * height) {
    return fault("POINTS {} is not WIDTH {} x HEIGHT {}", **points, width, height);
  }
  if (width * height > limits.max_points) {
    return over_limit(
        fmt::format("PCD header: POINTS {} exceeds the limit of {} points", width * height, limits.max_points),
        {"max_points", width * height, limits.max_points});
  }
  header.width = static_cast<std::uint32_t>(width);
  header.height = static_cast<std::uint32_t>(height);
  header.points = static_cast<std::size_t>(width * height);
  return absl::OkStatus();
}

absl::Status read_viewpoint(const Entries& entries, PcdHeader& header) {
  const Entry* entry = find(entries, "VIEWPOINT");
  if (entry == nullptr) return absl::OkStatus();
  std::array<float, 7> pose{};  // translation x y z, rotation w x y z
  bool good = entry->words.size() == pose.size();
  for (std::size_t i = 0; good && i < pose.size(); ++i) {
    good = parse_scalar(entry->words[i], ScalarType::kFloat32, reinterpret_cast<std::byte*>(&pose[i])) &&
           std::isfinite(pose[i]);
  }
  if (!good) return fault("VIEWPOINT in line {} must be 7 finite numbers: tx ty tz qw qx qy qz", entry->line);
  header.viewpoint = {pose[0], pose[1], pose[2]};
  const auto is_zero = [&](std::size_t i) { return pose[i] == 0.0F; };
  header.identity_viewpoint = is_zero(0) && is_zero(1) && is_zero(2) && is_zero(4) && is_zero(5) && is_zero(6);
  return absl::OkStatus();
}

absl::Status read_encoding(const Entries& entries, PcdHeader& header) {
  const Entry& entry = entries.at("DATA");
  const std::string_view word = entry.words.size() == 1 ? entry.words[0] : "";
  if (word == "ascii") {
    header.encoding = PcdEncoding::kAscii;
  } else if (word == "binary") {
    header.encoding = PcdEncoding::kBinary;
  } else if (word == "binary_compressed") {
    header.encoding = PcdEncoding::kBinaryCompressed;
  } else {
    return fault("DATA in line {} is {}; known are ascii, binary and binary_compressed", entry.line,
                 quoted(entry.words.empty() ? "" : entry.words[0]));
  }
  return absl::OkStatus();
}

absl::Status check_roles(const PcdHeader& header) {
  for (const std::size_t i : header.roles.fields()) {
    const PcdField& field = header.fields[i];
    if (field.count != 1) return fault("COUNT of field '{}' is {}; it must be 1", field.name, field.count);
  }
  for (const std::size_t i : header.roles.position) {
    const PcdField& field = header.fields[i];
    if (!is_float(field.type)) return fault("field '{}' must have TYPE F", field.name);
  }
  if (header.roles.packed) {
    const PcdField& field = header.fields[*header.roles.packed];
    if (field.bytes() != 4) {
      return fault("field '{}' is packed color and must have SIZE 4, not {}", field.name, field.bytes());
    }
  }
  return absl::OkStatus();
}

absl::Status assign_roles(PcdHeader& header) {
  std::vector<std::string_view> names;
  names.reserve(header.fields.size());
  for (const PcdField& field : header.fields) names.emplace_back(field.name);
  const auto in_fields = [](const absl::Status& status) { return fault("FIELDS: {}", std::string(status.message())); };
  const auto position = find_three(names, {"x", "y", "z"});
  if (!position.ok()) return in_fields(position.status());
  if (!*position) return fault("FIELDS must contain x, y and z");
  const auto rgb = find_unique(names, "rgb");
  if (!rgb.ok()) return in_fields(rgb.status());
  const auto rgba = find_unique(names, "rgba");
  if (!rgba.ok()) return in_fields(rgba.status());
  const auto channels = find_three(names, {"r", "g", "b"});
  if (!channels.ok()) return in_fields(channels.status());
  const auto label = find_unique(names, "label");
  if (!label.ok()) return in_fields(label.status());
  header.roles.position = **position;
  header.roles.packed = rgb->has_value() ? *rgb : *rgba;
  if (!header.roles.packed) header.roles.channels = *channels;
  header.roles.label = *label;
  return check_roles(header);
}

}  // namespace

std::size_t PcdHeader::point_bytes() const {
  std::size_t sum = 0;
  for (const PcdField& field : fields) {
    if (!(field.is_padding() && encoding == PcdEncoding::kBinaryCompressed)) sum += field.bytes();
  }
  return sum;
}

absl::StatusOr<PcdHeader> parse_pcd_header(std::string_view file, const DecodeLimits& limits) {
  PcdHeader header;
  const auto entries = split_header(file, header);
  if (!entries.ok()) return entries.status();
  if (auto status = read_version(*entries); !status.ok()) return status;
  if (auto status = read_fields(*entries, limits, header); !status.ok()) return status;
  if (auto status = read_shape(*entries, limits, header); !status.ok()) return status;
  if (auto status = read_viewpoint(*entries, header); !status.ok()) return status;
  if (auto status = read_encoding(*entries, header); !status.ok()) return status;
  if (auto status = assign_roles(header); !status.ok()) return status;
  return header;
}

}  // namespace segserve::codec
