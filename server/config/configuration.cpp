// SPDX-License-Identifier: Apache-2.0
#include "server/config/configuration.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "command_line/closest_name.hpp"
#include "command_line/usage_faults.hpp"
#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr const char* kConfig = "config";

/// The name of an option without dashes.
std::string name_of(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

bool is_switch(const CLI::Option& option) { return option.get_items_expected_max() == 0; }

/// "on" is true; nothing if the text is neither true nor false.
std::optional<bool> to_boolean(const std::string& text) {
  const std::string lower = CLI::detail::to_lower(text);
  if (lower == "true" || lower == "1" || lower == "on" || lower == "yes") return true;
  if (lower == "false" || lower == "0" || lower == "off" || lower == "no") return false;
  return std::nullopt;
}

std::vector<std::string> split_values(const CLI::Option& option, const std::string& text) {
  if (option.get_items_expected_max() <= 1) return {text};
  return CLI::detail::split(text, option.get_delimiter() == '\0' ? ',' : option.get_delimiter());
}

/// Says what keeps the server from reading a file; empty if nothing does.
std::string why_not_readable(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return fmt::format("{} is a folder", path);
  if (!std::filesystem::exists(path, error)) return fmt::format("there is no file {}", path);
  // Opening a pipe would wait for whoever writes into it.
  if (!std::filesystem::is_regular_file(path, error)) return fmt::format("{} is no regular file", path);
  return std::ifstream(path) ? "" : fmt::format("the file {} cannot be read", path);
}

std::string why_not_writable(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? "" : fmt::format("there is no folder {}", folder.string());
}

}  // namespace

std::string type_of(const CLI::Option& option) {
  std::string type = option.get_type_name();
  type.erase(std::min(type.find(':'), type.size()));  // The names of checks come behind it.
  if (type == "INT" || type == "UINT") return "whole number";
  if (type == "FLOAT") return "number";
  return type == "TEXT" ? "text" : type;
}

Configuration::Configuration(CLI::App& app) : app_(app) {
  app.add_option(std::string("--") + kConfig, path_,
                 "Read settings from this TOML file; its keys are the names of flags")
      ->type_name("FILE")
      ->configurable(false);
}

std::vector<std::string> Configuration::names() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : std::as_const(app_).get_options()) {
    if (option->get_configurable()) names.push_back(name_of(*option));
  }
  return names;
}

void Configuration::read(int argc, const char* const* argv, const Environment& environment) {
  find_on_command_line(argc, argv);
  read_environment(environment);
  const auto path = settings_.find(kConfig);
  if (path != settings_.end()) read_file(path->second.values.front());
  settings_.erase(kConfig);
}

void Configuration::find_on_command_line(int argc, const char* const* argv) {
  const std::span<const char* const> arguments(argv, static_cast<std::size_t>(argc));
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string_view word(arguments[i]);
    if (word == "--") return;
    if (!word.starts_with("--")) continue;
    const std::size_t equals = word.find('=');
    const std::string name(word.substr(2, equals == std::string_view::npos ? equals : equals - 2));
    const CLI::Option* option = app_.get_option_no_throw("--" + name);
    if (option == nullptr) continue;
    std::string value = "true";
    if (equals != std::string_view::npos) {
      value = word.substr(equals + 1);
    } else if (!is_switch(*option)) {
      if (++i == arguments.size()) return;
      value = arguments[i];
    }
    // CLI11 tells if the value of a switch is neither.
    if (is_switch(*option) && to_boolean(value)) value = *to_boolean(value) ? "true" : "false";
    Setting& setting = settings_[name_of(*option)];
    setting.option = option;
    setting.source = Source::kCommandLine;
    setting.place = "--" + name;
    for (std::string& each : split_values(*option, value)) setting.values.push_back(std::move(each));
  }
}

void Configuration::read_environment(const Environment& environment) {
  std::vector<std::string> known = names();
  known.emplace_back(kConfig);
  for (const std::string& name : known) {
    const std::string variable = variable_of(name);
    const auto found = environment.find(variable);
    const bool is_set = found != environment.end() && !found->second.empty();
    if (!is_set || settings_.contains(name)) continue;
    CLI::Option& option = *app_.get_option_no_throw("--" + name);
    const std::string fault =
        take(option, {&option, Source::kEnvironment, variable, split_values(option, found->second)});
    if (!fault.empty()) faults_.push_back(fmt::format("{}: {}", variable, fault));
  }
  warnings_ = unknown_variables(environment, known);
}

void Configuration::read_file(const std::string& path) {
  ConfigFile file = read_config_file(path);
  for (FileEntry& entry : file.entries) read_entry(std::move(entry), path, file.faults);
  std::ranges::stable_sort(file.faults, {}, &FileFault::line);
  for (const FileFault& fault : file.faults) {
    const std::string line = fault.line > 0 ? fmt::format(":{}", fault.line) : "";
    faults_.push_back(fmt::format("{}{}: {}", path, line, fault.what));
  }
}

void Configuration::read_entry(FileEntry entry, const std::string& path, std::vector<FileFault>& faults) {
  const std::vector<std::string> known = names();
  if (std::ranges::find(known, entry.name) == known.end()) {
    const std::optional<std::string> meant = closest_name(entry.name, known);
    const std::string hint = meant ? fmt::format(" (did you mean {}?)", *meant) : "";
    return faults.push_back({entry.line, fmt::format("there is no setting '{}'{}", entry.name, hint)});
  }
  CLI::Option& option = *app_.get_option_no_throw("--" + entry.name);
  std::string fault;
  if (is_switch(option) != entry.is_boolean) {
    fault = is_switch(option) ? "the value must be true or false, without quotes"
                              : fmt::format("the value is of the type {}, not true or false", type_of(option));
  } else if (!settings_.contains(entry.name) && entry.values != std::vector<std::string>{""}) {
    const std::string place = fmt::format("{}:{}: {}", path, entry.line, entry.name);
    fault = take(option, {&option, Source::kFile, place, std::move(entry.values)});
  }
  if (!fault.empty()) faults.push_back({entry.line, fmt::format("{}: {}", entry.name, fault)});
}

std::string Configuration::take(CLI::Option& option, Setting setting) {
  Setting& taken = settings_[name_of(option)] = std::move(setting);
  std::vector<std::string>& values = taken.values;
  if (is_switch(option)) {
    const std::optional<bool> value = to_boolean(values.front());
    if (!value) return fmt::format("'{}' is neither true nor false", values.front());
    values = {*value ? "true" : "false"};
    if (!*value) return "";
  } else if (values.empty() || static_cast<int>(values.size()) > option.get_items_expected_max()) {
    return fmt::format("{} values are given, but it takes one", values.size());
  }
  option.add_result(values);
  try {
    option.run_callback();
  } catch (const CLI::ParseError& error) {
    std::string fault = fault_of_values(option, error);
    option.clear();
    return fault;
  }
  return "";
}

std::string Configuration::place_of(std::string_view option) const {
  const auto found = settings_.find(std::string(option));
  return found == settings_.end() ? fmt::format("--{}", option) : found->second.place;
}

std::vector<std::string> Configuration::missing_files() const {
  std::vector<std::string> faults;
  for (const auto& [name, setting] : settings_) {
    const std::string type = type_of(*setting.option);
    for (const std::string& path : setting.values) {
      const std::string fault = type == "FILE" ? why_not_readable(path) : type == "PATH" ? why_not_writable(path) : "";
      if (!fault.empty()) faults.push_back(fmt::format("{}: {}", setting.place, fault));
    }
  }
  return faults;
}

}  // namespace segserve::server
