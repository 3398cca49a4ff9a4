// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/agent_message.hpp"

#include <string>
#include <vector>

#include "client/load_test/line_socket.hpp"
#include "gmock/gmock.h"

namespace segserve::segctl {
namespace {

AgentResult measured(std::uint64_t clients, double latency_ms) {
  AgentResult agent;
  bench::Report report;
  report.seconds = 2;
  report.sent = report.results = 3;
  report.latency.add(latency_ms);
  report.latency.add_failure();
  for (std::uint64_t i = 0; i < clients; ++i) report.add_finished(i, 10);
  report.stage_ms[3] = 1.5;
  report.errors["UNFINISHED"] = 1;
  agent.result.parts = {{report, report}};
  agent.result.timeline.push_back({.t = 0, .seconds = 1, .offered = 5, .results = 1, .failed = 0});
  bench::HdrHistogram interval;
  interval.record(static_cast<std::uint64_t>(1000 * latency_ms));
  agent.intervals.push_back(interval);
  agent.result.window_s = 2;
  agent.result.cpu_seconds = 0.5;
  agent.result.cpus = 2;
  agent.result.summarize();
  return agent;
}

TEST(AgentMessage, AResultComesBackAsItWas) {
  const auto back = parse_result_message(nlohmann::json::parse(result_message(measured(2, 5)).dump()));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(result_message(*back), result_message(measured(2, 5)));
  EXPECT_EQ(back->result.parts[0][1].errors.at("UNFINISHED"), 1U);
}

TEST(AgentMessage, ResultsAddUp) {
  const AgentResult sum = merged({measured(2, 5), measured(1, 9)});
  EXPECT_EQ(sum.result.total.sent, 12U) << "of two agents and two encodings";
  EXPECT_EQ(sum.result.total.latency.failed(), 4U);
  EXPECT_DOUBLE_EQ(sum.result.total.seconds, 2);
  EXPECT_THAT(sum.result.codecs[0].finished_of_client, testing::ElementsAre(1, 1, 1));
  EXPECT_EQ(sum.result.timeline[0].offered, 10U);
  EXPECT_NEAR(*sum.result.timeline[0].p50_ms, 5, 0.01);
  EXPECT_NEAR(*sum.result.timeline[0].p99_ms, 9, 0.01);
  EXPECT_DOUBLE_EQ(sum.result.cpu_seconds, 1);
  EXPECT_EQ(sum.result.cpus, 4U);
}

TEST(AgentMessage, ARunComesBackAsItWas) {
  bench::LoadOptions load;
  load.clients = 3;
  load.first_client = 2;
  load.all_clients = 8;
  load.rates = {{1, 2, 3}, {4, 5, 6}};
  load.levels = {std::chrono::milliseconds(3000), std::chrono::milliseconds(7000)};
  load.stream.max_waiting = 77;
  bench::LoadOptions back;
  ASSERT_TRUE(apply_run_message(nlohmann::json::parse(run_message(load).dump()), back).ok());
  EXPECT_EQ(run_message(back), run_message(load));
}

TEST(AgentMessage, WrongOnesAreRefused) {
  bench::LoadOptions load;
  load.all_clients = 1;
  nlohmann::json run = run_message(load);
  ASSERT_TRUE(apply_run_message(run, load).ok());
  for (const char* key : {"clients", "rates", "duration_ms"}) {
    nlohmann::json changed = run;
    changed["run"].erase(key);
    EXPECT_TRUE(absl::IsInvalidArgument(apply_run_message(changed, load))) << key;
    changed["run"][key] = "x";
    EXPECT_TRUE(absl::IsInvalidArgument(apply_run_message(changed, load))) << key;
  }
  run["run"]["clients"] = 1'000'000'000;
  EXPECT_TRUE(absl::IsInvalidArgument(apply_run_message(run, load)));
  for (const char* text : {"{}", "[]", "1", R"({"result": {}})", R"({"result": {"parts": []}})"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_result_message(nlohmann::json::parse(text)).status())) << text;
  }
  nlohmann::json result = result_message(measured(1, 1));
  result["result"]["parts"][0][0]["latency"]["hdr"] = "no histogram";
  EXPECT_TRUE(absl::IsInvalidArgument(parse_result_message(result).status()));
}

TEST(AgentMessage, ErrorsKeepTheirCode) {
  EXPECT_TRUE(absl::IsNotFound(parse_error_message(error_message(absl::NotFoundError("no file")))));
  EXPECT_TRUE(parse_error_message(nlohmann::json{{"ready", true}}).ok());
  EXPECT_FALSE(parse_error_message(nlohmann::json::parse(R"({"error": 3})")).ok());
  EXPECT_FALSE(parse_error_message(nlohmann::json::parse(R"({"error": {"code": 0, "message": ""}})")).ok());
}

TEST(LineSocket, CarriesLinesAndHearsTheEnd) {
  using bench::LineSocket;
  const auto time = std::chrono::seconds(10);
  auto listener = bench::LineListener::listen("127.0.0.1", "0").value();
  auto client = LineSocket::connect("127.0.0.1", std::to_string(listener.port()), time).value();
  auto server = listener.accept(time);
  ASSERT_TRUE(server);
  EXPECT_EQ(*server->receive(std::chrono::milliseconds(1)), std::nullopt);
  ASSERT_TRUE(client.send("one").ok());
  ASSERT_TRUE(client.send("").ok());
  EXPECT_EQ(*server->receive(time), "one");
  EXPECT_EQ(*server->receive(time), "");
  {
    LineSocket gone = std::move(client);
    ASSERT_TRUE(gone.send("last").ok());
  }
  EXPECT_EQ(*server->receive(time), "last");
  EXPECT_TRUE(absl::IsUnavailable(server->receive(time).status()));
  EXPECT_TRUE(absl::IsUnavailable(LineSocket::connect("127.0.0.1", "1", time).status()));
}

TEST(AgentMessage, AGreetingComesBack) {
  const auto back = parse_greeting_message(nlohmann::json::parse(greeting_message({"abc", true}).dump()));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->challenge, "abc");
  EXPECT_TRUE(back->asks_for_proof);
  for (const char* text : {"{}", "[]", R"({"segserve_bench_agent": 1})", R"({"segserve_bench_agent": 2})",
                           R"({"segserve_bench_agent": 2, "challenge": 3, "asks_for_proof": true})",
                           R"({"segserve_bench_agent": "2", "challenge": "a", "asks_for_proof": true})"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_greeting_message(nlohmann::json::parse(text)).status())) << text;
  }
}

TEST(AgentMessage, AProofIsForItsSecretChallengeAndArguments) {
  const nlohmann::json arguments{"--clients", "3"};
  const std::string proof = proof_of_arguments("secret", {"once", true}, arguments);
  EXPECT_TRUE(is_proof_of_arguments(proof, "secret", {"once", true}, arguments));
  EXPECT_FALSE(is_proof_of_arguments(proof, "other", {"once", true}, arguments));
  EXPECT_FALSE(is_proof_of_arguments(proof, "secret", {"again", true}, arguments));
  EXPECT_FALSE(is_proof_of_arguments(proof, "secret", {"once", true}, {"--clients", "4"}));
}

}  // namespace
}  // namespace segserve::segctl
