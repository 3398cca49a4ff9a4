#include "client/load_test/load.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/load_test/arrivals.hpp"

namespace segserve::bench {
namespace {

using client::Clock;
using client::Payload;
using client::Time;

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime);
}

/// What all clients share and nobody changes while they run.
struct Setup {
  const LoadOptions& options;
  const FrameSource& source;
  /// Of every encoding and cloud.
  struct Frame {
    std::optional<Payload> payload;     ///< encoded beforehand, if that is asked for
    std::vector<std::uint32_t> labels;  ///< of a local run, or empty
  };
  std::vector<std::vector<Frame>> frames;
  Time begin, measured_from, end;

  std::size_t encoding_of(std::size_t client) const { return client % source.encodings.size(); }
};

/// One robot: a stream, a thread that sends and one that reads.
class Robot {
 public:
  Robot(const Setup& setup, std::size_t index, client::Stream stream)
      : setup_(setup),
        index_(index),
        encoding_(setup.source.encodings[setup.encoding_of(index)]),
        frames_(setup.frames[setup.encoding_of(index)]),
        stream_(std::move(stream)) {}

  void start() {
    sender_ = std::thread([this] { send_all(); });
    reader_ = std::thread([this] { read_all(); });
  }
  const Report& join() {
    sender_.join();
    reader_.join();
    return report_;
  }
  const absl::Status& status() const { return status_; }

 private:
  struct Sent {
    std::size_t frame = 0;
    Time intended, actual;
    double encode_ms = 0;
  };

  void send_all();
  void send_open_loop();
  void send_closed_loop();
  bool send(std::size_t frame, Time intended);
  void read_all();
  void record(const client::Outcome& outcome, const Sent& sent);

  const Setup& setup_;
  const std::size_t index_;
  const Encoding& encoding_;
  const std::vector<Setup::Frame>& frames_;
  client::Stream stream_;
  std::mutex mutex_;
  std::condition_variable outcome_came_;
  std::map<std::uint64_t, Sent> sent_;  // by sequence: frames without an outcome
  std::uint64_t last_sequence_ = 0;
  Report report_;
  absl::Status status_;
  std::thread sender_, reader_;
};

void Robot::send_all() {
  std::this_thread::sleep_until(setup_.begin);
  if (setup_.options.rate > 0) {
    send_open_loop();
  } else {
    send_closed_loop();
  }
  stream_.finish();
}

/// The intended time of a frame is when the window has room for it.
void Robot::send_closed_loop() {
  for (std::size_t frame = index_;; ++frame) {
    {
      std::unique_lock lock(mutex_);
      outcome_came_.wait(lock, [&] { return sent_.size() < setup_.options.stream.max_in_flight; });
    }
    const Time now = Clock::now();
    if (now >= setup_.end || !send(frame, now)) return;
  }
}

void Robot::send_open_loop() {
  const LoadOptions& options = setup_.options;
  const double rate = options.rate / static_cast<double>(options.clients);
  const double share = static_cast<double>(index_) / static_cast<double>(options.clients);
  Arrivals arrivals =
      options.poisson ? Arrivals::poisson(rate, options.seed * 1000 + index_) : Arrivals::constant(rate, share);
  for (std::size_t frame = index_;; ++frame) {
    const Time intended = setup_.begin + seconds(arrivals.next());
    if (intended >= setup_.end) return;
    std::this_thread::sleep_until(intended);
    if (!send(frame, intended)) return;
  }
}

bool Robot::send(std::size_t frame, Time intended) {
  Sent sent{.frame = frame % setup_.source.clouds.size(), .intended = intended, .actual = Clock::now(), .encode_ms = 0};
  const std::optional<Payload>& encoded = frames_[sent.frame].payload;
  absl::StatusOr<Payload> payload = encoded ? *encoded : encoding_.encode(setup_.source.clouds[sent.frame]);
  if (!payload.ok()) {
    status_ = payload.status();
    return false;
  }
  sent.encode_ms = encoded ? 0 : milliseconds(Clock::now() - sent.actual);
  {
    const std::lock_guard lock(mutex_);
    sent_[++last_sequence_] = sent;  // before the reader can see the outcome
  }
  const auto sequence = stream_.send(*std::move(payload), {.captured = sent.actual});
  if (sequence.ok()) return true;
  status_ = sequence.status();
  return false;
}

void Robot::read_all() {
  while (const auto outcome = stream_.next()) {
    Sent sent;
    {
      const std::lock_guard lock(mutex_);
      sent = sent_.extract(outcome->sequence).mapped();
      outcome_came_.notify_one();
    }
    record(*outcome, sent);
  }
}

void Robot::record(const client::Outcome& outcome, const Sent& sent) {
  if (sent.intended < setup_.measured_from) return;
  const Time now = Clock::now();
  FrameRecord record{.latency_ms = milliseconds(now - sent.intended),
                     .since_sent_ms = milliseconds(now - sent.actual),
                     .client_encode_ms = sent.encode_ms,
                     .late_ms = milliseconds(sent.actual - sent.intended),
                     .points = setup_.source.clouds[sent.frame]->size()};
  if (setup_.options.verify && outcome.result) {
    ++report_.verified;
    record.mismatch = outcome.result->segmentation.labels != frames_[sent.frame].labels;
  }
  report_.add(outcome, record);
}

/// Encodes a frame once, and segments it here, as far as that is asked for.
absl::StatusOr<Setup::Frame> prepare(const LoadOptions& options, const Encoding& encoding,
                                     const std::shared_ptr<const Cloud>& cloud) {
  Setup::Frame frame;
  auto payload = encoding.encode(cloud);  // in any case: what cannot be encoded is found before the run
  if (!payload.ok()) return payload.status();
  if (options.verify) {
    auto local = client::segment_here(*payload, options.stream.options, {}, StopToken());
    if (!local.ok()) return local.status();
    frame.labels = std::move(local->segmentation.labels);
  }
  if (options.encoded_beforehand) frame.payload = *std::move(payload);
  return frame;
}

/// All that the clients will send.
absl::Status prepare(const LoadOptions& options, Setup& setup) {
  for (std::size_t i = 0; i < std::min(setup.source.encodings.size(), options.clients); ++i) {
    auto& frames = setup.frames.emplace_back();
    for (const std::shared_ptr<const Cloud>& cloud : setup.source.clouds) {
      auto frame = prepare(options, setup.source.encodings[i], cloud);
      if (!frame.ok()) return frame.status();
      frames.push_back(*std::move(frame));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::unique_ptr<Robot>>> make_robots(const Setup& setup) {
  std::vector<std::unique_ptr<Robot>> robots;
  for (std::size_t i = 0; i < setup.options.clients; ++i) {
    const auto client = client::Client::connect(setup.options.client);
    if (!client.ok()) return client.status();
    client::StreamOptions options = setup.options.stream;
    options.outputs.compression = setup.source.encodings[setup.encoding_of(i)].of_answer;
    auto stream = client->open_stream(options);
    if (!stream.ok()) return stream.status();
    robots.push_back(std::make_unique<Robot>(setup, i, *std::move(stream)));
  }
  return robots;
}

}  // namespace

absl::StatusOr<Report> run_load(const LoadOptions& options, const FrameSource& source,
                                const std::function<void(double)>& progress) {
  Setup setup{.options = options, .source = source, .frames = {}, .begin = {}, .measured_from = {}, .end = {}};
  if (absl::Status status = prepare(options, setup); !status.ok()) return status;
  auto robots = make_robots(setup);
  if (!robots.ok()) return robots.status();
  setup.begin = Clock::now() + std::chrono::milliseconds(50);
  setup.measured_from = setup.begin + options.warm_up;
  setup.end = setup.measured_from + options.duration;
  for (const auto& robot : *robots) robot->start();

  const double all = milliseconds(setup.end - setup.begin);
  const auto wait_until = [&](Time until) {
    for (Time now = Clock::now(); now < until; now = Clock::now()) {
      progress(std::clamp(milliseconds(now - setup.begin) / all, 0.0, 1.0));
      std::this_thread::sleep_until(std::min(until, now + std::chrono::milliseconds(200)));
    }
  };
  wait_until(setup.measured_from);
  const double cpu_before = cpu_seconds();
  wait_until(setup.end);
  Report report;
  report.cpu_seconds = cpu_seconds() - cpu_before;
  absl::Status status;
  for (const auto& robot : *robots) {
    const Report& own = robot->join();
    report.add(own);
    report.results_of_client.push_back(own.results);
    if (!robot->status().ok()) status = robot->status();
  }
  // Frames that were begun within the span and ended after it count, and so does the time they took.
  report.seconds = milliseconds(std::max(Clock::now(), setup.end) - setup.measured_from) / 1000;
  if (report.sent == 0 && !status.ok()) return status;
  return report;
}

}  // namespace segserve::bench
