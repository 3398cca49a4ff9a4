// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_agent.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/load_test/line_socket.hpp"
#include "client/load_test/plan.hpp"
#include "client/segctl/agent_address.hpp"
#include "client/segctl/agent_message.hpp"
#include "client/segctl/bench_arguments.hpp"
#include "client/segctl/bench_frames.hpp"
#include "client/segctl/interrupt.hpp"
#include "client/segctl/messages.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "credentials/new_token.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::json;
using bench::LineSocket;
using std::chrono::milliseconds;

constexpr milliseconds kLook{50};          // how soon a stop is seen
constexpr milliseconds kGreeting{10'000};  // within which a load test must say what it wants
constexpr milliseconds kPenalty{500};      // after a wrong proof, so that nobody can try many
constexpr std::size_t kMostGreetingBytes = 1U << 20U;
constexpr milliseconds kIdle{3'600'000};  // after which a load test that says nothing more is left

/// A load test that this agent works for.
class Work {
 public:
  Work(LineSocket socket, const std::string& secret, const std::atomic<bool>& ended)
      : socket_(std::move(socket)), secret_(secret), ended_(ended) {}

  /// Returns when the connection is over.
  absl::Status serve() {
    absl::Status status = prepare();
    if (!status.ok()) return answer_error(status);
    RETURN_IF_ERROR(answer({{"ready", true}}));
    while (true) {
      ASSIGN_OR_RETURN(const Json message, next_message(kIdle, LineSocket::kMostBytes));
      if (message.contains("stop")) continue;  // it came too late
      bench::LoadOptions load = plan_.load;
      status = apply_run_message(message, load);
      RETURN_IF_ERROR(status.ok() ? run(std::move(load)) : answer_error(status));
    }
  }

 private:
  absl::Status answer(const Json& message) { return socket_.send(message.dump()); }
  absl::Status answer_error(const absl::Status& status) { return answer(error_message(status)); }

  absl::StatusOr<Json> next_message(milliseconds time, std::size_t most_bytes) {
    const auto until = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < until && !ended_) {
      ASSIGN_OR_RETURN(const auto line, socket_.receive(kLook, most_bytes));
      if (!line) continue;
      Json message = Json::parse(*line, nullptr, false);
      if (message.is_object()) return message;
      return absl::InvalidArgumentError("a line is no JSON object");
    }
    return absl::UnavailableError("the load test says nothing");
  }

  /// The arguments of a load test that may use this agent.
  absl::StatusOr<Json> admitted_arguments() {
    ASSIGN_OR_RETURN(const std::string challenge, credentials::new_token());
    const AgentGreeting greeting{.challenge = challenge, .asks_for_proof = !secret_.empty()};
    RETURN_IF_ERROR(answer(greeting_message(greeting)));
    ASSIGN_OR_RETURN(const Json message, next_message(kGreeting, kMostGreetingBytes));
    const auto version = message.find("segserve_bench_agent");
    if (version == message.end() || *version != kAgentProtocol) {
      return absl::InvalidArgumentError("this agent speaks another version of the protocol");
    }
    const auto arguments = message.find("arguments");
    const Json given = arguments == message.end() ? Json::array() : *arguments;
    if (secret_.empty()) return given;
    const auto proof = message.find("proof");
    const bool is_known = proof != message.end() && proof->is_string() &&
                          is_proof_of_arguments(proof->get<std::string>(), secret_, greeting, given);
    if (is_known) return given;
    print_warning("a load test that does not know the secret was refused");
    std::this_thread::sleep_for(kPenalty);
    return absl::PermissionDeniedError("this agent has another secret than the load test (--agent-token-file)");
  }

  absl::Status prepare() {
    ASSIGN_OR_RETURN(const Json arguments, admitted_arguments());
    std::vector<std::string> words;
    for (const Json& word : arguments) {
      if (word.is_string()) words.push_back(word.get<std::string>());
    }
    std::ranges::reverse(words);  // as CLI11 wants them
    CLI::App app;
    arguments_.add_to(app);
    try {
      app.parse(std::move(words));
    } catch (const CLI::ParseError& error) {
      return absl::InvalidArgumentError(error.what());
    }
    ASSIGN_OR_RETURN(plan_, arguments_.plan());
    ASSIGN_OR_RETURN(auto source, frame_source(arguments_));
    ASSIGN_OR_RETURN(runner_, bench::local_runner(plan_, std::move(source)));
    return absl::OkStatus();
  }

  /// Runs the load on a thread of its own, and listens for a stop meanwhile.
  absl::Status run(bench::LoadOptions load) {
    std::atomic<bool> stop{false}, done{false};
    load.interrupt = &stop;
    AgentResult measured;
    bench::LoadObserver observer;
    observer.on_interval = [&measured](const bench::TimelineEntry&, const bench::HdrHistogram& latencies) {
      measured.intervals.push_back(latencies);
    };
    absl::Status status, connection;
    {
      const std::jthread thread([&] {
        auto result = runner_(load, observer);
        status = result.status();
        if (result.ok()) measured.result = *std::move(result);
        done = true;
      });
      while (!done && connection.ok()) {
        const auto line = socket_.receive(kLook);
        connection = line.status();
        if (!connection.ok() || *line || ended_) stop = true;  // whatever comes during a run is a stop
      }
    }
    RETURN_IF_ERROR(connection);
    return status.ok() ? answer(result_message(measured)) : answer_error(status);
  }

  LineSocket socket_;
  const std::string& secret_;  // empty: none is asked for
  const std::atomic<bool>& ended_;
  BenchArguments arguments_;
  bench::LoadPlan plan_;
  bench::LoadRunner runner_;
};

}  // namespace

absl::Status serve_as_agent(const std::string& listen, const std::string& secret, bool anyone) {
  ASSIGN_OR_RETURN(const AgentAddress address, parse_agent_address("--agent", listen));
  if (secret.empty() && !anyone && !address.is_loopback()) {
    return absl::InvalidArgumentError(
        fmt::format("--agent {}: whoever reaches this address could load any server through it; --agent-token-file "
                    "admits only who has its secret, --agent-for-anyone admits all",
                    listen));
  }
  const Interrupt interrupt;
  auto listener = bench::LineListener::listen(address.host, address.port);
  if (!listener.ok()) return with_prefix(fmt::format("cannot listen at {}", listen), listener.status());
  fmt::print("waits for load tests at {}:{}\n", address.host, listener->port());
  std::fflush(stdout);
  while (!interrupt.came()) {
    auto connection = listener->accept(std::chrono::milliseconds(200));
    if (!connection) continue;
    const absl::Status status = Work(*std::move(connection), secret, interrupt.flag()).serve();
    if (!absl::IsUnavailable(status)) print_warning(message_of(status));
  }
  return absl::OkStatus();
}

}  // namespace segserve::segctl
