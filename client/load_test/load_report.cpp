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

template <typename Counts>
void add_counts(Counts& counts, const Counts& others) {
  for (const auto& [key, count] : others) counts[key] += count;
}

}  // namespace

void Report::add_failure(const std::string& why) {
  ++sent;
  ++errors[why];
  latency.add_failure();
  since_sent.add_failure();
}

void Report::add(const client::Outcome& outcome, const FrameRecord& record) {
  if (outcome.report.attempts > 1) ++repeated;
  if (outcome.report.hedged) ++hedged;
  if (record.late_ms > 1) ++late;
  encode_ms += record.client_encode_ms;
  if (outcome.kind == client::OutcomeKind::kDropped) {
    ++sent;
    ++dropped;
    ++errors[error_key(outcome)];
    return;
  }
  if (outcome.kind != client::OutcomeKind::kResult) return add_failure(error_key(outcome));
  ++sent;
  ++results;
  ++results_of_server[outcome.report.address];
  points += record.points;
  bytes_up += outcome.report.bytes_sent;
  bytes_down += outcome.report.bytes_received;
  latency.add(record.latency_ms);
  since_sent.add(record.since_sent_ms);
  verified += record.verified ? 1 : 0;
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
                                               record.total_ms};
  const double known = std::accumulate(stages.begin(), stages.end() - 2, 0.0);
  stages[stages.size() - 2] = record.total_ms - known;
  for (std::size_t i = 0; i < stages.size(); ++i) stage_ms[i] += stages[i];
}

void Report::add_finished(std::size_t client, std::uint64_t frame_points) {
  ++finished;
  finished_points += frame_points;
  if (client >= finished_of_client.size()) finished_of_client.resize(client + 1);
  ++finished_of_client[client];
}

void Report::add(const Report& other) {
  sent += other.sent;
  results += other.results;
  dropped += other.dropped;
  repeated += other.repeated;
  hedged += other.hedged;
  late += other.late;
  verified += other.verified;
  mismatches += other.mismatches;
  points += other.points;
  bytes_up += other.bytes_up;
  bytes_down += other.bytes_down;
  finished += other.finished;
  finished_points += other.finished_points;
  finished_of_client.resize(std::max(finished_of_client.size(), other.finished_of_client.size()));
  for (std::size_t i = 0; i < other.finished_of_client.size(); ++i)
    finished_of_client[i] += other.finished_of_client[i];
  latency.add(other.latency);
  since_sent.add(other.since_sent);
  encode_ms += other.encode_ms;
  for (std::size_t i = 0; i < stage_ms.size(); ++i) stage_ms[i] += other.stage_ms[i];
  add_counts(results_of_server, other.results_of_server);
  add_counts(errors, other.errors);
}

double Report::frames_per_second() const { return seconds > 0 ? static_cast<double>(finished) / seconds : 0; }

double Report::mpoints_per_second() const {
  return seconds > 0 ? static_cast<double>(finished_points) / seconds / 1e6 : 0;
}

double Report::error_percent() const {
  if (sent == 0) return 100;
  return 100 * static_cast<double>(sent - results) / static_cast<double>(sent);
}

double Report::mean_stage_ms(std::size_t stage) const {
  return results == 0 ? 0 : stage_ms[stage] / static_cast<double>(results);
}

double Report::least_share_percent() const {
  if (least_share_of_runs) return *least_share_of_runs;
  if (finished == 0 || finished_of_client.empty()) return 0;
  const auto least = static_cast<double>(std::ranges::min(finished_of_client));
  return 100 * least * static_cast<double>(finished_of_client.size()) / static_cast<double>(finished);
}

}  // namespace segserve::bench
