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

/// What a queue must know of a job.
struct JobInfo {
  std::string client;         ///< whose job it is: jobs with equal names share what this name is due
  std::int32_t priority = 0;  ///< among the jobs of its client; the highest comes first
  std::uint64_t points = 0;   ///< of its cloud, as far as known: the estimate of its work
  std::uint64_t bytes = 0;    ///< that it keeps in memory until it ends
  /// Taken even if the queue is full, because something else has bounded such jobs: the credit of a stream. It counts
  /// against the bounds like any other.
  bool may_exceed_bounds = false;
};

/// A job is told which worker runs it, 0 .. workers - 1, so that it can use what that worker owns. It must
/// not throw.
struct Job {
  std::function<void(std::size_t worker)> run;
  /// Called instead of `run` if the job has to make way for a client with less in the queue. A job without this
  /// is never evicted.
  std::function<void()> evicted = nullptr;
};

/// Most jobs, bytes and points over all clients, waiting or running.
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

/// The order in which jobs of many clients get the workers, with bounds. Not thread-safe; it knows no clock.
///
/// Between clients it is fair by time on the workers (start-time fair queueing, Goyal, Vin and Cheng 1996): each
/// client has a virtual time, the time that its jobs took, and the waiting client with the least comes first. A job is
/// charged by an estimate when it starts (points times the usual time per point), which is corrected when it ends; so
/// neither large clouds nor costly options get a client more than its share. A client that was away comes back at the
/// queue's virtual time, or a little before: it gets all but nothing for the time when it asked for nothing, and keeps
/// a debt until the others have had as much. The queue's virtual time is the greatest virtual time at which a job
/// started, and grows at least by the work done per client at work: clients that appear for one job only do not
/// overtake for ever those that stay.
///
/// Within a client: the highest priority first, equals in the order of arrival.
///
/// A client that fills the queue does not keep others out: when a bound is reached, the last jobs of the client that
/// holds the largest part of the queue are evicted, as long as it still holds no less than the one for which they make
/// way.
class FairQueue {
 public:
  using Ticket = std::uint64_t;

  explicit FairQueue(const QueueBounds& bounds) : bounds_(bounds) {}

  struct Pushed {
    std::variant<Ticket, Refusal> result;
    std::vector<Job> evicted;  ///< the caller tells them; empty if the job is refused
  };
  Pushed push(JobInfo info, Job job);

  /// The job if it still waits. Its place, bytes and points are free.
  std::optional<Job> withdraw(Ticket ticket);

  struct Started {
    Ticket ticket;
    Job job;
  };
  /// The next job; it runs until `finish`. nullopt if none waits.
  std::optional<Started> start_next();

  /// The job, which was started, has ended. Its place, bytes and points are free.
  void finish(Ticket ticket, std::chrono::nanoseconds took);

  std::size_t waiting() const { return waiting_.size(); }
  /// Waiting or running.
  const QueueBounds& held() const { return held_; }
  /// Clients that are remembered: those with jobs, or with a debt or credit from the jobs they had.
  std::size_t clients() const { return clients_.size(); }
  /// How long one worker would need for all that waits or runs, judged by the jobs before.
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
    double charged;
  };
  struct Client {
    double virtual_time;  // ns
    std::map<Rank, Waiting> waiting = {};
    QueueBounds held = {};  // waiting or running
  };
  using Clients = std::map<std::string, Client>;

  std::optional<Refusal> refusal(const QueueBounds& held, const JobInfo& info) const;
  std::optional<std::vector<Ticket>> victims_for(const JobInfo& info) const;
  Job take(Ticket ticket);
  double share(const QueueBounds& held) const;
  double estimate(const JobInfo& info) const;
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
