// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace segserve::server {

/// The facts about a job that a queue needs.
struct JobInfo {
  std::string client;         ///< the owner; all jobs with this name share one client's part of the workers
  std::string flow = {};      ///< of the client, such as one of its streams; flows have equal parts of the client's
  std::int32_t priority = 0;  ///< among the jobs of its client; the highest comes first
  std::uint64_t points = 0;   ///< of its cloud, as far as known; the work is estimated from it
  std::uint64_t bytes = 0;    ///< of memory that the job keeps until it ends
  /// The job is taken even if the queue is full, because something else, the credit of a stream, bounds such jobs. It
  /// counts against the bounds like any other.
  bool may_exceed_bounds = false;
  std::chrono::steady_clock::time_point since{};  ///< when it began to wait
};

struct Job {
  /// Gets the index of the worker that runs it, in [0, workers), so that it can use what that worker owns. Must not
  /// throw.
  std::function<void(std::size_t worker)> run;
  /// Called instead of `run` if the job has to make way for a client with less in the queue. A job without this
  /// function is never evicted.
  std::function<void()> evicted = nullptr;
};

/// Numbers of jobs, bytes and points over all clients, waiting or running.
struct QueueBounds {
  std::uint64_t jobs;
  std::uint64_t bytes;
  std::uint64_t points;
};

/// Why a job was not taken.
struct Refusal {
  enum class Bound { kJobs, kBytes, kPoints };
  Bound bound;
  std::uint64_t allowed;
  std::uint64_t actual;  ///< with the job
};

/// A bounded queue that decides in which order the jobs of many clients get the workers. Not thread-safe; it knows no
/// clock.
///
/// Clients get equal time on the workers (start-time fair queueing: P. Goyal, H. M. Vin, H. Cheng, 1996). Each client
/// has a virtual time, which is the time that its jobs took, and the waiting client with the least virtual time comes
/// first. When a job starts, its client is charged an estimate (points times the usual time per point); when it ends,
/// the estimate is replaced by the time that it took. So neither large clouds nor costly options give a client more
/// than its share.
///
/// The queue has a virtual time as well: the greatest virtual time at which a job started. It also grows by the time of
/// each job, divided by the number of clients that have jobs; otherwise clients that come for one job only would
/// overtake those that stay for ever. A client that returns starts at the queue's virtual time, or a little before, so
/// it gets next to nothing for the time when it was away. A client that has had more than its share keeps that debt.
///
/// Within a client, the job of the highest priority comes first. Among equal ones the flows of the client take turns in
/// the same way, by the estimates alone; the jobs of a flow keep the order of their arrival.
///
/// A client that fills the queue does not keep others out. When a bound is reached, the last jobs of the client that
/// holds the largest part of the queue are evicted, as long as that client still holds no less than the newcomer.
class FairQueue {
 public:
  using Ticket = std::uint64_t;

  explicit FairQueue(const QueueBounds& bounds) : bounds_(bounds) {}

  struct Pushed {
    std::variant<Ticket, Refusal> result;
    std::vector<Job> evicted;  ///< the caller must call their `evicted`; empty if the job is refused
  };
  Pushed push(JobInfo info, Job job);

  /// Takes the job out if it still waits. Its place, bytes and points are free then.
  std::optional<Job> withdraw(Ticket ticket);

  struct Started {
    Ticket ticket;
    Job job;
  };
  /// Takes out the next job, which counts as running until `finish`. nullopt if none waits.
  std::optional<Started> start_next();

  /// A job that was started has ended. Its place, bytes and points are free.
  void finish(Ticket ticket, std::chrono::nanoseconds took);

  /// Jobs that wait.
  std::size_t waiting() const { return waiting_.size(); }
  /// When the job that waits longest began to wait; nullopt if none waits.
  std::optional<std::chrono::steady_clock::time_point> waiting_since() const;
  /// The sum over waiting and running jobs.
  const QueueBounds& held() const { return held_; }
  const QueueBounds& bounds() const { return bounds_; }
  /// Clients that are remembered: they have jobs, or had more or less than their share.
  std::size_t clients() const { return clients_.size(); }
  /// How long a worker needs for a cloud of so many points, judged by earlier jobs of this client: by their time per
  /// point, but not longer than they took on average, because some take a time that has nothing to do with their
  /// points. 0 without any.
  std::chrono::nanoseconds expected_time(const std::string& client, std::uint64_t points) const;
  /// How long one worker would need for all waiting and running jobs, judged by earlier ones.
  std::chrono::nanoseconds backlog() const;

 private:
  struct Rank {
    std::int64_t urgency;  // minus the priority
    Ticket ticket;
    auto operator<=>(const Rank&) const = default;
  };
  struct Waiting {
    JobInfo info;
    Job job;
  };
  struct Running {
    JobInfo info;
    double charged = 0;
  };
  struct Client {
    double virtual_time;      // ns
    double ns_per_point = 0;  // of its jobs; 0: none was done yet
    double ns_per_job = 0;
    std::map<Rank, Waiting> waiting = {};
    double flow_time = 0;                      // the virtual time at which the last job of a flow started
    std::map<std::string, double> flows = {};  // virtual times that are later than that
    QueueBounds held = {};                     // waiting or running
  };
  using Clients = std::map<std::string, Client>;

  std::optional<Refusal> refusal(const QueueBounds& held, const JobInfo& info) const;
  /// The waiting jobs that make way for this one; nullopt if that would not be fair, or not enough.
  std::optional<std::vector<Ticket>> victims_for(const JobInfo& info) const;
  /// Takes a waiting job out.
  Job take(Ticket ticket);
  /// The part of the queue that is held, of the bound that is nearest.
  double share(const QueueBounds& held) const;
  /// The waiting job of the client that comes next.
  static std::map<Rank, Waiting>::iterator next_job(Client& client);
  /// A job of the client took so long.
  void learn(Client& client, double ns, double points);
  void forget_clients();

  const QueueBounds bounds_;
  QueueBounds held_{};
  Clients clients_;
  std::map<Ticket, std::pair<Clients::iterator, Rank>> waiting_;
  std::map<Ticket, Running> running_;
  Ticket next_ticket_ = 0;
  double virtual_time_ = 0;  // ns
  double ns_per_point_ = 250;
};

}  // namespace segserve::server
