// SPDX-License-Identifier: Apache-2.0
#include "client/calls/repeated_call.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "client/calls/call_status.hpp"
#include "client/calls/retry.hpp"
#include "client/stream/address_book.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::client {
namespace {

bool is_worth_another(const ClientOptions& options, const absl::Status& status, std::uint32_t tries,
                      const AddressBook& book) {
  if (!is_retryable(status)) return false;
  const bool server_said_so = wire::details_of(status).reason != wire::ErrorReason::kUnspecified;
  if (server_said_so) return tries < options.retry.max_attempts;
  return options.wait_for_server || !book.nobody_in_reach();
}

}  // namespace

absl::Status repeat_call(Channels& channels, const ClientOptions& options, std::chrono::milliseconds timeout,
                         Attempt attempt) {
  const Time deadline = Clock::now() + timeout;
  const std::vector<std::string>& addresses = channels.addresses();
  AddressBook book(addresses.size(), channels.next_start(), options.retry, std::random_device()());
  absl::Status status;
  for (std::uint32_t tries = 0; tries == 0 || is_worth_another(options, status, tries, book); ++tries) {
    const AddressBook::Choice choice = book.choose(Clock::now());
    if (choice.not_before >= deadline) break;
    std::this_thread::sleep_until(choice.not_before);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + (deadline - Clock::now()));
    context.set_wait_for_ready(options.wait_for_server && addresses.size() == 1);
    const grpc::Status answer = attempt(channels.get(choice.address), context);
    if (answer.ok()) return absl::OkStatus();
    status = unavailable_if_cancelled(call_status(answer, addresses[choice.address]));
    book.failed(choice.address, Clock::now(), wire::details_of(status).retry_delay);
  }
  return status;
}

}  // namespace segserve::client
