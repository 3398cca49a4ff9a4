// SPDX-License-Identifier: Apache-2.0
#include "server/config/config_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "fmt/format.h"

#define TOML_EXCEPTIONS 0
#include "toml++/toml.h"

namespace segserve::server {
namespace {

// After so many lines that are no TOML the file is something else.
constexpr int kMostSyntaxFaults = 20;
constexpr std::size_t kMostBytes = std::size_t{1} << 20U;

/// Replaces a line by nothing, so that the lines after it keep their numbers.
void blank_line(std::string& text, std::size_t line) {
  std::size_t begin = 0;
  for (std::size_t i = 1; i < line && begin != std::string::npos; ++i) {
    begin = text.find('\n', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (begin == std::string::npos || begin >= text.size()) return;
  text.erase(begin, std::min(text.find('\n', begin), text.size()) - begin);
}

std::optional<std::string> text_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  return std::nullopt;
}

/// The parser stops at the first fault. Without that line it finds the next one.
toml::table parse(std::string& text, std::vector<FileFault>& faults) {
  for (int i = 0; i < kMostSyntaxFaults; ++i) {
    toml::parse_result parsed = toml::parse(text);
    if (parsed) return std::move(parsed).table();
    const std::size_t line = parsed.error().source().begin.line;
    faults.push_back({line, std::string(parsed.error().description())});
    const std::string before = text;
    blank_line(text, line);
    if (text == before) break;  // the fault is that something is missing at the end
  }
  return {};
}

/// The texts of a value; nothing if no option has such a value.
std::optional<std::vector<std::string>> texts_of(const toml::node& node) {
  if (const auto* boolean = node.as_boolean()) return {{boolean->get() ? "true" : "false"}};
  const auto* array = node.as_array();
  if (array == nullptr) {
    const auto text = text_of(node);
    return text ? std::optional(std::vector{*text}) : std::nullopt;
  }
  std::vector<std::string> texts;
  for (const toml::node& element : *array) {
    const auto text = text_of(element);
    if (!text) return std::nullopt;
    texts.push_back(*text);
  }
  return texts;
}

}  // namespace

ConfigFile parse_config(std::string text) {
  ConfigFile file;
  for (auto&& [key, node] : parse(text, file.faults)) {
    const std::string name(key.str());
    const std::size_t line = node.source().begin.line;
    if (node.is_table() || node.is_array_of_tables()) {
      file.faults.push_back(
          {line, fmt::format("'{}' is a table, but all settings stand at the top, without tables", name)});
    } else if (auto texts = texts_of(node)) {
      file.entries.push_back({name, *std::move(texts), node.is_boolean(), line});
    } else {
      file.faults.push_back({line, fmt::format("{}: no setting has a value of this kind", name)});
    }
  }
  return file;
}

ConfigFile read_config_file(const std::string& path) {
  const auto fault = [](std::string_view what) {
    return ConfigFile{.entries = {}, .faults = {{0, std::string(what)}}};
  };
  const std::unique_ptr<std::FILE, decltype(&std::fclose)> file(std::fopen(path.c_str(), "rbe"), std::fclose);
  if (!file) return fault(fmt::format("the file cannot be read: {}", std::strerror(errno)));
  std::string text(kMostBytes + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) return fault(fmt::format("the file cannot be read: {}", std::strerror(errno)));
  if (text.size() > kMostBytes) return fault("the file has more than 1 MiB");
  return parse_config(std::move(text));
}

}  // namespace segserve::server
