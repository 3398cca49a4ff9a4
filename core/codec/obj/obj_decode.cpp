// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/obj/obj.hpp"
#include "core/codec/obj/obj_comments.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "OBJ file: ";

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

constexpr std::array<std::string_view, 30> kKeywords{
    "v",    "vn",    "vt",     "vp",     "f",      "fo",     "l",      "p",   "o",    "g",
    "s",    "mg",    "usemtl", "mtllib", "usemap", "maplib", "cstype", "deg", "bmat", "step",
    "curv", "curv2", "surf",   "parm",   "trim",   "hole",   "scrv",   "sp",  "end",  "con"};

bool is_keyword(std::string_view word) { return std::ranges::find(kKeywords, word) != kKeywords.end(); }

bool parse_double(std::string_view word, double& value) {
  return parse_scalar(word, ScalarType::kFloat64, reinterpret_cast<std::byte*>(&value));
}

/// The vertices of a file: six numbers each, with color 0 if they have none. An alpha behind the color is left out. The
/// normals, if they are wanted.
class Vertices {
 public:
  static constexpr std::size_t kNumbers = 6;
  static constexpr std::size_t kMostNumbers = 7;

  explicit Vertices(bool keep_everything) : keep_everything_(keep_everything) {}

  absl::Status read(std::string_view file, const DecodeLimits& limits, StopCheck& check) {
    LineReader lines(file);
    while (const auto line = lines.next()) {
      if (check.after(1)) return check.status();
      std::string_view rest = line->text;
      const std::string_view keyword = take_word(rest);
      if (keyword.empty() || is_continued_) {
      } else if (keyword.starts_with('#')) {
        RETURN_IF_ERROR(comments_.take(line->text, limits, check));
      } else if (keyword == "v") {
        RETURN_IF_ERROR(add_vertex(line->number, rest));
        RETURN_IF_ERROR(check_points(kPrefix, size(), limits));
        const std::size_t numbers = kNumbers + (last_.empty() ? 0 : 1);
        RETURN_IF_ERROR(check_decoded_points(kPrefix, size(), numbers * sizeof(double), limits));
      } else if (keyword == "vn") {
        if (keep_everything_) add_normal(rest);
      } else if (keyword == "f" || keyword == "fo" || keyword == "l") {
        ++connections_;
      } else if (keyword == "usemtl" || keyword == "usemap") {
        has_materials_ = true;
      } else if (!is_keyword(keyword)) {
        ++strange_;
        if (first_strange_.empty()) first_strange_ = fmt::format("line {}: {}", line->number, quoted(line->text));
      }
      is_continued_ = line->text.ends_with('\\');
    }
    move_colors_behind_weights(check);
    take_paint(check);
    return check.status();
  }

  const std::optional<ToldUnit>& unit() const { return comments_.unit(); }

  std::size_t size() const { return values_.size() / kNumbers; }
  bool has_color() const { return size() > 0 && colored_ == size(); }
  Column column(std::size_t i) const {
    return {reinterpret_cast<const std::byte*>(values_.data() + i), kNumbers * sizeof(double), ScalarType::kFloat64};
  }

  /// Whether the normals are those of the vertices, one after the other, as programs write them for clouds.
  bool has_normals() const { return keep_everything_ && size() > 0 && normals_.size() == 3 * size(); }
  Column normal_column(std::size_t axis) const {
    return {reinterpret_cast<const std::byte*>(normals_.data() + axis), 3 * sizeof(double), ScalarType::kFloat64};
  }

  void warn(std::vector<Warning>& warnings) const {
    if (!normals_.empty() && !has_normals()) {
      warnings.push_back(
          {WarningReason::kAttributeNotKept,
           fmt::format("the normals are not kept: {} vertices have {} of them", size(), normals_.size() / 3)});
    }
    if (keep_everything_ && connections_ > 0) {
      warnings.push_back(
          {WarningReason::kAttributeNotKept,
           fmt::format("the faces and lines between the vertices are not kept; there are {}", connections_)});
    }
    if (strange_ > 0) {
      warnings.push_back({WarningReason::kRowsNotUsed,
                          fmt::format("{} lines are of no kind that OBJ has, and not used; the first is {}", strange_,
                                      first_strange_)});
    }
    if (colored_ == 0 && comments_.has_paint()) {
      const std::string_view why = comments_.paint().empty() ? "some of them are no colors" : "they do not fit";
      warnings.push_back(
          {WarningReason::kColorNotUsed,
           fmt::format("the cloud of {} vertices has no color: the colors that ZBrush painted (#MRGB) are not used, "
                       "because {}",
                       size(), why)});
    } else if (colored_ == 0 && has_materials_) {
      warnings.push_back(
          {WarningReason::kColorNotUsed,
           fmt::format("the cloud of {} vertices has no color: it is in materials or textures, which are "
                       "not read; save colors of vertices",
                       size())});
    }
    if (colored_ > 0 && colored_ < size()) {
      warnings.push_back({WarningReason::kColorNotUsed,
                          fmt::format("the cloud has no color: only {} of {} vertices have", colored_, size())});
    }
  }

 private:
  absl::Status add_vertex(std::size_t line, std::string_view words) {
    std::array<double, kNumbers> numbers{};
    double last = 0;  // the alpha behind a color, or the blue of a color behind a weight
    std::size_t count = 0;
    for (std::string_view word = take_word(words); !word.empty(); word = take_word(words), ++count) {
      if (count == kMostNumbers) return fault("line {}: a vertex has at most {} numbers", line, kMostNumbers);
      if (!parse_double(word, count < kNumbers ? numbers[count] : last)) {
        return fault("line {}: {} is not a number of a vertex", line, quoted(word));
      }
    }
    if (count < 3 || count == 5) return fault("line {}: a vertex has 3, 4, 6 or 7 numbers, not {}", line, count);
    if (count == 4) numbers[3] = 0;  // the weight of a curve's point
    if (count >= kNumbers) ++colored_;
    if (count == kMostNumbers) last_.push_back(last);
    values_.insert(values_.end(), numbers.begin(), numbers.end());
    return absl::OkStatus();
  }

  /// Seven numbers are x y z w r g b, if the fourth is 1 throughout and the last, which would be an alpha, varies.
  void move_colors_behind_weights(StopCheck& check) {
    if (last_.empty() || last_.size() != size()) return;
    bool are_weights = true, varies = false;
    check.for_each(0, size(), [&](std::size_t i) {
      are_weights = are_weights && values_[i * kNumbers + 3] == 1;
      varies = varies || last_[i] != last_[0];
    });
    if (!are_weights || !varies) return;
    check.for_each(0, size(), [&](std::size_t i) {
      double* const color = values_.data() + i * kNumbers + 3;
      color[0] = color[1], color[1] = color[2], color[2] = last_[i];
    });
  }

  void take_paint(StopCheck& check) {
    constexpr double kFull = 255;
    const std::vector<std::uint32_t>& paint = comments_.paint();
    if (colored_ > 0 || paint.empty() || paint.size() != size()) return;
    check.for_each(0, size(), [&](std::size_t i) {
      double* const color = values_.data() + i * kNumbers + 3;
      color[0] = red(paint[i]) / kFull, color[1] = green(paint[i]) / kFull, color[2] = blue(paint[i]) / kFull;
    });
    colored_ = size();
  }

  /// Normals are not needed, so that one that is damaged is none.
  void add_normal(std::string_view words) {
    std::array<double, 3> normal{};
    const bool is_read = std::ranges::all_of(normal, [&](double& n) { return parse_double(take_word(words), n); });
    if (is_read) normals_.insert(normals_.end(), normal.begin(), normal.end());
  }

  bool keep_everything_;
  std::vector<double> values_, normals_, last_;  // the last of seven numbers
  ObjComments comments_;
  std::size_t colored_ = 0, strange_ = 0, connections_ = 0;
  std::string first_strange_;
  bool has_materials_ = false;
  bool is_continued_ = false;  // the last line ends in a backslash
};

}  // namespace

bool is_obj(std::string_view file) {
  constexpr std::size_t kEnough = std::size_t{1} << 16U;
  LineReader lines(without_byte_order_mark(file.substr(0, kEnough)));
  while (const auto line = lines.next()) {
    std::string_view rest = line->text;
    const std::string_view keyword = take_word(rest);
    if (keyword.empty() || keyword.starts_with('#')) continue;
    if (keyword.starts_with('v') && is_keyword(keyword)) {
      double number = 0;
      return parse_double(take_word(rest), number);
    }
    constexpr std::array<std::string_view, 6> kNaming{"o", "g", "s", "mtllib", "usemtl", "maplib"};
    return std::ranges::find(kNaming, keyword) != kNaming.end();
  }
  return false;
}

absl::StatusOr<LabeledCloud> decode_obj(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes(kPrefix, bytes.size(), limits));
  StopCheck check(stop);
  Vertices vertices(options.keep_everything);
  RETURN_IF_ERROR(vertices.read(without_byte_order_mark(as_text(bytes)), limits, check));
  LabeledCloud out;
  vertices.warn(out.warnings);
  PointTable table;
  for (const std::string_view name : {"x", "y", "z"}) table.fields.push_back({name, ScalarType::kFloat64});
  table.roles.position = {0, 1, 2};
  if (vertices.has_color()) {
    for (const std::string_view name : {"red", "green", "blue"}) table.fields.push_back({name, ScalarType::kFloat64});
    table.roles.channels = {3, 4, 5};
  }
  table.reference_unit = vertices.unit();
  table.width = static_cast<std::uint32_t>(vertices.size());
  table.height = 1;
  const std::size_t normals = table.fields.size();
  if (vertices.has_normals()) {
    for (const std::string_view name : {"nx", "ny", "nz"}) table.fields.push_back({name, ScalarType::kFloat64});
  }
  table.column = [&vertices, normals](std::size_t i) {
    return i < normals ? vertices.column(i) : vertices.normal_column(i - normals);
  };
  RETURN_IF_ERROR(read_points(table, {}, options, stop, out));
  return out;
}

}  // namespace segserve::codec
