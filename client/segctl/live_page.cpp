// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/live_page.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <string_view>
#include <system_error>
#include <utility>

#include "client/page/bundled_pages.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/page_bundle.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/view_page/view_page.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

/// A request waits so long for a newer frame, and then comes again.
constexpr std::chrono::seconds kPatience{20};
/// Browsers get slow with more.
constexpr std::size_t kMostDrawnPoints = 2'000'000;

/// Tells the page that it shows a stream.
constexpr std::string_view kDataMark = "<!--DATA-->";
constexpr std::string_view kLiveMark = "<template id=\"live-stream\"></template>";

absl::StatusOr<view_page::PageData> page_data_of(const LiveFrame& frame) {
  if (frame.cloud->cloud.size() > kMostDrawnPoints) {
    return absl::InvalidArgumentError("the cloud has too many points to be drawn in a browser");
  }
  const std::array clouds{view_page::PageCloud{
      .points = frame.cloud->cloud, .truth = frame.cloud->label, .placement = frame.cloud->placement}};
  const std::array results{view_page::PageResult{.name = frame.title,
                                                 .method = std::string(name(frame.result.method)),
                                                 .cloud = 0,
                                                 .segmentation = &frame.result.segmentation,
                                                 .regions = frame.result.regions}};
  return view_page::page_data(frame.title, clouds, results);
}

std::string text_of(const LiveFrame& frame, std::uint64_t sequence) {
  Json json{{"sequence", sequence}, {"stats", frame.stats}};
  auto data = page_data_of(frame);
  if (data.ok()) {
    json["page"] = std::move(data->json);
    Json& arrays = json["arrays"] = Json::object();
    for (auto& [id, text] : data->arrays) arrays[id] = std::move(text);
  } else {
    json["error"] = message_of(data.status());
  }
  return json_text(json);
}

/// The number after "after=" in a query; 0 if there is none.
std::uint64_t after_of(std::string_view query) {
  constexpr std::string_view kName = "after=";
  std::uint64_t after = 0;
  if (!query.starts_with(kName)) return 0;
  const std::string_view digits = query.substr(kName.size());
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), after);
  return error == std::errc() && end == digits.data() + digits.size() ? after : 0;
}

bench::HttpReply json_reply(std::shared_ptr<const std::string> body) {
  bench::HttpReply reply;
  reply.content_type = "application/json";
  reply.body = std::move(body);
  return reply;
}

}  // namespace

LivePage::LivePage(std::string page) : page_(std::make_shared<const std::string>(std::move(page))) {}

LivePage::~LivePage() {
  {
    const MutexLock lock(mutex_);
    is_closed_ = true;
  }
  changed_.notify_all();
  listener_.reset();
}

absl::StatusOr<std::unique_ptr<LivePage>> LivePage::start(const AgentAddress& address) {
  RETURN_IF_ERROR(page_bundle().status());
  std::string html = page::server_page();
  const std::size_t mark = html.find(kDataMark);
  if (mark == std::string::npos) return absl::InternalError("the bundled page has no place for data");
  html.replace(mark, kDataMark.size(), kLiveMark);
  std::unique_ptr<LivePage> page(new LivePage(std::move(html)));
  ASSIGN_OR_RETURN(page->listener_, bench::HttpListener::start(address.host, address.port,
                                                               [page = page.get()](const bench::HttpRequest& request) {
                                                                 return page->answer(request);
                                                               }));
  return page;
}

void LivePage::show(LiveFrame frame) {
  auto newest = std::make_shared<const LiveFrame>(std::move(frame));
  {
    const MutexLock lock(mutex_);
    newest_.swap(newest);
    ++sequence_;
  }
  changed_.notify_all();
}  // The frame before is freed here, unless it is being written.

bench::HttpReply LivePage::answer(const bench::HttpRequest& request) {
  if (request.path == "/live") return answer_live(after_of(request.query));
  bench::HttpReply reply;
  if (request.path == "/") {
    reply.content_type = "text/html; charset=utf-8";
    reply.policy = page::server_page_policy();
    reply.body = page_;
    return reply;
  }
  reply.status = "404 Not Found";
  return reply;
}

bench::HttpReply LivePage::answer_live(std::uint64_t after) {
  {
    const MutexLock lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + kPatience;
    // A number from before segctl was started again is greater than any of now.
    while (!is_closed_ && (sequence_ == 0 || sequence_ == after)) {
      if (!changed_.wait_until(mutex_, until)) break;
    }
    if (is_closed_ || sequence_ == 0 || sequence_ == after) {
      bench::HttpReply reply;
      reply.status = is_closed_ ? "503 Service Unavailable" : "204 No Content";
      return reply;
    }
  }
  return json_reply(written());
}

LivePage::Text LivePage::written() {
  const MutexLock writing(writing_);
  std::shared_ptr<const LiveFrame> frame;
  std::uint64_t sequence = 0;
  {
    const MutexLock lock(mutex_);
    frame = newest_;
    sequence = sequence_;
  }
  if (written_sequence_ != sequence) {
    written_ = std::make_shared<const std::string>(text_of(*frame, sequence));
    written_sequence_ = sequence;
  }
  return written_;
}

}  // namespace segserve::segctl
