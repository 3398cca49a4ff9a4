// SPDX-License-Identifier: Apache-2.0
#include "server/config/config_file.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include "gmock/gmock.h"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

TEST(ConfigFile, ReadsValuesOfEachType) {
  const ConfigFile file = parse_config(
      "# a comment\nqueue = 4\nlisten = \"a:1\"\ngrace-period = 0.25\nreflection = true\n"
      "names = [\"a\", 2]\n");
  EXPECT_THAT(file.faults, IsEmpty());
  ASSERT_EQ(file.entries.size(), 5U);
  EXPECT_EQ(file.entries[0].name, "grace-period");
  EXPECT_THAT(file.entries[0].values, ElementsAre("0.25"));
  EXPECT_EQ(file.entries[0].line, 4U);
  EXPECT_THAT(file.entries[1].values, ElementsAre("a:1"));
  EXPECT_THAT(file.entries[2].values, ElementsAre("a", "2"));
  EXPECT_THAT(file.entries[3].values, ElementsAre("4"));
  EXPECT_FALSE(file.entries[3].is_boolean);
  EXPECT_THAT(file.entries[4].values, ElementsAre("true"));
  EXPECT_TRUE(file.entries[4].is_boolean);
}

std::vector<std::size_t> lines(const ConfigFile& file) {
  std::vector<std::size_t> lines;
  for (const FileFault& fault : file.faults) lines.push_back(fault.line);
  return lines;
}

TEST(ConfigFile, TellsEveryFaultyLine) {
  const ConfigFile file = parse_config("[server]\nworkers = \nqueue = 3\nqueue = 4\nname = \"open\nday = 2026-11-29\n");
  EXPECT_THAT(lines(file), UnorderedElementsAre(1, 2, 4, 5));
  EXPECT_THAT(file.entries, IsEmpty());
}

TEST(ConfigFile, TellsWhichValuesNoSettingHas) {
  const ConfigFile file = parse_config("b.c = 1\na = 2026-11-29\nd = [[1]]\n[[e]]\n");
  EXPECT_THAT(file.entries, IsEmpty());
  EXPECT_THAT(lines(file), UnorderedElementsAre(1, 2, 3, 4));
}

TEST(ConfigFile, EndsWithWhatIsNoToml) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "<xml/>\n";
  EXPECT_THAT(parse_config(text).faults.size(), 20U);
  EXPECT_FALSE(parse_config(std::string(100, '\0')).faults.empty());
  EXPECT_FALSE(parse_config("a = \"\"\"\nopen").faults.empty());
}

TEST(ConfigFile, TellsThatThereIsNone) {
  EXPECT_THAT(read_config_file("/nowhere/f").faults.at(0).what, HasSubstr("cannot be read: No such file"));
  EXPECT_THAT(read_config_file("/").faults.at(0).what, HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace segserve::server
