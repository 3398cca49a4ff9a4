// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/load_report.hpp"

#include <algorithm>
#include <numeric>

#include "absl/status/status.h"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::bench {
namespace {

double milliseconds(client::Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// For example "FAILED RESOURCE_EXHAUSTED QUEUE_FULL".
std::string error_key(const client::Outcome& outcome) {
  if (outcome.kind != client::OutcomeKind::kFailed) return client::name(outcome.kind);
  const auto reason = wire::details_of(outcome.status).reason;
  const bool has_reason = reason != wire::ErrorReason::kUnspecified;
  return fmt::format("{} {}{}{}", client::name(outcome.kind), absl::StatusCodeToString(outcome.status.code()),
                     has_reason ? " " : "", has_reason ? wire::name(reason) : "");
}

}  // namespace

void Report::add(const client::Outcome& outcome, const FrameRecord& record) {
  ++sent;
  if (outcome.report.attempts > 1) ++repeated;
  if (record.late_ms > 1) ++late;
  if (outcome.kind != client::OutcomeKind::kResult) {
    ++errors[error_key(outcome)];
    return;
  }
  ++results;
  points += record.points;
  bytes_up += outcome.report.bytes_sent;
  bytes_down += outcome.report.bytes_received;
  latency.add(record.latency_ms);
  since_sent.add(record.since_sent_ms);
  mismatches += record.mismatch ? 1 : 0;

  const StageTimings& core = outcome.result->segmentation.timings;
  const wire::CallTimings& call = outcome.result->timings;
  std::array<double, kStages.size()> stages = {record.client_encode_ms,
                                               milliseconds(outcome.report.header_sent - outcome.report.handed_over),
                                               call.queue,
                                               call.decode,
                                               core.voxels,
                                               core.normals,
                                               core.supervoxels,
                                               core.graph,
                                               core.merging,
                                               core.labels,
                                               core.segments,
                                               call.encode,
                                               outcome.report.decode_ms,
                                               0,
                                               record.since_sent_ms};
  const double known = std::accumulate(stages.begin(), stages.end() - 2, 0.0);
  stages[stages.size() - 2] = record.since_sent_ms - known;
  for (std::size_t i = 0; i < stages.size(); ++i) stage_ms[i] += stages[i];
}

void Report::add(const Report& other) {
  sent += other.sent;
  results += other.results;
  repeated += other.repeated;
  late += other.late;
  verified += other.verified;
  mismatches += other.mismatches;
  points += other.points;
  bytes_up += other.bytes_up;
  bytes_down += other.bytes_down;
  latency.add(other.latency);
  since_sent.add(other.since_sent);
  for (std::size_t i = 0; i < stage_ms.size(); ++i) stage_ms[i] += other.stage_ms[i];
  for (const auto& [key, count] : other.errors) errors[key] += count;
}

double Report::frames_per_second() const { return seconds > 0 ? static_cast<double>(results) / seconds : 0; }

double Report::mpoints_per_second() const { return seconds > 0 ? static_cast<double>(points) / seconds / 1e6 : 0; }

double Report::error_percent() const {
  if (sent == 0) return 100;
  return 100 * static_cast<double>(sent - results) / static_cast<double>(sent);
}

double Report::mean_stage_ms(std::size_t stage) const {
  return results == 0 ? 0 : stage_ms[stage] / static_cast<double>(results);
}

double Report::least_share_percent() const {
  if (results == 0 || results_of_client.empty()) return 0;
  const auto least = static_cast<double>(std::ranges::min(results_of_client));
  return 100 * least * static_cast<double>(results_of_client.size()) / static_cast<double>(results);
}

double Report::cpu_ms_per_frame() const { return results == 0 ? 0 : 1000 * cpu_seconds / static_cast<double>(results); }

}  // namespace segserve::bench
