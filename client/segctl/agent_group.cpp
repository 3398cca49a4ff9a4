// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/agent_group.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <utility>

#include "client/segctl/agent_message.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr milliseconds kConnectTime{5000};
constexpr milliseconds kPrepareTime{600'000};  // frames may be large, and verified
constexpr milliseconds kLook{20};
constexpr milliseconds kSlack{30'000};  // beyond the time that a run takes

absl::StatusOr<Json> parsed(const std::string& line) {
  Json message = Json::parse(line, nullptr, false);
  if (!message.is_object()) return absl::UnavailableError("it does not answer like an agent");
  RETURN_IF_ERROR(parse_error_message(message));
  return message;
}

/// The next message, if one comes in time.
absl::StatusOr<Json> next_message(bench::LineSocket& socket, milliseconds time) {
  ASSIGN_OR_RETURN(const auto line, socket.receive(time));
  if (!line) return absl::UnavailableError("it gives no answer");
  return parsed(*line);
}

absl::Status of_agent(const AgentAddress& address, const absl::Status& status) {
  return with_prefix(fmt::format("agent {}", address.text()), status);
}

}  // namespace

absl::Status AgentGroup::greet(Agent& agent, const std::vector<std::string>& arguments, const std::string& secret) {
  ASSIGN_OR_RETURN(const Json message, next_message(agent.socket, kConnectTime));
  ASSIGN_OR_RETURN(const AgentGreeting greeting, parse_greeting_message(message));
  Json answer{{"segserve_bench_agent", kAgentProtocol}, {"arguments", arguments}};
  if (greeting.asks_for_proof) {
    if (secret.empty()) {
      return absl::PermissionDeniedError("it asks for a secret: --agent-token-file names the file that holds it");
    }
    answer["proof"] = proof_of_arguments(secret, greeting, answer["arguments"]);
  }
  return agent.socket.send(answer.dump());
}

absl::StatusOr<std::shared_ptr<AgentGroup>> AgentGroup::connect(const std::vector<AgentAddress>& addresses,
                                                                const std::vector<std::string>& arguments,
                                                                const std::string& secret) {
  auto group = std::make_shared<AgentGroup>();
  for (const AgentAddress& address : addresses) {
    auto socket = bench::LineSocket::connect(address.host, address.port, kConnectTime);
    if (!socket.ok()) return of_agent(address, socket.status());
    group->agents_.push_back({address, *std::move(socket)});
    const absl::Status greeted = greet(group->agents_.back(), arguments, secret);
    if (!greeted.ok()) return of_agent(address, greeted);
  }
  for (Agent& agent : group->agents_) {
    const absl::Status status = next_message(agent.socket, kPrepareTime).status();
    if (!status.ok()) return of_agent(agent.address, status);
  }
  return group;
}

absl::StatusOr<bench::LoadResult> AgentGroup::run(const bench::LoadOptions& load, const bench::LoadObserver& observer) {
  const std::size_t used = std::min(agents_.size(), load.clients);
  bench::LoadOptions own = load;
  own.all_clients = load.clients;
  for (std::size_t i = 0; i < used; ++i) {
    own.first_client = load.clients * i / used;
    own.clients = load.clients * (i + 1) / used - own.first_client;
    const absl::Status sent = agents_[i].socket.send(run_message(own).dump());
    if (!sent.ok()) return of_agent(agents_[i].address, sent);
  }
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto planned = load.warm_up + load.duration;
  std::vector<std::optional<AgentResult>> results(used);
  bool told_to_stop = false;
  while (!std::ranges::all_of(results, [](const auto& result) { return result.has_value(); })) {
    const auto passed = Clock::now() - begin;
    if (observer.on_progress) {
      observer.on_progress(
          std::min(1.0, std::chrono::duration<double>(passed) / std::chrono::duration<double>(planned)));
    }
    if (!told_to_stop && load.interrupt != nullptr && *load.interrupt) {
      told_to_stop = true;
      for (std::size_t i = 0; i < used; ++i) agents_[i].socket.send(R"({"stop": true})").IgnoreError();
    }
    for (std::size_t i = 0; i < used; ++i) {
      if (results[i]) continue;
      const auto line = agents_[i].socket.receive(kLook);
      absl::Status status = line.status();
      if (status.ok() && *line) {
        const auto message = parsed(**line);
        auto result = message.ok() ? parse_result_message(*message) : message.status();
        status = result.status();
        if (result.ok()) results[i] = *std::move(result);
      } else if (status.ok() && passed > planned + load.drain + kSlack) {
        status = absl::UnavailableError("it gives no result");
      }
      if (!status.ok()) return of_agent(agents_[i].address, status);
    }
  }
  std::vector<AgentResult> all;
  all.reserve(used);
  for (auto& result : results) all.push_back(*std::move(result));
  AgentResult sum = merged(all);
  for (std::size_t i = 0; observer.on_interval && i < sum.intervals.size(); ++i) {
    observer.on_interval(sum.result.timeline[i], sum.intervals[i]);
  }
  return std::move(sum.result);
}

bench::LoadRunner agents_runner(std::shared_ptr<AgentGroup> agents) {
  return [agents = std::move(agents)](const bench::LoadOptions& load, const bench::LoadObserver& observer) {
    return agents->run(load, observer);
  };
}

}  // namespace segserve::segctl
