// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/color_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace segserve::codec {
namespace {

const std::array<ColorNames, 12> kUsualColors{{
    {{"r", "g", "b"}},
    {{"red", "green", "blue"}},
    {{"f_dc_0", "f_dc_1", "f_dc_2"}, ChannelKind::kSphericalHarmonic},
    {{"rot", "grün", "blau"}},
    {{"rot", "gruen", "blau"}},
    {{"rouge", "vert", "bleu"}},
    {{"rojo", "verde", "azul"}},
    {{"rosso", "verde", "blu"}},
    {{"vermelho", "verde", "azul"}},
    {{"rood", "groen", "blauw"}},
    {{"röd", "grön", "blå"}},
    {{"赤", "緑", "青"}},
}};

/// Each pair is the text before and behind r, g and b, or red, green and blue, in a name.
constexpr std::array<std::pair<std::string_view, std::string_view>, 25> kAroundChannel{{
    {"diffuse_", ""}, {"color_", ""}, {"colour_", ""}, {"scalar_", ""}, {"vertex_", ""},  {"vertex_color_", ""},
    {"rgb_", ""},     {"col_", ""},   {"c_", ""},      {"color.", ""},  {"color", ""},    {"colour", ""},
    {"c", ""},        {"", "f"},      {"", "8"},       {"", "16"},      {"", "255"},      {"", "_channel"},
    {"", "_color"},   {"", "_value"}, {"col.", ""},    {"cd.", ""},     {"diffuse.", ""}, {"rgb.", ""},
    {"", "_8bit"},
}};

/// The channels of a color that are numbered, from 0 or 1 on, have a word and the number, with this before and behind
/// it: rgb:0, color[1], rgb_2.
constexpr std::array<std::string_view, 7> kNumberedColors{"rgb", "rgba", "color", "colors", "colour", "colours", "col"};
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kAroundNumber{
    {{":", ""}, {"_", ""}, {"[", "]"}, {".", ""}, {"", ""}}};

std::vector<ColorNames> make_color_names() {
  std::vector<ColorNames> all(kUsualColors.begin(), kUsualColors.end());
  for (const auto& [before, behind] : kAroundChannel) {
    for (const ColorNames& usual : {kUsualColors[0], kUsualColors[1]}) {
      ColorNames names = usual;
      for (std::string& name : names.names) name = fmt::format("{}{}{}", before, name, behind);
      all.push_back(std::move(names));
    }
  }
  for (const std::string_view word : kNumberedColors) {
    for (const auto& [before, behind] : kAroundNumber) {
      for (const int first : {0, 1}) {
        ColorNames names;
        for (int i = 0; i < 3; ++i) names.names[i] = fmt::format("{}{}{}{}", word, before, first + i, behind);
        all.push_back(std::move(names));
      }
    }
  }
  return all;
}

/// The words of a name in small letters: what stands between other characters than letters, or begins with a capital
/// letter behind a small one.
std::vector<std::string> words_of(std::string_view name) {
  const auto is_capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  std::vector<std::string> words;
  bool goes_on = false, was_small = false;
  for (const char c : name) {
    const bool is_small = c >= 'a' && c <= 'z';
    if (!is_small && !is_capital(c)) {
      goes_on = false;
    } else {
      if (!goes_on || (is_capital(c) && was_small)) words.emplace_back();
      words.back() += c;
      goes_on = true;
    }
    was_small = is_small;
  }
  for (std::string& word : words) word = lower_case(word);
  return words;
}

bool is_channel_letter(std::string_view word) { return word == "r" || word == "g" || word == "b"; }

/// Whether a word of the name means a color. One letter alone does not.
bool looks_like_color(std::string_view name) {
  constexpr std::array<std::string_view, 3> kChannels{"red", "green", "blue"};
  constexpr std::array<std::string_view, 4> kBegins{"rgb", "bgr", "color", "colour"};
  constexpr std::array<std::string_view, 2> kEnds{"rgb", "color"};
  const std::vector<std::string> words = words_of(name);
  return lower_case(name).starts_with("f_dc") || std::ranges::any_of(words, [&](const std::string& word) {
           return std::ranges::find(kChannels, word) != kChannels.end() ||
                  std::ranges::any_of(kBegins, [&](std::string_view begin) { return word.starts_with(begin); }) ||
                  std::ranges::any_of(kEnds, [&](std::string_view end) { return word.ends_with(end); });
         });
}

/// The fields with r, g or b as a word of their names, if two of these letters occur: one alone may be a range.
std::vector<std::size_t> lettered_channels(const std::vector<Field>& fields) {
  std::vector<std::size_t> found;
  std::string letters;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::vector<std::string> words = words_of(fields[i].name);
    const auto letter = std::ranges::find_if(words, is_channel_letter);
    if (letter == words.end()) continue;
    found.push_back(i);
    if (letters.find(*letter) == std::string::npos) letters += *letter;
  }
  return letters.size() < 2 ? std::vector<std::size_t>() : found;
}

}  // namespace

const std::vector<ColorNames>& color_names() {
  static const std::vector<ColorNames> kAll = make_color_names();
  return kAll;
}

std::vector<std::size_t> fields_like_colors(const std::vector<Field>& fields) {
  std::vector<std::size_t> found = lettered_channels(fields);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (looks_like_color(fields[i].name)) found.push_back(i);
  }
  std::ranges::sort(found);
  found.erase(std::ranges::unique(found).begin(), found.end());
  return found;
}

}  // namespace segserve::codec
