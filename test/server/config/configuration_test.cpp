// SPDX-License-Identifier: Apache-2.0
#include "server/config/configuration.hpp"

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "test/temporary_path.hpp"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A program with a few options of each kind.
struct Program {
  std::string address = "here";
  std::uint32_t queue = 7;
  double seconds = 0.5;
  std::vector<std::string> names;
  std::string file;
  bool fast = false;
  CLI::App app{"A program.", "program"};
  Configuration configuration{app};

  Program() {
    app.add_option("--address", address, "Where")->capture_default_str();
    app.add_option("--queue-size", queue, "How long")->check(CLI::Range(1, 100))->capture_default_str();
    app.add_option("--seconds", seconds, "When")->capture_default_str();
    app.add_option("--names", names, "Who");
    app.add_option("--file", file, "What to read")->type_name("FILE");
    app.add_flag("--fast", fast, "Hurry");
  }

  void run(std::vector<const char*> arguments, const Environment& environment = {}) {
    arguments.insert(arguments.begin(), "program");
    const int count = static_cast<int>(arguments.size());
    configuration.read(count, arguments.data(), environment);
    app.parse(count, arguments.data());
  }
};

std::string write_file(const std::string& text) {
  const std::string path = test::temporary_path("configuration.toml");
  std::ofstream(path) << text;
  return path;
}

TEST(Configuration, HasVariablesNamedByRule) { EXPECT_EQ(variable_of("queue-size"), "SEGSERVE_QUEUE_SIZE"); }

TEST(Configuration, PrefersTheCommandLineToTheEnvironmentAndThatToTheFile) {
  const std::string path = write_file("queue-size = 1\nseconds = 1\naddress = \"file\"\nfast = true\n");
  Program program;
  program.run(
      {"--queue-size", "3"},
      {{"SEGSERVE_QUEUE_SIZE", "2"}, {"SEGSERVE_SECONDS", "2.5"}, {"SEGSERVE_FAST", "off"}, {"SEGSERVE_CONFIG", path}});
  EXPECT_THAT(program.configuration.faults(), IsEmpty());
  EXPECT_EQ(program.queue, 3U);
  EXPECT_EQ(program.seconds, 2.5);
  EXPECT_EQ(program.address, "file");
  EXPECT_FALSE(program.fast);
  EXPECT_EQ(program.configuration.place_of("queue-size"), "--queue-size");
  EXPECT_EQ(program.configuration.place_of("seconds"), "SEGSERVE_SECONDS");
  EXPECT_EQ(program.configuration.place_of("address"), path + ":3: address");
  EXPECT_EQ(program.configuration.place_of("names"), "--names");
}

TEST(Configuration, ASwitchOnTheCommandLineMayHaveAValue) {
  Program off, on;
  off.run({"--fast=0"}, {{"SEGSERVE_FAST", "true"}});
  EXPECT_FALSE(off.fast);
  EXPECT_THAT(off.configuration.to_toml(), HasSubstr("fast = false\n"));
  on.run({"--fast=on"});
  EXPECT_TRUE(on.fast);
  EXPECT_THAT(on.configuration.to_toml(), HasSubstr("fast = true\n"));
}

TEST(Configuration, TakesListsFromEverywhere) {
  Program flags, variables, file;
  flags.run({"--names", "a", "--names", "b"});
  variables.run({}, {{"SEGSERVE_NAMES", "a,b"}});
  const std::string path = write_file("names = [\"a\", \"b\"]\n");
  file.run({"--config", path.c_str()});
  for (const Program* program : {&flags, &variables, &file}) {
    EXPECT_THAT(program->names, ElementsAre("a", "b"));
    EXPECT_THAT(program->configuration.to_toml(), HasSubstr("names = [\"a\", \"b\"]\n"));
  }
}

TEST(Configuration, TellsEveryFaultWithItsPlace) {
  const std::string path =
      write_file("queue-size = 0\nseconds = true\naddress = [\"a\", \"b\"]\nadress = \"a\"\nfast = \"yes\"\n");
  Program program;
  program.run({"--config", path.c_str()}, {{"SEGSERVE_FAST", "perhaps"}, {"SEGSERVE_FILE", "x"}});
  EXPECT_THAT(
      program.configuration.faults(),
      ElementsAre("SEGSERVE_FAST: 'perhaps' is neither true nor false", HasSubstr(":1: queue-size: 0 is not in range"),
                  HasSubstr("2: seconds: the value is of the type number"),
                  HasSubstr(":3: address: 2 values are given, but it takes one"),
                  HasSubstr(":4: there is no setting 'adress' (did you mean address?)"),
                  HasSubstr(":5: fast: the value must be true or false")));
  EXPECT_THAT(program.configuration.missing_files(), ElementsAre("SEGSERVE_FILE: there is no file x"));
}

TEST(Configuration, WarnsOfVariablesThatSetNothing) {
  Program program;
  program.run({}, {{"SEGSERVE_QUEU_SIZE", "2"},
                   {"SEGSERVE_PORT", "tcp://10.0.0.1:50051"},
                   {"SEGSERVE_SERVICE_HOST", "10.0.0.1"},
                   {"SEGSERVE_PORT_50051_TCP_ADDR", "10.0.0.1"},
                   {"SEGCTL_SERVER", "a"},
                   {"SEGSERVE_ADDRESS", ""}});
  EXPECT_THAT(program.configuration.warnings(),
              ElementsAre("the variable SEGSERVE_QUEU_SIZE sets nothing (did you mean SEGSERVE_QUEUE_SIZE?)"));
  EXPECT_EQ(program.address, "here");
}

TEST(Configuration, PrintsWhatReadsBackAsTheSame) {
  Program program;
  program.run({"--address", "a \"quoted\"\\ \n word", "--queue-size=12", "--fast", "--names", "007"});
  const std::string text = program.configuration.to_toml();
  const std::string path = write_file(text);
  Program again;
  again.run({"--config", path.c_str()});
  EXPECT_THAT(again.configuration.faults(), IsEmpty());
  EXPECT_EQ(again.address, program.address);
  EXPECT_EQ(again.queue, 12U);
  EXPECT_TRUE(again.fast);
  EXPECT_THAT(again.names, ElementsAre("007"));
  EXPECT_THAT(text, HasSubstr("# whole number; from the command line, --queue-size\nqueue-size = 12\n"));
  EXPECT_THAT(text, HasSubstr("# number; from the default\nseconds = 0.5\n"));
  EXPECT_THAT(text, HasSubstr("# FILE; not set\n# file = \"\"\n"));
  EXPECT_THAT(text, testing::Not(HasSubstr("config =")));
}

}  // namespace
}  // namespace segserve::server
