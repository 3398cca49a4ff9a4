// SPDX-License-Identifier: Apache-2.0
#include "command_line/usage_faults.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "command_line/closest_name.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

/// The names of all options, "--threshold".
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<CLI::App*> commands_of(CLI::App& app) {
  return app.get_subcommands([](CLI::App*) { return true; });
}

/// The command that was given, or the command of that command, and so on.
CLI::App& chosen_below(CLI::App& app) {
  CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  return *chosen;
}

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (const std::string& part : parts) text += fmt::format("{}{}", text.empty() ? "" : separator, part);
  return text;
}

/// "-x" and "--name", but neither "-" nor "-1".
bool is_option(std::string_view word) {
  return word.size() > 1 && word[0] == '-' && std::isdigit(static_cast<unsigned char>(word[1])) == 0 && word[1] != '.';
}

/// "info, warn" of "Check loud value in {info->2,warn->3} OR {2,3} FAILED", which CLI11 says of a transformed value.
std::optional<std::string> allowed_words(const std::string& text) {
  const std::size_t begin = text.find(" value in {"), end = text.find('}', begin);
  if (begin == std::string::npos || end == std::string::npos) return std::nullopt;
  const std::size_t first = text.find('{', begin) + 1;
  std::vector<std::string> words = CLI::detail::split(text.substr(first, end - first), ',');
  for (std::string& word : words) word.erase(std::min(word.find("->"), word.size()));
  return joined(words, ", ");
}

/// Puts into our words what CLI11 says of a value of this option on the command line.
std::string fault_of_flag(const CLI::Option& option, const CLI::ParseError& error) {
  const std::string name = option.get_name();
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) == nullptr) {
    return fmt::format("{}: {}", name, fault_of_values(option, error));
  }
  const bool too_many = static_cast<int>(option.count()) > option.get_items_expected_max();
  return too_many ? fmt::format("{} is given more than once", name)
                  : fmt::format("{} needs {} after it", name, option.get_type_name());
}

class UsageFaults {
 public:
  explicit UsageFaults(CLI::App& app) : app_(app), command_(chosen_below(app)) {}

  std::string tell(const CLI::ParseError& error) {
    find_unknown();
    find_wrong_values(error);
    find_wrong_combinations(error);
    if (faults_.empty()) add(error.what());
    return fmt::format("{} (see {} --help)", joined(faults_, "; "), path());
  }

 private:
  bool has_command() const { return &app_ != &command_; }

  /// For example "segctl bench show".
  std::string path() const {
    std::string names = command_.get_name();
    for (const CLI::App* command = command_.get_parent(); command != nullptr; command = command->get_parent()) {
      names.insert(0, command->get_name() + " ");
    }
    return names;
  }

  void add(std::string fault) {
    if (std::ranges::find(faults_, fault) == faults_.end()) faults_.push_back(std::move(fault));
  }

  void find_unknown() {
    std::vector<std::string> words = app_.remaining();
    const bool lacks_command = !has_command() && !commands_of(app_).empty();
    if (lacks_command) {
      const auto command = std::ranges::find_if_not(words, is_option);
      add(command == words.begin() && !words.empty() ? unknown_command(*command) : which_commands());
      words.erase(command, words.end());  // These would be the arguments of the command.
    }
    find_unknown(words);
    for (const CLI::App* command = &command_; command != &app_; command = command->get_parent()) {
      find_unknown(command->remaining());
    }
  }

  void find_unknown(const std::vector<std::string>& words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!is_option(words[i])) {
        add(fmt::format("'{}' is not expected", words[i]));
        continue;
      }
      const std::size_t equals = words[i].find('=');
      add(unknown_option(words[i].substr(0, equals)));
      if (equals == std::string::npos && i + 1 < words.size() && !is_option(words[i + 1])) ++i;  // its value
    }
  }

  std::string unknown_option(const std::string& name) const {
    if (has_command() && command_.get_option_no_throw(name) != nullptr) {
      return fmt::format("{} must stand behind the command, as in {} {}", name, path(), name);
    }
    if (const auto meant = closest_name(name, option_names(command_))) {
      return fmt::format("unknown option {} (did you mean {}?)", name, *meant);
    }
    for (const CLI::App* other : commands_of(app_)) {
      const bool has_it = other->get_option_no_throw(name) != nullptr;
      if (has_it) return fmt::format("unknown option {} ({} {} has it)", name, app_.get_name(), other->get_name());
    }
    return fmt::format("unknown option {}", name);
  }

  std::string which_commands() const {
    std::vector<std::string> names;
    for (const CLI::App* command : commands_of(app_)) names.push_back(command->get_name());
    return "a command is needed: " + joined(names, ", ");
  }

  std::string unknown_command(const std::string& word) const {
    std::vector<std::string> names;
    for (const CLI::App* command : commands_of(app_)) names.push_back(command->get_name());
    const std::string first = names.front();
    std::ranges::move(option_names(app_), std::back_inserter(names));  // "help" is --help
    std::error_code error;
    const auto meant =
        std::filesystem::exists(word, error) ? std::optional(first + " " + word) : closest_name(word, names);
    if (!meant) return fmt::format("there is no command '{}'; {}", word, which_commands());
    return fmt::format("there is no command '{}' (did you mean {} {}?)", word, app_.get_name(), *meant);
  }

  void find_wrong_values(const CLI::ParseError& error) {
    for (CLI::Option* option : command_.get_options([](const CLI::Option*) { return true; })) {
      const std::string what = error.what();
      const bool ended_parsing =
          dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && what.starts_with(option->get_name() + ":");
      if (ended_parsing) add(fault_of_flag(*option, error));
      if (ended_parsing || option->count() == 0) continue;
      try {
        option->run_callback();
      } catch (const CLI::ParseError& fault) {
        add(fault_of_flag(*option, fault));
      }
    }
  }

  /// Only if everything was parsed: what seems to be missing could have come later.
  void find_wrong_combinations(const CLI::ParseError& error) {
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) return;
    const std::vector<CLI::Option*> options = command_.get_options([](const CLI::Option*) { return true; });
    for (CLI::Option* option : options) {
      if (option->get_required() && option->count() == 0) add(option->get_name() + " is required");
      if (option->count() == 0) continue;
      for (const CLI::Option* needed : option->get_needs()) {
        if (needed->count() == 0) add(fmt::format("{} needs {}", option->get_name(), needed->get_name()));
      }
      for (CLI::Option* excluded : option->get_excludes()) {
        const bool is_first = std::ranges::find(options, option) < std::ranges::find(options, excluded);
        if (excluded->count() > 0 && is_first) {
          add(fmt::format("{} does not go with {}", option->get_name(), excluded->get_name()));
        }
      }
    }
  }

  CLI::App& app_;
  CLI::App& command_;
  std::vector<std::string> faults_;
};

}  // namespace

std::string fault_of_values(const CLI::Option& option, const CLI::ParseError& error) {
  const std::string name = option.get_name();
  const std::string type = option.get_type_name();
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr && option.get_items_expected_max() > 0) {
    const bool is_whole = type.starts_with("INT") || type.starts_with("UINT");
    const std::string value = joined(option.results(), " ");
    const bool has_digits_only =
        !value.empty() && std::ranges::all_of(value, [](unsigned char c) { return std::isdigit(c); });
    if (has_digits_only) return fmt::format("{} is too large", value);
    return fmt::format("'{}' is no {}number", value, is_whole ? "whole " : "");
  }
  std::string text = error.what();
  if (const std::optional<std::string> words = allowed_words(text)) {
    return fmt::format("'{}' is none of {}", joined(option.results(), " "), *words);
  }
  if (text.find(" unit not recognized") != std::string::npos) {
    return fmt::format("'{}' is no number of bytes, such as 4GiB", joined(option.results(), " "));
  }
  // "--workers: Value 0 not in range 1 to 8"
  if (text.starts_with(name + ": ")) text.erase(0, name.size() + 2);
  if (text.starts_with("Value ")) text.erase(0, 6);
  return CLI::detail::find_and_replace(std::move(text), " not in ", " is not in ");
}

std::string empty_values(const CLI::App& app, std::initializer_list<std::string_view> except) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  std::vector<std::string> faults;
  for (const CLI::Option* option : command->get_options()) {
    const bool is_empty = option->get_type_size() != 0 && option->count() > 0 &&
                          std::ranges::any_of(option->results(), &std::string::empty);
    const bool may_be_empty = std::ranges::find(except, option->get_name()) != except.end();
    if (is_empty && !may_be_empty) faults.push_back(fmt::format("{} is empty", option->get_name()));
  }
  return joined(faults, "; ");
}

std::string usage_faults(CLI::App& app, const CLI::ParseError& error) { return UsageFaults(app).tell(error); }

}  // namespace segserve
