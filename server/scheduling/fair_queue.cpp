// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/fair_queue.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace segserve::server {
namespace {

// Every job costs as much as this number of points, however small its cloud is.
constexpr double kPointsOfAnyJob = 1000;

// How far behind the queue's virtual time a client may return, ns of a worker. A client that sends its next job when it
// has the result of the last one would otherwise lose part of its share whenever a longer job was in its way.
constexpr double kMaxLag = 1e9;

// A job that took less than this part of what was expected was not done, for example because it was too late. It tells
// nothing about the time of others, but a little of the expectation is forgotten with it: if no job is done any more
// because all seem to take too long, one has to be tried some time.
constexpr double kLeastPart = 0.1;
constexpr double kForgetting = 0.99;

// With more clients than these, no client may return behind the queue's virtual time.
constexpr std::size_t kMaxClientsWithLag = 256;

void add(QueueBounds& held, const JobInfo& info) {
  held.jobs += 1;
  held.bytes += info.bytes;
  held.points += info.points;
}

void subtract(QueueBounds& held, const JobInfo& info) {
  held.jobs -= 1;
  held.bytes -= info.bytes;
  held.points -= info.points;
}

double cost_in_points(std::uint64_t points) { return kPointsOfAnyJob + static_cast<double>(points); }

}  // namespace

FairQueue::Pushed FairQueue::push(JobInfo info, Job job) {
  Pushed pushed;
  std::vector<Ticket> victims;
  if (const auto refused = info.may_exceed_bounds ? std::nullopt : refusal(held_, info)) {
    std::optional<std::vector<Ticket>> found = victims_for(info);
    if (!found) return {*refused, {}};
    victims = *std::move(found);
  }
  pushed.evicted.reserve(victims.size());  // nothing may throw once a job has been evicted

  const Ticket ticket = next_ticket_++;
  const auto client = clients_.try_emplace(info.client, Client{.virtual_time = virtual_time_}).first;
  if (client->second.held.jobs == 0) {  // the client was away
    client->second.virtual_time = std::max(client->second.virtual_time, virtual_time_ - kMaxLag);
  }
  const Rank rank{.urgency = -std::int64_t{info.priority}, .ticket = ticket};
  const auto waiting = client->second.waiting.emplace(rank, Waiting{std::move(info), std::move(job)}).first;
  try {
    waiting_.emplace(ticket, std::pair(client, rank));
  } catch (...) {
    client->second.waiting.erase(waiting);
    throw;
  }
  add(client->second.held, waiting->second.info);
  add(held_, waiting->second.info);
  for (const Ticket victim : victims) pushed.evicted.push_back(take(victim));
  pushed.result = ticket;
  return pushed;
}

std::optional<Job> FairQueue::withdraw(Ticket ticket) {
  if (!waiting_.contains(ticket)) return std::nullopt;
  Job job = take(ticket);
  return job;
}

std::optional<FairQueue::Started> FairQueue::start_next() {
  const auto order = [](const Clients::value_type& entry) {
    const Client& client = entry.second;
    return client.waiting.empty() ? std::tuple(true, 0.0, Ticket{0})
                                  : std::tuple(false, client.virtual_time, client.waiting.begin()->first.ticket);
  };
  const auto next = std::ranges::min_element(clients_, {}, order);
  if (next == clients_.end() || next->second.waiting.empty()) return std::nullopt;

  Client& client = next->second;
  const auto next_job_of_client = next_job(client);
  const Ticket ticket = next_job_of_client->first.ticket;
  double& flow_time = client.flows[next_job_of_client->second.info.flow];
  Running& running = running_[ticket];  // these two first of all, because they may throw
  auto first = client.waiting.extract(next_job_of_client);
  waiting_.erase(ticket);
  virtual_time_ = std::max(virtual_time_, client.virtual_time);
  running.charged = ns_per_point_ * cost_in_points(first.mapped().info.points);
  client.flow_time = std::max(client.flow_time, flow_time);
  flow_time = client.flow_time + running.charged;
  std::erase_if(client.flows, [&client](const auto& flow) { return flow.second <= client.flow_time; });
  running.info = std::move(first.mapped().info);
  client.virtual_time += running.charged;
  return Started{ticket, std::move(first.mapped().job)};
}

std::map<FairQueue::Rank, FairQueue::Waiting>::iterator FairQueue::next_job(Client& client) {
  const auto first = client.waiting.begin();
  const auto end_of_equals = client.waiting.upper_bound({first->first.urgency, std::numeric_limits<Ticket>::max()});
  return std::min_element(first, end_of_equals, [&client](const auto& a, const auto& b) {
    const auto time_of = [&client](const std::string& flow) {
      const auto found = client.flows.find(flow);
      return found == client.flows.end() ? client.flow_time : found->second;
    };
    return time_of(a.second.info.flow) < time_of(b.second.info.flow);
  });
}

void FairQueue::finish(Ticket ticket, std::chrono::nanoseconds took) {
  const auto job = running_.extract(ticket);
  if (job.empty()) return;
  const JobInfo& info = job.mapped().info;
  const auto actual = static_cast<double>(took.count());
  const auto clients_with_jobs =
      std::ranges::count_if(clients_, [](const auto& entry) { return entry.second.held.jobs > 0; });
  Client& client = clients_.at(info.client);
  client.virtual_time += actual - job.mapped().charged;
  virtual_time_ += actual / static_cast<double>(clients_with_jobs);
  learn(client, actual, cost_in_points(info.points));
  subtract(client.held, info);
  subtract(held_, info);
  forget_clients();
}

std::optional<std::chrono::steady_clock::time_point> FairQueue::waiting_since() const {
  if (waiting_.empty()) return std::nullopt;
  const auto& [client, rank] = waiting_.begin()->second;  // tickets are given in the order of arrival
  return client->second.waiting.at(rank).info.since;
}

std::chrono::nanoseconds FairQueue::backlog() const {
  const double points = static_cast<double>(held_.points) + kPointsOfAnyJob * static_cast<double>(held_.jobs);
  return std::chrono::nanoseconds(static_cast<std::int64_t>(points * ns_per_point_));
}

std::optional<Refusal> FairQueue::refusal(const QueueBounds& held, const JobInfo& info) const {
  using Bound = Refusal::Bound;
  if (held.jobs >= bounds_.jobs) return Refusal{Bound::kJobs, bounds_.jobs, held.jobs + 1};
  if (info.bytes > bounds_.bytes || held.bytes > bounds_.bytes - info.bytes) {
    return Refusal{Bound::kBytes, bounds_.bytes, held.bytes + info.bytes};
  }
  if (info.points > bounds_.points || held.points > bounds_.points - info.points) {
    return Refusal{Bound::kPoints, bounds_.points, held.points + info.points};
  }
  return std::nullopt;
}

double FairQueue::share(const QueueBounds& held) const {
  const auto part = [](std::uint64_t value, std::uint64_t bound) {
    return static_cast<double>(value) / static_cast<double>(std::max<std::uint64_t>(bound, 1));
  };
  return std::max({part(held.jobs, bounds_.jobs), part(held.bytes, bounds_.bytes), part(held.points, bounds_.points)});
}

std::optional<std::vector<FairQueue::Ticket>> FairQueue::victims_for(const JobInfo& info) const {
  struct Holder {
    QueueBounds held;
    std::map<Rank, Waiting>::const_reverse_iterator last, end;  // jobs that may be evicted, the least urgent first
  };
  const auto skip_permanent = [](Holder& holder) {
    while (holder.last != holder.end && !holder.last->second.job.evicted) ++holder.last;
  };
  std::vector<Holder> holders;
  QueueBounds wanted{};
  for (const auto& [name, client] : clients_) {
    if (name == info.client) wanted = client.held;
    holders.push_back({client.held, client.waiting.rbegin(), client.waiting.rend()});
    skip_permanent(holders.back());
    if (name == info.client || holders.back().last == holders.back().end) holders.pop_back();
  }
  add(wanted, info);

  std::vector<Ticket> victims;
  QueueBounds held = held_;
  while (refusal(held, info)) {
    const auto holder = std::ranges::max_element(holders, {}, [this](const Holder& h) { return share(h.held); });
    if (holder == holders.end()) return std::nullopt;
    const auto& [rank, victim] = *holder->last;
    subtract(holder->held, victim.info);
    subtract(held, victim.info);
    if (share(holder->held) < share(wanted)) return std::nullopt;
    victims.push_back(rank.ticket);
    ++holder->last;
    skip_permanent(*holder);
    if (holder->last == holder->end) holders.erase(holder);
  }
  return victims;
}

Job FairQueue::take(Ticket ticket) {
  const auto [client, rank] = waiting_.extract(ticket).mapped();
  auto entry = client->second.waiting.extract(rank);
  subtract(client->second.held, entry.mapped().info);
  subtract(held_, entry.mapped().info);
  return std::move(entry.mapped().job);
}

std::chrono::nanoseconds FairQueue::expected_time(const std::string& client, std::uint64_t points) const {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return {};
  const double expected = std::min(found->second.ns_per_point * cost_in_points(points), found->second.ns_per_job);
  return std::chrono::nanoseconds(static_cast<std::int64_t>(expected));
}

void FairQueue::learn(Client& client, double ns, double points) {
  const double ns_per_point = ns / points;
  const bool was_done = ns >= kLeastPart * std::min(client.ns_per_point * points, client.ns_per_job);
  if (!was_done) {
    client.ns_per_point *= kForgetting;
    client.ns_per_job *= kForgetting;
    return;
  }
  ns_per_point_ += 0.1 * (ns_per_point - ns_per_point_);
  const bool is_first = client.ns_per_job == 0;
  client.ns_per_point += (is_first ? 1 : 0.1) * (ns_per_point - client.ns_per_point);
  client.ns_per_job += (is_first ? 1 : 0.1) * (ns - client.ns_per_job);
}

void FairQueue::forget_clients() {
  const double lag = clients_.size() > kMaxClientsWithLag ? 0 : kMaxLag;
  std::erase_if(clients_, [this, lag](const auto& entry) {
    return entry.second.held.jobs == 0 && entry.second.virtual_time <= virtual_time_ - lag;
  });
}

}  // namespace segserve::server
