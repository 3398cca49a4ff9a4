// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/agent_message.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "client/load_test/hdr_encoding.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "credentials/shared_secret.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::json;
using bench::HdrHistogram;
using bench::Latencies;
using bench::LoadOptions;
using bench::LoadResult;
using bench::Report;
using bench::TimelineEntry;

/// The numbers of a report that are told as they are.
template <typename AnyReport, typename Visit>
void visit_numbers(AnyReport& report, Visit visit) {
  visit("seconds", report.seconds);
  visit("sent", report.sent);
  visit("results", report.results);
  visit("dropped", report.dropped);
  visit("repeated", report.repeated);
  visit("hedged", report.hedged);
  visit("late", report.late);
  visit("verified", report.verified);
  visit("mismatches", report.mismatches);
  visit("points", report.points);
  visit("bytes_up", report.bytes_up);
  visit("bytes_down", report.bytes_down);
  visit("finished", report.finished);
  visit("finished_points", report.finished_points);
  visit("finished_of_client", report.finished_of_client);
  visit("encode_ms", report.encode_ms);
  visit("stage_ms", report.stage_ms);
  visit("results_of_server", report.results_of_server);
  visit("errors", report.errors);
}

template <typename AnyEntry, typename Visit>
void visit_numbers_of_entry(AnyEntry& entry, Visit visit) {
  visit("t", entry.t);
  visit("seconds", entry.seconds);
  visit("offered", entry.offered);
  visit("sent", entry.sent);
  visit("results", entry.results);
  visit("failed", entry.failed);
  visit("late", entry.late);
  visit("cpus", entry.client_busy_cpus);
  visit("rss", entry.client_rss_bytes);
}

template <typename AnyResult, typename Visit>
void visit_numbers_of_result(AnyResult& result, Visit visit) {
  visit("warm_up_s", result.warm_up_s);
  visit("window_s", result.window_s);
  visit("drain_s", result.drain_s);
  visit("cpu_seconds", result.cpu_seconds);
  visit("finished", result.finished);
  visit("cpus", result.cpus);
  visit("interrupted", result.interrupted);
}

auto write_to(Json& json) {
  return [&json](const char* key, const auto& value) { json[key] = value; };
}

/// nlohmann's exceptions say what is missing or of another type.
auto read_from(const Json& json) {
  return [&json](const char* key, auto& value) { json.at(key).get_to(value); };
}

Json latencies_json(const Latencies& latencies) {
  return {{"hdr", to_hdr_base64(latencies.histogram())}, {"failed", latencies.failed()}};
}

absl::StatusOr<Latencies> parse_latencies(const Json& json) {
  ASSIGN_OR_RETURN(HdrHistogram histogram, bench::from_hdr_base64(json.at("hdr").get<std::string>()));
  return Latencies(std::move(histogram), json.at("failed").get<std::uint64_t>());
}

Json report_json(const Report& report) {
  Json json;
  visit_numbers(report, write_to(json));
  json["latency"] = latencies_json(report.latency);
  json["since_sent"] = latencies_json(report.since_sent);
  return json;
}

absl::StatusOr<Report> parse_report(const Json& json) {
  Report report;
  visit_numbers(report, read_from(json));
  ASSIGN_OR_RETURN(report.latency, parse_latencies(json.at("latency")));
  ASSIGN_OR_RETURN(report.since_sent, parse_latencies(json.at("since_sent")));
  return report;
}

std::int64_t in_ms(std::chrono::milliseconds time) { return time.count(); }

absl::Status read_run(const Json& run, LoadOptions& load) {
  run.at("clients").get_to(load.clients);
  run.at("first_client").get_to(load.first_client);
  run.at("all_clients").get_to(load.all_clients);
  load.rates.clear();
  for (const Json& segment : run.at("rates")) {
    load.rates.push_back({segment.at(0).get<double>(), segment.at(1).get<double>(), segment.at(2).get<double>()});
  }
  load.levels.clear();
  for (const Json& level : run.at("levels_ms")) load.levels.emplace_back(level.get<std::int64_t>());
  load.warm_up = std::chrono::milliseconds(run.at("warm_up_ms").get<std::int64_t>());
  load.duration = std::chrono::milliseconds(run.at("duration_ms").get<std::int64_t>());
  load.drain = std::chrono::milliseconds(run.at("drain_ms").get<std::int64_t>());
  run.at("max_waiting").get_to(load.stream.max_waiting);
  constexpr std::size_t kMostClients = 1000;
  const bool is_sane = load.clients >= 1 && load.clients <= kMostClients && load.all_clients >= load.clients &&
                       load.all_clients <= kMostClients && load.duration.count() > 0 &&
                       load.duration <= std::chrono::hours(240);
  return is_sane ? absl::OkStatus() : absl::InvalidArgumentError("the run has impossible numbers");
}

absl::StatusOr<AgentResult> read_result(const Json& json) {
  AgentResult measured;
  LoadResult& result = measured.result;
  visit_numbers_of_result(result, read_from(json));
  for (const Json& level : json.at("parts")) {
    std::vector<Report>& parts = result.parts.emplace_back();
    for (const Json& part : level) {
      ASSIGN_OR_RETURN(parts.emplace_back(), parse_report(part));
    }
  }
  for (const Json& each : json.at("timeline")) {
    visit_numbers_of_entry(result.timeline.emplace_back(), read_from(each));
    ASSIGN_OR_RETURN(measured.intervals.emplace_back(), bench::from_hdr_base64(each.at("hdr").get<std::string>()));
  }
  if (result.parts.empty() || result.parts.front().empty()) return absl::InvalidArgumentError("a result without parts");
  return measured;
}

void add_entry(TimelineEntry& sum, const TimelineEntry& entry) {
  sum.offered += entry.offered;
  sum.sent += entry.sent;
  sum.results += entry.results;
  sum.failed += entry.failed;
  sum.late += entry.late;
  sum.client_busy_cpus += entry.client_busy_cpus;
  sum.client_rss_bytes += entry.client_rss_bytes;
}

void add_timeline(AgentResult& sum, const AgentResult& agent) {
  auto& timeline = sum.result.timeline;
  for (std::size_t i = 0; i < agent.result.timeline.size(); ++i) {
    const TimelineEntry& entry = agent.result.timeline[i];
    if (i >= timeline.size()) {
      timeline.push_back(entry);
      sum.intervals.push_back(agent.intervals[i]);
      continue;
    }
    add_entry(timeline[i], entry);
    timeline[i].seconds = std::max(timeline[i].seconds, entry.seconds);
    sum.intervals[i].add(agent.intervals[i]);
  }
}

void set_percentiles(AgentResult& sum) {
  for (std::size_t i = 0; i < sum.intervals.size(); ++i) {
    TimelineEntry& entry = sum.result.timeline[i];
    const Latencies latencies(sum.intervals[i], entry.failed);
    if (latencies.results() == 0) continue;
    entry.p50_ms = latencies.percentile(50);
    entry.p90_ms = latencies.percentile(90);
    entry.p99_ms = latencies.percentile(99);
    entry.max_ms = latencies.max();
  }
}

void add_parts(LoadResult& sum, const LoadResult& agent) {
  sum.parts.resize(std::max(sum.parts.size(), agent.parts.size()));
  for (std::size_t level = 0; level < agent.parts.size(); ++level) {
    std::vector<Report>& parts = sum.parts[level];
    parts.resize(std::max(parts.size(), agent.parts[level].size()));
    for (std::size_t i = 0; i < agent.parts[level].size(); ++i) {
      Report report = agent.parts[level][i];
      // Clients of different agents are different clients.
      std::vector<std::uint64_t> clients = parts[i].finished_of_client;
      clients.insert(clients.end(), report.finished_of_client.begin(), report.finished_of_client.end());
      parts[i].seconds = std::max(parts[i].seconds, report.seconds);
      parts[i].add(report);
      parts[i].finished_of_client = std::move(clients);
    }
  }
}

}  // namespace

Json run_message(const LoadOptions& load) {
  Json run = {{"clients", load.clients},
              {"first_client", load.first_client},
              {"all_clients", load.all_clients},
              {"rates", Json::array()},
              {"levels_ms", Json::array()},
              {"warm_up_ms", in_ms(load.warm_up)},
              {"duration_ms", in_ms(load.duration)},
              {"drain_ms", in_ms(load.drain)},
              {"max_waiting", load.stream.max_waiting}};
  for (const bench::RateSegment& each : load.rates) run["rates"].push_back({each.from, each.to, each.seconds});
  for (const auto level : load.levels) run["levels_ms"].push_back(in_ms(level));
  return {{"run", std::move(run)}};
}

absl::Status apply_run_message(const Json& message, LoadOptions& load) {
  try {
    return read_run(message.at("run"), load);
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(fmt::format("this is no message of a run: {}", error.what()));
  }
}

Json result_message(const AgentResult& measured) {
  Json json;
  visit_numbers_of_result(measured.result, write_to(json));
  json["parts"] = Json::array();
  for (const auto& level : measured.result.parts) {
    Json& parts = json["parts"].emplace_back(Json::array());
    for (const Report& part : level) parts.push_back(report_json(part));
  }
  json["timeline"] = Json::array();
  for (std::size_t i = 0; i < measured.intervals.size(); ++i) {
    Json& entry = json["timeline"].emplace_back();
    visit_numbers_of_entry(measured.result.timeline[i], write_to(entry));
    entry["hdr"] = to_hdr_base64(measured.intervals[i]);
  }
  return {{"result", std::move(json)}};
}

absl::StatusOr<AgentResult> parse_result_message(const Json& message) {
  try {
    return read_result(message.at("result"));
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(fmt::format("this is no message of a result: {}", error.what()));
  }
}

Json greeting_message(const AgentGreeting& greeting) {
  return {{"segserve_bench_agent", kAgentProtocol},
          {"challenge", greeting.challenge},
          {"asks_for_proof", greeting.asks_for_proof}};
}

absl::StatusOr<AgentGreeting> parse_greeting_message(const Json& message) {
  const auto is = [&message](const char* name, Json::value_t type) {
    return message.is_object() && message.contains(name) && message[name].type() == type;
  };
  if (!is("segserve_bench_agent", Json::value_t::number_unsigned)) {
    return absl::InvalidArgumentError("it does not greet like an agent");
  }
  if (message["segserve_bench_agent"] != kAgentProtocol) {
    return absl::InvalidArgumentError("this agent speaks another version of the protocol");
  }
  if (!is("challenge", Json::value_t::string) || !is("asks_for_proof", Json::value_t::boolean)) {
    return absl::InvalidArgumentError("it does not greet like an agent");
  }
  return AgentGreeting{message["challenge"].get<std::string>(), message["asks_for_proof"].get<bool>()};
}

std::string proof_of_arguments(std::string_view secret, const AgentGreeting& greeting, const Json& arguments) {
  return credentials::proof_of(secret, greeting.challenge + "\n" + arguments.dump());
}

bool is_proof_of_arguments(std::string_view proof, std::string_view secret, const AgentGreeting& greeting,
                           const Json& arguments) {
  return credentials::is_proof_of(proof, secret, greeting.challenge + "\n" + arguments.dump());
}

Json error_message(const absl::Status& status) {
  return {{"error", {{"code", status.raw_code()}, {"message", message_of(status)}}}};
}

absl::Status parse_error_message(const Json& message) {
  if (!message.is_object() || !message.contains("error")) return absl::OkStatus();
  try {
    const Json& error = message.at("error");
    const int code = error.at("code").get<int>();
    return {static_cast<absl::StatusCode>(code > 0 && code <= 16 ? code : 2), error.at("message").get<std::string>()};
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(fmt::format("this is no message of an error: {}", error.what()));
  }
}

AgentResult merged(const std::vector<AgentResult>& agents) {
  AgentResult sum;
  sum.result.cpus = 0;
  for (const AgentResult& agent : agents) {
    const LoadResult& result = agent.result;
    add_parts(sum.result, result);
    add_timeline(sum, agent);
    sum.result.warm_up_s = std::max(sum.result.warm_up_s, result.warm_up_s);
    sum.result.window_s = std::max(sum.result.window_s, result.window_s);
    sum.result.drain_s = std::max(sum.result.drain_s, result.drain_s);
    sum.result.cpu_seconds += result.cpu_seconds;
    sum.result.finished += result.finished;
    sum.result.cpus += result.cpus;
    sum.result.interrupted = sum.result.interrupted || result.interrupted;
  }
  set_percentiles(sum);
  sum.result.summarize();
  return sum;
}

}  // namespace segserve::segctl
