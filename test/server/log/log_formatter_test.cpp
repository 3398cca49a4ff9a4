// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_formatter.hpp"

#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/log/log_event.hpp"
#include "server/log/log_payload.hpp"

namespace segserve::server {
namespace {

using Fields = std::vector<LogField>;
using testing::MatchesRegex;
using testing::Not;

std::string line_of(LogFormat format, const spdlog::details::log_msg& message) {
  spdlog::memory_buf_t line;
  LogFormatter(format).format(message, line);
  return {line.data(), line.size()};
}

std::string line_with_fields(LogFormat format, std::string_view message, const Fields& fields) {
  const std::string payload = pack_payload(message, fields);
  return line_of(format, spdlog::details::log_msg(fields_mark(), "", spdlog::level::info, payload));
}

std::string plain_line(LogFormat format, const std::string& message) {
  return line_of(format, spdlog::details::log_msg("", spdlog::level::warn, message));
}

constexpr const char* kTime = "[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}\\.[0-9]{3}[+-][0-9]{2}:[0-9]{2}";

/// Everything that has ever broken a log: ends of lines, control characters, terminals' escapes, quotes, no UTF-8, and
/// our own separators.
std::vector<std::string> hostile_texts() {
  std::vector<std::string> texts = {"a\nb",
                                    "a\r\nb",
                                    "\x1b[31mred",
                                    "\"",
                                    "\\",
                                    "'",
                                    "\\\"}",
                                    "=",
                                    "a=b c=d",
                                    "\xff\xfe",
                                    "\xc3(",
                                    "\xed\xa0\x80",
                                    "\xf4\x90\x80\x80",
                                    "\xc2\x9b",
                                    "\x1ename\x1fn1",
                                    "\x1e",
                                    "\x1f",
                                    "\u2028",
                                    "{\"level\":\"info\"}"};
  texts.emplace_back("nul\0nul", 7);
  texts.emplace_back(100'000, 'x');
  texts.emplace_back(100'000, '\xff');
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  texts.push_back(all);
  return texts;
}

TEST(LogFormatter, WritesJsonOfAsciiAlone) {
  for (const std::string& text : hostile_texts()) {
    const Fields fields = {{"name", text}};
    for (const char byte : line_with_fields(LogFormat::kJson, text, fields)) {
      ASSERT_TRUE(byte == '\n' || (byte >= ' ' && byte <= '~')) << text;
    }
  }
}

TEST(LogFormatter, WritesTextWithFields) {
  const Fields fields = {{"text", "plain"},
                         {"quoted", "two words"},
                         {"empty", ""},
                         {"count", 7U},
                         {"offset", -1},
                         {"queue_ms", 1.5},
                         {"infinite", std::numeric_limits<double>::infinity()}};
  EXPECT_THAT(line_with_fields(LogFormat::kText, "a message", fields),
              MatchesRegex(std::string(kTime) +
                           " info a message text=plain quoted=\"two words\" count=7 offset=-1 queue_ms=1\\.500\n"));
}

TEST(LogFormatter, WritesOneObjectALineAsJson) {
  const Fields fields = {{"text", "two \"words\""}, {"empty", ""}, {"count", 7U}, {"offset", -1}, {"queue_ms", 1.5}};
  const std::string line = line_with_fields(LogFormat::kJson, "a message", fields);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const auto json = nlohmann::json::parse(line);
  EXPECT_THAT(json.at("time").get<std::string>(), MatchesRegex(kTime));
  nlohmann::json expected = {{"level", "info"}, {"message", "a message"}, {"text", "two \"words\""}, {"count", 7},
                             {"offset", -1},    {"queue_ms", 1.5},        {"time", json.at("time")}};
  EXPECT_EQ(json, expected);
}

TEST(LogFormatter, NamesLevels) {
  EXPECT_EQ(nlohmann::json::parse(plain_line(LogFormat::kJson, "x")).at("level"), "warning");
}

TEST(LogFormatter, KeepsHostileTextsInTheirPlace) {
  for (const std::string& text : hostile_texts()) {
    for (const std::string& line :
         {line_with_fields(LogFormat::kJson, text, {{"id", text}, {"count", 1}}), plain_line(LogFormat::kJson, text)}) {
      EXPECT_EQ(line.find('\n'), line.size() - 1);
      const auto json = nlohmann::json::parse(line, nullptr, false);
      ASSERT_FALSE(json.is_discarded()) << line.substr(0, 300);
      EXPECT_TRUE(json.at("message").is_string());
      EXPECT_LE(json.size(), 5U);
    }
    for (const std::string& line :
         {line_with_fields(LogFormat::kText, text, {{"id", text}, {"count", 1}}), plain_line(LogFormat::kText, text)}) {
      EXPECT_THAT(line.substr(0, line.size() - 1), MatchesRegex("[ -~]*")) << text.substr(0, 100);
      EXPECT_EQ(line.back(), '\n');
    }
  }
}

TEST(LogFormatter, KeepsWhatJsonCanHold) {
  const std::string text = "a\nb\t\"q\" \xc3\xbc";
  EXPECT_EQ(nlohmann::json::parse(line_with_fields(LogFormat::kJson, "m", {{"id", text}})).at("id"), text);
}

TEST(LogFormatter, EscapesValuesSoThatTheyCannotBeTakenForOtherFields) {
  const std::string line = line_with_fields(LogFormat::kText, "m", {{"id", "x\" subject=\"admin\n"}});
  EXPECT_TRUE(line.ends_with(" m id=\"x\\\" subject=\\\"admin\\x0a\"\n")) << line;
}

TEST(LogFormatter, TakesNoTextForFields) {
  const auto json = nlohmann::json::parse(plain_line(LogFormat::kJson,
                                                     "from a library\x1esubject\x1ft"
                                                     "admin"));
  EXPECT_FALSE(json.contains("subject"));
}

TEST(LogFormatter, CutsLongTexts) {
  const std::string text(1'000'000, 'x');
  EXPECT_LT(line_with_fields(LogFormat::kText, "m", {{"id", text}}).size(), kMostFieldBytes + 100);
  EXPECT_LT(plain_line(LogFormat::kJson, text).size(), LogFormatter::kMostMessageBytes + 200);
  EXPECT_THAT(line_with_fields(LogFormat::kText, "m", {{"id", text}}), testing::EndsWith("x...\n"));
}

}  // namespace
}  // namespace segserve::server
