// SPDX-License-Identifier: Apache-2.0
#include "server/log/frame_log.hpp"

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/log/log_formatter.hpp"
#include "spdlog/sinks/ostream_sink.h"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

/// The log goes into a text for the time of a test.
class FrameLogTest : public testing::Test {
 protected:
  FrameLogTest() : before_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
    sink->set_formatter(std::make_unique<LogFormatter>(LogFormat::kJson));
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("frame_log_test", std::move(sink)));
  }
  ~FrameLogTest() override { spdlog::set_default_logger(before_); }

  std::vector<nlohmann::json> lines() const {
    std::vector<nlohmann::json> lines;
    std::istringstream text(text_.str());
    for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
    return lines;
  }
  std::vector<std::string> messages() const {
    std::vector<std::string> messages;
    for (const auto& line : lines()) messages.push_back(line.at("message"));
    return messages;
  }

  static FrameRecord frame_of(v1::OutcomeKind outcome, const StatusFacts& status = {}) {
    FrameRecord frame;
    frame.caller = std::make_shared<Caller>(Caller{.peer = "me", .client_name = "robot"});
    frame.outcome = outcome;
    frame.status = status;
    return frame;
  }
  static FrameRecord refused_frame() {
    return frame_of(v1::OUTCOME_KIND_FAILED, {.code = absl::StatusCode::kResourceExhausted,
                                              .reason = wire::ErrorReason::kQueueFull,
                                              .limit = "max_queue",
                                              .message = "the queue is full"});
  }

  std::ostringstream text_;

 private:
  const std::shared_ptr<spdlog::logger> before_;
};

TEST_F(FrameLogTest, TellsTheFirstOfEachKindAtInfoAndCountsTheOthers) {
  {
    FrameLog log;
    for (int i = 0; i < 5; ++i) log.write(refused_frame(), {});
    log.write(frame_of(v1::OUTCOME_KIND_DROPPED), {});
    log.write(frame_of(v1::OUTCOME_KIND_EXPIRED), {});
    FrameRecord evicted = refused_frame();
    evicted.is_evicted = true;
    log.write(evicted, {});
  }
  EXPECT_THAT(messages(), ElementsAre("frame refused", "frame dropped", "frame expired", "frame evicted from the queue",
                                      "frame refused: 4 more in the last 10 s"));
  const nlohmann::json first = lines().front(), last = lines().back();
  EXPECT_EQ(first["level"], "info");
  EXPECT_EQ(first["error"], "the queue is full");
  EXPECT_EQ(first["client"], "robot");
  EXPECT_EQ(last["count"], 4);
  for (const nlohmann::json& line : {first, last}) {
    EXPECT_EQ(line["code"], "RESOURCE_EXHAUSTED");
    EXPECT_EQ(line["reason"], "QUEUE_FULL");
    EXPECT_EQ(line["limit"], "max_queue");
  }
}

TEST_F(FrameLogTest, KeepsQuietAboutWhatClientsWanted) {
  FrameLog log;
  log.write(frame_of(v1::OUTCOME_KIND_RESULT), {});
  log.write(frame_of(v1::OUTCOME_KIND_CANCELLED), {});
  log.write(StreamRecord{.caller = frame_of(v1::OUTCOME_KIND_RESULT).caller}, {});
  log.write(StreamRecord{.caller = frame_of(v1::OUTCOME_KIND_RESULT).caller,
                         .status = {.code = absl::StatusCode::kCancelled}},
            {});
  EXPECT_THAT(messages(), SizeIs(0));
}

TEST_F(FrameLogTest, WritesALineForEachAtDebug) {
  spdlog::set_level(spdlog::level::debug);
  FrameLog log;
  log.write(frame_of(v1::OUTCOME_KIND_RESULT), {});
  log.write(refused_frame(), {});
  log.write(refused_frame(), {});
  log.write(StreamRecord{.caller = frame_of(v1::OUTCOME_KIND_RESULT).caller, .is_opened = true, .frames = 3}, {});
  EXPECT_THAT(messages(), ElementsAre("frame", "frame refused", "frame refused", "stream"));
  EXPECT_EQ(lines()[0]["outcome"], "RESULT");
  EXPECT_EQ(lines()[2]["level"], "debug");
  EXPECT_EQ(lines()[3]["frames"], 3);
}

TEST_F(FrameLogTest, TellsStreamsThatFailFromThoseThatAreRefused) {
  FrameLog log;
  StreamRecord stream{.caller = refused_frame().caller, .status = {.code = absl::StatusCode::kUnavailable}};
  log.write(stream, {});
  stream.is_opened = true;
  log.write(stream, {});
  EXPECT_THAT(messages(), ElementsAre("stream refused", "stream failed"));
}

TEST_F(FrameLogTest, WarnsOfItsOwnFaults) {
  FrameLog log;
  log.write(frame_of(v1::OUTCOME_KIND_FAILED, {.code = absl::StatusCode::kInternal}), {});
  EXPECT_EQ(lines().front()["level"], "warning");
}

TEST_F(FrameLogTest, NamesTheSpanOfTheFrameOrElseThatOfTheClient) {
  FrameLog log;
  log.write(refused_frame(), {.trace_id = "t", .parent_id = "p", .span_id = "s"});
  log.write(frame_of(v1::OUTCOME_KIND_DROPPED), {.trace_id = "t", .parent_id = "p"});
  EXPECT_EQ(lines()[0]["trace_id"], "t");
  EXPECT_EQ(lines()[0]["span_id"], "s");
  EXPECT_EQ(lines()[1]["span_id"], "p");
}

}  // namespace
}  // namespace segserve::server
