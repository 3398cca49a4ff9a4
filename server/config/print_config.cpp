// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "server/config/configuration.hpp"

namespace segserve::server {
namespace {

/// True if TOML's number, written by us again, is this text.
bool is_plain_number(std::string_view text) {
  std::int64_t whole = 0;
  const char* const end = text.data() + text.size();
  auto parsed = std::from_chars(text.data(), end, whole);
  if (parsed.ec == std::errc() && parsed.ptr == end) return fmt::format("{}", whole) == text;
  double number = 0;
  parsed = std::from_chars(text.data(), end, number);
  const bool is_decimal = text.find_first_not_of("-0123456789.") == std::string_view::npos;
  return parsed.ec == std::errc() && parsed.ptr == end && is_decimal && fmt::format("{}", number) == text;
}

/// The text without anything that would end a string or a comment of TOML.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else if (code < 0x20 || code == 0x7F) {
      result += fmt::format("\\u{:04X}", code);
    } else {
      result += c;
    }
  }
  return result;
}

std::string toml_of(const std::string& value) {
  return is_plain_number(value) ? value : fmt::format("\"{}\"", escaped(value));
}

std::string toml_of(const std::vector<std::string>& values, bool is_array) {
  if (!is_array) return toml_of(values.front());
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : ", ") + toml_of(value);
  return fmt::format("[{}]", text);
}

}  // namespace

std::string Configuration::describe(const Setting& setting) const {
  const CLI::Option& option = *setting.option;
  const std::string name = option.get_lnames().front();
  const bool is_switch = option.get_items_expected_max() == 0;
  std::vector<std::string> values = setting.values;
  if (values.empty() && is_switch) values = {"false"};
  if (values.empty() && !option.get_default_str().empty()) values = {option.get_default_str()};

  constexpr const char* kSources[] = {"the default", "the file, ", "the environment, ", "the command line, "};
  const auto source = static_cast<std::size_t>(setting.source);
  std::string text = fmt::format("\n# {}\n# ", option.get_description());
  if (!is_switch) text += type_of(option) + "; ";
  if (values.empty()) return text + fmt::format("not set\n# {} = \"\"\n", name);
  text += fmt::format("from {}{}\n", kSources[source], escaped(setting.place));
  const bool is_array = option.get_items_expected_max() > 1;
  return text + fmt::format("{} = {}\n", name, is_switch ? values.front() : toml_of(values, is_array));
}

std::string Configuration::to_toml() const {
  std::string text = "# The settings of segserve, as `segserve --print-config` writes them.\n";
  for (const CLI::Option* option : std::as_const(app_).get_options()) {
    if (!option->get_configurable()) continue;
    const auto found = settings_.find(option->get_lnames().front());
    text += describe(found == settings_.end() ? Setting{option, Source::kDefault, {}, {}} : found->second);
  }
  return text;
}

}  // namespace segserve::server
