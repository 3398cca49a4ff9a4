// SPDX-License-Identifier: Apache-2.0
#include "core/base/strict_json.hpp"

#include <string>

#include "core/base/status_text.hpp"
#include "gmock/gmock.h"

namespace segserve {
namespace {

using Json = nlohmann::ordered_json;

std::string fault(std::string_view text) { return std::string(message_of(parse_strict_json<Json>(text).status())); }

TEST(StrictJson, ReadsWhatHasEachMemberOnce) {
  const std::string text = R"({"a":{"a":1,"b":[{"a":2},{"a":3}]},"b":null})";
  EXPECT_EQ(parse_strict_json<Json>(text)->dump(), text);
}

TEST(StrictJson, TellsWhichMemberIsThereTwice) {
  EXPECT_EQ(fault(R"({"a":1,"a":1})"), R"(it has an object with the member "a" twice)");
  EXPECT_EQ(fault(R"([{"x":[{"file":1,"time":2,"file":3}]}])"), R"(it has an object with the member "file" twice)");
  EXPECT_EQ(fault(R"({"a\n":1,"b":{},"\u0061\n":1})"), R"(it has an object with the member "a\n" twice)")
      << "by whatever escapes, and in one line";
}

TEST(StrictJson, TellsWhereATextIsNoJson) {
  EXPECT_THAT(fault("{"), testing::StartsWith("it is no JSON: parse error at line 1, column 2"));
  EXPECT_THAT(fault(R"({"a":1,"a":})"), testing::StartsWith("it is no JSON: "));
}

TEST(StrictJson, HasABoundOfLevels) {
  EXPECT_TRUE(parse_strict_json<Json>("[[[]]]", 3).ok());
  EXPECT_EQ(message_of(parse_strict_json<Json>("[[[[{\"a\":1}]]]]", 3).status()), "it has more than 3 levels");
}

}  // namespace
}  // namespace segserve
