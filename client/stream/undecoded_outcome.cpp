// SPDX-License-Identifier: Apache-2.0
#include "client/stream/undecoded_outcome.hpp"

#include <chrono>
#include <optional>
#include <utility>

#include "client/calls/answer.hpp"
#include "core/base/exception_status.hpp"

namespace segserve::client {
namespace {

absl::StatusOr<Result> decode_result(const UndecodedOutcome& undecoded) {
  const auto points = undecoded.points != 0 ? std::optional(undecoded.points) : std::nullopt;
  try {
    return decode_answer(undecoded.message, points, undecoded.outputs, undecoded.wants_tracks);
  } catch (...) {
    return exception_status("decode the result");
  }
}

}  // namespace

Outcome decode(UndecodedOutcome undecoded) {
  Outcome outcome = std::move(undecoded.outcome);
  if (outcome.kind != OutcomeKind::kResult || outcome.result) return outcome;
  const Time start = Clock::now();
  auto result = decode_result(undecoded);
  outcome.report.decode_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (result.ok()) {
    outcome.result = *std::move(result);
  } else {
    outcome.kind = OutcomeKind::kFailed;
    outcome.status = result.status();
  }
  return outcome;
}

}  // namespace segserve::client
