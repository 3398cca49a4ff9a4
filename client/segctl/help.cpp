// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/help.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr std::size_t kNameColumns = 30;
constexpr std::size_t kTextColumns = 80;

/// The text in lines of at most `columns` characters, broken at spaces.
std::string wrapped(const std::string& text, std::size_t columns) {
  std::string out;
  std::size_t used = 0;
  for (const std::string& word : CLI::detail::split(text, ' ')) {
    const bool fits = used == 0 || used + 1 + word.size() <= columns;
    if (used > 0) out += fits ? ' ' : '\n';
    used = fits && used > 0 ? used + 1 + word.size() : word.size();
    out += word;
  }
  return out;
}

std::string indented(const std::string& lines) { return "  " + CLI::detail::find_and_replace(lines, "\n", "\n  "); }

/// --help shows the common options of a command, --help-all every option.
class CommandHelp : public CLI::Formatter {
 public:
  explicit CommandHelp(HelpText text) : text_(std::move(text)) { column_width(kNameColumns); }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::Sub) return make_expanded(app);
    std::string out = make_description(app) + make_usage(app, name) + make_positionals(app);
    for (const std::string& group : app->get_groups()) out += options_of_group(*app, group, mode);
    out += commands_of(*app);
    out += fmt::format("\nExamples:\n{}\n", indented(text_.examples));
    if (mode == CLI::AppFormatMode::All && !text_.details.empty()) out += fmt::format("\n{}\n", text_.details);
    out += fmt::format("\nExit codes: {}\n", text_.exit_codes);
    if (mode != CLI::AppFormatMode::All) {
      out += fmt::format("\"{} --help-all\" lists all {} options.\n", name, options(*app).size());
    }
    return out;
  }

  /// Like the base class, but without "Needs" and "Excludes", which are longer than what they explain.
  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0) return "";
    std::string text = " " + option->get_type_name();
    if (!option->get_default_str().empty()) text += "=" + option->get_default_str();
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size) text += " ...";
    if (option->get_required()) text += " REQUIRED";
    return text;
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(Formatter::make_option_desc(option), kTextColumns);
  }

 private:
  /// Every option of the command but its flags for help.
  static std::vector<const CLI::Option*> options(const CLI::App& app) {
    return app.get_options([&app](const CLI::Option* option) {
      return option->nonpositional() && option != app.get_help_ptr() && option != app.get_help_all_ptr();
    });
  }

  bool is_common(const CLI::Option* option) const {
    return std::ranges::any_of(text_.common, [&](const std::string& name) { return option->check_name(name); });
  }

  std::string options_of_group(const CLI::App& app, const std::string& group, CLI::AppFormatMode mode) const {
    std::vector<const CLI::Option*> members = options(app);
    std::erase_if(members, [&](const CLI::Option* option) {
      return option->get_group() != group || (mode != CLI::AppFormatMode::All && !is_common(option));
    });
    return members.empty() ? "" : make_group(group, false, members);
  }

  static std::string commands_of(const CLI::App& app) {
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    std::string text = commands.empty() ? "" : "\nCommands, instead of options:\n";
    for (const CLI::App* command : commands) {
      text += fmt::format("  {:<{}}{}\n", command->get_name(), kNameColumns - 2, command->get_description());
    }
    return text;
  }

  HelpText text_;
};

}  // namespace

void set_help(CLI::App& command, HelpText text) {
  command.set_help_flag("-h,--help", "Show the options that most people need");
  command.set_help_all_flag("--help-all", "Show every option");
  command.formatter(std::make_shared<CommandHelp>(std::move(text)));
}

}  // namespace segserve::segctl
