// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/well_known_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using CoordinateKind = ReferenceSystem::CoordinateKind;

struct SystemKeyword {
  std::string_view word;  ///< in small letters
  CoordinateKind kind;
};

constexpr std::array<SystemKeyword, 12> kSystems{{
    {"projcs", CoordinateKind::kLengths},
    {"projcrs", CoordinateKind::kLengths},
    {"projectedcrs", CoordinateKind::kLengths},
    {"local_cs", CoordinateKind::kLengths},
    {"engcrs", CoordinateKind::kLengths},
    {"engineeringcrs", CoordinateKind::kLengths},
    {"geoccs", CoordinateKind::kLengths},
    {"geogcs", CoordinateKind::kDegrees},
    {"geogcrs", CoordinateKind::kDegrees},
    {"geographiccrs", CoordinateKind::kDegrees},
    {"geodcrs", CoordinateKind::kDegrees},
    {"geodeticcrs", CoordinateKind::kDegrees},
}};

/// Keywords of systems that have nothing but heights, in small letters.
constexpr std::array<std::string_view, 4> kHeightSystems{"vert_cs", "vertcs", "vertcrs", "verticalcrs"};

/// The factor in `"US survey foot",0.304800609601219,ID[..]`; nullopt if there is none.
std::optional<double> unit_factor(std::string_view body) {
  const std::size_t end_of_name = body.find('"', body.find('"') + 1);
  if (end_of_name == std::string_view::npos) return std::nullopt;
  const std::size_t comma = body.find(',', end_of_name);
  if (comma == std::string_view::npos) return std::nullopt;
  body.remove_prefix(comma + 1);
  body = body.substr(0, body.find(','));
  double factor = 0;
  const bool is_number = parse_scalar(take_word(body), ScalarType::kFloat64, reinterpret_cast<std::byte*>(&factor));
  return is_number ? std::optional(factor) : std::nullopt;
}

bool is_of_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// The word at the end of a text, in small letters.
std::string last_word(std::string_view text) {
  const std::size_t end = text.find_last_not_of(" \t\r\n") + 1;
  std::size_t begin = end;
  while (begin > 0 && is_of_word(text[begin - 1])) --begin;
  return lower_case(text.substr(begin, end - begin));
}

/// Walks over the elements KEYWORD[..] of a text, which lie in one another.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::optional<ReferenceSystem> run() {
    bool is_quoted = false;
    for (std::size_t i = 0; i < text_.size(); ++i) {
      const char c = text_[i];
      if (c == '"') {
        is_quoted = !is_quoted;
      } else if (is_quoted) {
        continue;
      } else if (c == '[' || c == '(') {
        if (open_.size() == kMostDepth) return std::nullopt;
        begin(i);
      } else if (c == ']' || c == ')') {
        if (open_.empty()) return std::nullopt;
        end(i);
      }
    }
    return is_quoted || !open_.empty() ? std::nullopt : std::optional(found_);
  }

 private:
  struct Element {
    std::string keyword;   ///< in small letters
    std::size_t body = 0;  ///< where the text behind the bracket begins
  };
  struct System {
    std::size_t depth = 0;  ///< how many elements were open when it had begun; 0 before it
    bool is_done = false;   ///< it has ended

    bool is_open() const { return depth > 0 && !is_done; }
  };
  static constexpr std::size_t kMostDepth = 32;

  void begin(std::size_t bracket) {
    const std::size_t body_of_parent = open_.empty() ? 0 : open_.back().body;
    open_.push_back({last_word(text_.substr(body_of_parent, bracket - body_of_parent)), bracket + 1});
    const std::string& keyword = open_.back().keyword;
    if (horizontal_.is_open() && keyword == "axis" && open_.size() == horizontal_.depth + 1) ++axes_;
    if (height_.depth == 0 && std::ranges::find(kHeightSystems, keyword) != kHeightSystems.end()) {
      height_.depth = open_.size();
    }
    const auto* const system = std::ranges::find(kSystems, keyword, &SystemKeyword::word);
    if (horizontal_.depth > 0 || system == kSystems.end()) return;
    horizontal_.depth = open_.size();
    found_.kind = system->kind;
  }

  void end(std::size_t bracket) {
    const Element element = open_.back();
    open_.pop_back();
    const std::string_view body = text_.substr(element.body, bracket - element.body);
    if (is_inside(horizontal_)) take(element.keyword, body);
    if (is_inside(height_) && is_unit(element.keyword)) take_unit(body, found_.meters_per_height_unit);
    for (System* const system : {&horizontal_, &height_}) {
      system->is_done = system->is_done || open_.size() + 1 == system->depth;
    }
  }

  /// Whether what ends lies in the system itself, or in one of its axes.
  bool is_inside(const System& system) const {
    return system.is_open() &&
           (open_.size() == system.depth || (open_.size() == system.depth + 1 && open_.back().keyword == "axis"));
  }

  static bool is_unit(std::string_view keyword) { return keyword == "unit" || keyword == "lengthunit"; }

  static void take_unit(std::string_view body, std::optional<double>& meters) {
    if (const auto factor = unit_factor(body)) meters = factor;
  }

  void take(const std::string& keyword, std::string_view body) {
    constexpr std::size_t kHeightAxis = 3;
    if (is_unit(keyword)) {
      const bool is_of_height = open_.size() > horizontal_.depth && axes_ == kHeightAxis;
      take_unit(body, is_of_height ? found_.meters_per_height_unit : found_.meters_per_unit);
    } else if (keyword == "cs" && lower_case(body).starts_with("cartesian")) {
      found_.kind = CoordinateKind::kLengths;  // geocentric coordinates of a geodetic system
    }
  }

  std::string_view text_;
  std::vector<Element> open_;
  System horizontal_, height_;
  std::size_t axes_ = 0;  // of the horizontal system, up to here
  ReferenceSystem found_;
};

}  // namespace

std::optional<ReferenceSystem> parse_well_known_text(std::string_view text) { return Scanner(text).run(); }

}  // namespace segserve::codec
