// SPDX-License-Identifier: Apache-2.0
#include "command_line/usage_faults.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "command_line/not_negative.hpp"
#include "gtest/gtest.h"

namespace segserve {
namespace {

/// A program with two commands.
class Program {
 public:
  Program() {
    app_.require_subcommand(1);
    CLI::App* paint = app_.add_subcommand("paint", "");
    paint->add_option("FILE", file_)->required();
    CLI::Option* width = paint->add_option("--width", width_)->type_name("NUMBER");
    paint->add_option("--title", title_);
    paint->add_option("--count", count_)->check(not_negative());
    paint->add_option("--brush", brush_)->check(CLI::Range(1, 8))->needs(width);
    paint->add_flag("--dry", dry_)->excludes(width);
    app_.add_subcommand("print", "")->add_option("--copies", copies_);
  }

  /// Tells what is wrong with these arguments; empty if nothing is.
  std::string faults(std::vector<std::string> arguments) {
    try {
      app_.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::ParseError& error) {
      return usage_faults(app_, error);
    }
    return "";
  }

  /// Tells which values of these arguments are empty.
  std::string empty(std::vector<std::string> arguments, std::initializer_list<std::string_view> except = {}) {
    app_.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    return empty_values(app_, except);
  }

 private:
  CLI::App app_{"", "art"};
  std::string file_, title_;
  std::optional<double> width_;
  std::uint32_t count_ = 0;
  int brush_ = 1, copies_ = 1;
  bool dry_ = false;
};

std::string faults(const std::vector<std::string>& arguments) { return Program().faults(arguments); }

TEST(UsageFaults, TellEverythingAtOnce) {
  EXPECT_EQ(faults({"paint", "a", "--width", "1"}), "");
  EXPECT_EQ(faults({"paint", "a", "--wdth", "3", "--width", "wide", "--count", "1.5", "--brush", "9", "--zzzzzz"}),
            "unknown option --wdth (did you mean --width?); unknown option --zzzzzz; --width: 'wide' is no number; "
            "--count: '1.5' is no whole number; --brush: 9 is not in range 1 to 8 (see art paint --help)");
}

TEST(UsageFaults, TellUnknownCommands) {
  EXPECT_EQ(faults({"pain", "a", "--width", "x"}),
            "there is no command 'pain' (did you mean art paint?) (see art --help)");
  EXPECT_EQ(faults({"dance"}), "there is no command 'dance'; a command is needed: paint, print (see art --help)");
  EXPECT_EQ(faults({"help"}), "there is no command 'help' (did you mean art --help?) (see art --help)");
  EXPECT_EQ(faults({}), "a command is needed: paint, print (see art --help)");
  EXPECT_EQ(faults({"--zzzzzz", "3"}), "a command is needed: paint, print; unknown option --zzzzzz (see art --help)");
}

TEST(UsageFaults, TellWhereAnOptionBelongs) {
  EXPECT_EQ(faults({"--width", "3", "paint", "a"}),
            "--width must stand behind the command, as in art paint --width (see art paint --help)");
  EXPECT_EQ(faults({"paint", "a", "--copies", "3"}),
            "unknown option --copies (art print has it) (see art paint --help)");
  EXPECT_EQ(faults({"print", "a"}), "'a' is not expected (see art print --help)");
}

TEST(UsageFaults, TellWhatIsMissingAndWhatDoesNotFit) {
  EXPECT_EQ(faults({"paint", "--width"}), "--width needs NUMBER after it (see art paint --help)");
  EXPECT_EQ(faults({"paint", "--brush", "2"}), "FILE is required; --brush needs --width (see art paint --help)");
  EXPECT_EQ(faults({"paint", "a", "--dry", "--width", "2"}), "--width does not go with --dry (see art paint --help)");
  EXPECT_EQ(faults({"paint", "a", "--width", "2", "--width", "3"}),
            "--width is given more than once (see art paint --help)");
  EXPECT_EQ(faults({"paint", "a", "--count", "99999999999999999999"}),
            "--count: 99999999999999999999 is too large (see art paint --help)");
  EXPECT_EQ(faults({"paint", "a", "--count", "-1"}),
            "--count: -1 is negative, but must be a whole number of at least 0 (see art paint --help)");
}

TEST(EmptyValues, AreToldByTheirOptions) {
  EXPECT_EQ(Program().empty({"paint", "a", "--title", "", "--width", "2"}), "--title is empty");
  EXPECT_EQ(Program().empty({"paint", "", "--title", ""}), "FILE is empty; --title is empty");
  EXPECT_EQ(Program().empty({"paint", "a", "--dry"}), "") << "a flag has no value";
  EXPECT_EQ(Program().empty({"paint", "a", "--title", " "}), "");
  EXPECT_EQ(Program().empty({"paint", "", "--title", ""}, {"--title"}), "FILE is empty");
}

}  // namespace
}  // namespace segserve
