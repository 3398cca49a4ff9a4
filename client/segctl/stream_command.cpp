// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "client/segctl/command.hpp"
#include "client/segctl/exit_code.hpp"
#include "client/segctl/interrupt.hpp"
#include "client/segctl/live_page.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/stream_arguments.hpp"
#include "client/segctl/stream_stats.hpp"
#include "client/segctl/stream_terminal.hpp"
#include "core/base/mutex.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "segserve/client/client.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

using Clock = std::chrono::steady_clock;
using Content = std::shared_ptr<const codec::LabeledCloud>;

constexpr double kDefaultRate = 10;

HelpText help() {
  return {
      .common = {"--moving", "--rate", "--speed", "--loop", "--duration", "--topic", "--track", "--method",
                 "--threshold", "--server", "--html-live", "--json"},
      .examples = R"(segctl stream run.mcap --topic /points --speed 2
segctl stream frames/ --rate 10 --loop --html-live 127.0.0.1:8081
segctl stream --moving --rate 15 --frames 600 --html-live 127.0.0.1:8081)",
      .details =
          R"(All frames go through one stream, each when its time has come. On a terminal a table shows frames, rate, latencies,
dropped frames and segments of the last ten seconds; elsewhere there is only the summary at the end. It also
tells how many frames were sent more than 50 ms later than planned, because reading them took too long or, with --wait,
the server did. Ctrl-C ends the stream.

--html-live serves the page of segctl view. It follows the stream from the viewpoint that was chosen in it, segments keep
their colors, and it can be paused. It listens on this machine only, unless --html-live-for-anyone is given; it has no
password. A browser gets the newest frame when it is done with the one before.)",
      .exit_codes = "0 success, also after Ctrl-C; 1 the operation failed; 2 bad input or usage."};
}

/// A stream from its first frame to its summary.
class StreamRun {
 public:
  explicit StreamRun(const StreamArguments& arguments) : arguments_(arguments), stats_(Clock::now()) {}

  absl::Status run();

 private:
  absl::Status open();
  void send_all(client::Stream& stream);
  /// Sends the frames of a feed from its beginning to its end. Returns whether there may be another round: not if none
  /// of them could be read.
  bool send_round(FrameFeed& feed, client::Stream& stream);
  /// `delay` is how much later than planned this is.
  void send(FeedFrame frame, Clock::duration delay, client::Stream& stream);
  /// False if the stream is to end before that time.
  bool wait_until(Clock::time_point due) const;
  void receive(client::Outcome outcome);
  void fail(const std::string& name, const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void show(StreamTerminal& terminal) ABSL_LOCKS_EXCLUDED(mutex_);
  void follow(client::Stream& stream);
  absl::Status report();

  const StreamArguments& arguments_;
  const Interrupt interrupt_;
  FeedOptions feed_options_;
  Options options_;
  StagedOutput output_;
  std::unique_ptr<FrameFeed> feed_;
  std::optional<client::Stream> stream_;
  std::unique_ptr<LivePage> page_;
  std::atomic<bool> stopping_{false};
  // Only the thread that sends uses the following members.
  Clock::time_point start_;
  std::optional<Clock::time_point> first_due_;
  double round_begin_ = 0;  // seconds since `first_due_`, by the times of the frames
  double last_time_ = 0;
  std::uint64_t next_sequence_ = 1;  // The stream numbers its frames from 1, and does not count those that it refused.

  Mutex mutex_;
  StreamStats stats_ ABSL_GUARDED_BY(mutex_);
  std::map<std::uint64_t, std::pair<std::string, Content>> sent_ ABSL_GUARDED_BY(mutex_);  // without an outcome
  std::string first_failure_ ABSL_GUARDED_BY(mutex_);
  bool all_are_bad_input_ ABSL_GUARDED_BY(mutex_) = true;
  absl::Status ended_ ABSL_GUARDED_BY(mutex_);  // why the stream can go on no more
};

absl::Status StreamRun::open() {
  RETURN_IF_ERROR(output_.protect(arguments_.inputs, true));
  RETURN_IF_ERROR(arguments_.json.announce(output_));
  ASSIGN_OR_RETURN(feed_options_, arguments_.feed_options());
  ASSIGN_OR_RETURN(const client::StreamOptions options, arguments_.stream_options());
  ASSIGN_OR_RETURN(const auto address, arguments_.page_address());
  options_ = options.options;
  ASSIGN_OR_RETURN(feed_, open_feed(feed_options_));
  ASSIGN_OR_RETURN(const auto client, arguments_.server.connect(arguments_.fallback_local));
  // Without this, every frame would fail for the same reason.
  absl::Status reached = client.server_info().status();
  if (!reached.ok() && !(arguments_.fallback_local && absl::IsUnavailable(reached))) return reached;
  if (address) {
    auto page = LivePage::start(*address);
    if (!page.ok()) return with_prefix(fmt::format("--html-live {}", arguments_.html_live), page.status());
    page_ = *std::move(page);
    if (!arguments_.quiet) {
      fmt::print(stderr, "segctl: the stream is shown at http://{}:{}/\n",
                 address->host.find(':') == std::string::npos ? address->host : "[" + address->host + "]",
                 page_->port());
    }
  }
  ASSIGN_OR_RETURN(auto stream, client.open_stream(options));
  stream_.emplace(std::move(stream));
  return absl::OkStatus();
}

bool StreamRun::wait_until(Clock::time_point due) const {
  constexpr std::chrono::milliseconds kSlice{20};
  while (!stopping_) {
    const auto left = due - Clock::now();
    if (left <= Clock::duration::zero()) return true;
    std::this_thread::sleep_for(std::min<Clock::duration>(left, kSlice));
  }
  return false;
}

void StreamRun::fail(const std::string& name, const absl::Status& status) {
  const MutexLock lock(mutex_);
  if (first_failure_.empty()) first_failure_ = fmt::format("{}: {}", name, message_of(status));
  all_are_bad_input_ = all_are_bad_input_ && exit_code(status) == kBadInput;
}

void StreamRun::send(FeedFrame frame, Clock::duration delay, client::Stream& stream) {
  absl::Status status = frame.content.status();
  {
    const MutexLock lock(mutex_);
    stats_.add_frame(delay);
  }
  if (status.ok()) {
    const auto content = std::make_shared<const codec::LabeledCloud>(*std::move(frame.content));
    client::FrameOptions options{.frame_id = frame.frame_id, .pose = frame.pose};
    if (!content->placement.is_identity()) options.options = codec::to_cloud(content->placement, options_);
    {
      const MutexLock lock(mutex_);  // The outcome can come before send returns.
      sent_[next_sequence_] = {frame.name, content};
    }
    status = stream.send(std::shared_ptr<const Cloud>(content, &content->cloud), options).status();
    if (status.ok()) {
      ++next_sequence_;
      return;
    }
    const MutexLock lock(mutex_);
    sent_.erase(next_sequence_);
    if (client::is_outage(status) || absl::IsFailedPrecondition(status)) {
      if (ended_.ok()) ended_ = status;
      stopping_ = true;
    }
  }
  fail(frame.name, status);
  const MutexLock lock(mutex_);
  stats_.add_failure();
}

bool StreamRun::send_round(FrameFeed& feed, client::Stream& stream) {
  std::uint64_t frames = 0;
  bool has_content = false;
  while (!stopping_) {
    auto frame = feed.next();
    if (frame.ok() && *frame && (*frame)->content.ok()) has_content = true;
    if (!frame.ok()) {
      const MutexLock lock(mutex_);
      ended_ = frame.status();
      return false;
    }
    if (!*frame) break;
    if (absl::IsCancelled((*frame)->content.status())) return false;  // a signal came while a pipe was read
    if (!first_due_) first_due_ = Clock::now();                       // The stream begins when its first frame is read.
    const double rate = arguments_.rate.value_or(kDefaultRate);
    const bool has_own_time = !arguments_.rate && feed.has_times();
    last_time_ = round_begin_ + (has_own_time ? (*frame)->time : static_cast<double>(frames) / rate);
    const std::chrono::duration<double> due(last_time_ / arguments_.speed);
    const Clock::time_point planned = *first_due_ + std::chrono::duration_cast<Clock::duration>(due);
    if (!wait_until(planned)) return false;
    send(*std::move(*frame), Clock::now() - planned, stream);
    ++frames;
  }
  // The next round begins one frame after the last.
  const double length = last_time_ - round_begin_;
  const bool has_interval = frames > 1 && length > 0;
  round_begin_ = last_time_ + (has_interval ? length / static_cast<double>(frames - 1) : 1.0 / kDefaultRate);
  return has_content && !stopping_;
}

void StreamRun::send_all(client::Stream& stream) {
  while (send_round(*feed_, stream) && arguments_.loop) {
    auto feed = open_feed(feed_options_);
    if (!feed.ok()) {
      const MutexLock lock(mutex_);
      ended_ = feed.status();
      break;
    }
    feed_ = *std::move(feed);
  }
  stream.finish();
}

void StreamRun::receive(client::Outcome outcome) {
  std::pair<std::string, Content> sent;
  nlohmann::ordered_json figures;
  {
    const MutexLock lock(mutex_);
    if (const auto at = sent_.find(outcome.sequence); at != sent_.end()) {
      sent = std::move(at->second);
      sent_.erase(at);
    }
    stats_.add(outcome, Clock::now());
    if (page_) figures = stats_.json(Clock::now());
    if (client::is_outage(outcome.status) && ended_.ok()) ended_ = outcome.status;
  }
  if (outcome.kind == client::OutcomeKind::kFailed) fail(sent.first, outcome.status);
  if (!page_ || !outcome.result || !sent.second) return;
  page_->show({sent.first, std::move(sent.second), *std::move(outcome.result), std::move(figures)});
}

void StreamRun::show(StreamTerminal& terminal) {
  if (!terminal.is_shown() || arguments_.quiet) return;
  const std::size_t columns = terminal.columns();
  const std::string title = fmt::format("{} to {}", arguments_.title(), arguments_.server.address());
  const MutexLock lock(mutex_);
  terminal.show(title.substr(0, columns - std::min<std::size_t>(columns, 1)) + "\n" +
                stats_.table(Clock::now(), columns));
}

void StreamRun::follow(client::Stream& stream) {
  constexpr std::chrono::milliseconds kPatience{50};
  constexpr std::chrono::milliseconds kRedraw{250};
  StreamTerminal terminal;
  Clock::time_point drawn;
  bool is_cancelled = false;
  while (!stream.done()) {
    if (auto outcome = stream.next(kPatience)) receive(*std::move(outcome));
    const auto now = Clock::now();
    if (now - drawn >= kRedraw) {
      drawn = now;
      show(terminal);
    }
    const bool is_over = arguments_.duration && now - start_ >= std::chrono::duration<double>(*arguments_.duration);
    if (interrupt_.came() || is_over) stopping_ = true;
    if (!interrupt_.came() || is_cancelled) continue;
    is_cancelled = true;
    std::vector<std::uint64_t> open;
    {
      const MutexLock lock(mutex_);
      for (const auto& [sequence, sent] : sent_) open.push_back(sequence);
    }
    for (const std::uint64_t sequence : open) stream.cancel(sequence);
  }
}

absl::Status StreamRun::report() {
  const MutexLock lock(mutex_);
  const auto end = Clock::now();
  arguments_.json.add(output_, stats_.summary_json(end));
  if (!arguments_.quiet && !output_.uses_stdout()) {
    output_.add("-", fmt::format("{}: {}", arguments_.title(), stats_.summary(end)));
  }
  RETURN_IF_ERROR(output_.commit());
  RETURN_IF_ERROR(ended_);
  if (stats_.failed() == 0) return absl::OkStatus();
  const std::string message =
      fmt::format("{} of {} frames failed; {}", stats_.failed(), stats_.frames(), first_failure_);
  return all_are_bad_input_ ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
}

absl::Status StreamRun::run() {
  RETURN_IF_ERROR(open());
  start_ = Clock::now();
  {
    const MutexLock lock(mutex_);
    stats_ = StreamStats(start_);
  }
  std::thread sender([this] { send_all(*stream_); });
  follow(*stream_);
  sender.join();
  return report();
}

absl::Status run_stream(const StreamArguments& arguments) {
  RETURN_IF_ERROR(arguments.check_combination());
  return StreamRun(arguments).run();
}

}  // namespace

void add_stream_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "stream", "Stream frames at a given rate, with a live table and a live page", help(),
              run_stream);
}

}  // namespace segserve::segctl
