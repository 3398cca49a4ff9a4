// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/state_metrics.hpp"

#include <chrono>
#include <cstdint>

#include "server/metrics/metric_families.hpp"

namespace segserve::server {
namespace {

double number(std::uint64_t value) { return static_cast<double>(value); }

double leased(const MemoryUse& memory, LeaseKind kind) { return number(memory.leased[static_cast<std::size_t>(kind)]); }

void add_pool(const PoolState& pool, std::vector<prometheus::MetricFamily>& families) {
  families.push_back(
      gauge("segserve_workers", "Workers, each of which computes one frame at a time.", number(pool.workers)));
  families.push_back(gauge("segserve_workers_busy", "Workers that compute a frame now.", number(pool.busy_workers)));
  families.push_back(gauge("segserve_queue_frames", "Frames that wait for a worker now.", number(pool.waiting)));
  families.push_back(gauge("segserve_queue_frames_limit",
                           "Frames that may wait for a worker before further ones are refused.",
                           number(pool.bounds.jobs - pool.workers)));
  families.push_back(gauge("segserve_queue_bytes", "Bytes of the payloads of frames that wait or are computed.",
                           number(pool.held.bytes)));
  families.push_back(gauge("segserve_queue_bytes_limit",
                           "Bytes of the payloads of frames that may wait or be computed.", number(pool.bounds.bytes)));
  families.push_back(gauge("segserve_queue_points", "Points of frames that wait or are computed, as estimated.",
                           number(pool.held.points)));
  families.push_back(gauge("segserve_queue_points_limit", "Points of frames that may wait or be computed.",
                           number(pool.bounds.points)));
  families.push_back(gauge("segserve_queue_longest_wait_seconds",
                           "Time for which the frame has waited that has waited longest of those that wait now.",
                           std::chrono::duration<double>(pool.longest_wait).count()));
}

void add_memory(const MemoryUse& memory, std::vector<prometheus::MetricFamily>& families) {
  families.push_back(gauge("segserve_memory_leased_bytes",
                           "Memory that frames have leased: waiting payloads, frames on a worker, unread results.",
                           {{leased(memory, LeaseKind::kWaiting), {{"kind", "waiting"}}},
                            {leased(memory, LeaseKind::kComputing), {{"kind", "computing"}}},
                            {leased(memory, LeaseKind::kResult), {{"kind", "result"}}}}));
  families.push_back(
      gauge("segserve_memory_limit_bytes", "Memory that all frames together may lease.", number(memory.budget)));
  families.push_back(gauge("segserve_memory_short", "1 if a frame found no memory in the last seconds, else 0.",
                           memory.is_short ? 1 : 0));
  families.push_back(counter("segserve_memory_refusals_total",
                             "Leases of memory that were not given or could not grow.", number(memory.refusals)));
}

}  // namespace

std::vector<prometheus::MetricFamily> StateMetrics::Collect() const {
  const ServiceState state = state_();
  std::vector<prometheus::MetricFamily> families;
  add_pool(state.pool, families);
  add_memory(state.memory, families);
  families.push_back(gauge("segserve_streams", "Streams that are open.", number(state.streams)));
  families.push_back(gauge("segserve_unary_calls", "Unary calls in flight.", number(state.unary_calls)));
  families.push_back(gauge("segserve_draining", "1 if the server is about to stop and takes no new frames, else 0.",
                           state.is_draining ? 1 : 0));
  families.push_back(counter("segserve_access_reloads_total",
                             "Changed files of tokens and keys that were taken, or refused for their faults.",
                             {{number(state.access_reloads), {{"outcome", "taken"}}},
                              {number(state.failed_access_reloads), {{"outcome", "refused"}}}}));
  return families;
}

}  // namespace segserve::server
