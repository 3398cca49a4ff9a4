// SPDX-License-Identifier: Apache-2.0
#include "client/calls/repeated_call.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "client/calls/call_status.hpp"
#include "client/fleet/retry.hpp"
#include "client/fleet/server_book.hpp"
#include "client/tls/handshake_fault.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {
namespace {

bool is_worth_another(const ClientOptions& options, const absl::Status& status, std::uint32_t tries,
                      const ServerBook& book) {
  if (is_handshake_fault(status)) return !book.nobody_in_reach();  // another address may do
  if (!is_retryable(status)) return false;
  const bool server_said_so = wire::details_of(status).reason != wire::ErrorReason::kUnspecified;
  if (server_said_so) return tries < options.retry.max_attempts;
  return options.wait_for_server || !book.nobody_in_reach();
}

absl::Status no_servers(const ServerList& list, const std::string& address) {
  if (!list.trouble.ok()) return list.trouble;
  return absl::DeadlineExceededError(fmt::format("the addresses of {} were not found in time", address));
}

}  // namespace

absl::Status repeat_call(Channels& channels, const ClientOptions& options, std::chrono::milliseconds timeout,
                         Attempt attempt) {
  const Time deadline = Clock::now() + timeout;
  ServerBook book(options.retry, std::random_device()());
  absl::Status status;
  for (std::uint32_t tries = 0; tries == 0 || is_worth_another(options, status, tries, book); ++tries) {
    const ServerList list = channels.fleet().wait_for_servers(deadline, options.wait_for_server);
    if (list.servers.empty()) return no_servers(list, options.address);
    book.set_servers(list.servers);
    const auto [server, not_before] = channels.turns().begin(list.servers, book, Clock::now());
    if (not_before >= deadline) {
      channels.turns().end(server.id, false, Clock::now());
      break;
    }
    std::this_thread::sleep_until(not_before);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + (deadline - Clock::now()));
    channels.authorize(context);
    // A server found by name may get another address, for which a connection to the old one would wait in vain. And a
    // connection that waits would hide that its handshake fails.
    const bool may_move = !server.authority.empty();
    context.set_wait_for_ready(options.wait_for_server && list.servers.size() == 1 && !may_move && !options.tls);
    const grpc::Status answer = attempt(channels.get(server), context);
    status = answer.ok() ? absl::OkStatus() : unavailable_if_cancelled(call_status(answer, server.address));
    if (handshake_failed(answer)) {
      const absl::Status fault = channels.handshake_fault(server.address, kHandshakeProbeTime);
      if (!fault.ok()) status = fault;
    }
    const bool reached = !absl::IsUnavailable(status) && !is_handshake_fault(status);
    channels.turns().end(server.id, reached, Clock::now());
    if (status.ok()) return status;
    book.failed(server.id, Clock::now(), wire::details_of(status).retry_delay);
    if (!reached) channels.fleet().on_trouble(Clock::now());
  }
  return status;
}

}  // namespace segserve::client
