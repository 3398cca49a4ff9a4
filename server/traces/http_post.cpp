// SPDX-License-Identifier: Apache-2.0
#include "server/traces/http_post.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <new>

#include "fmt/format.h"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Milliseconds = std::chrono::milliseconds;

constexpr Milliseconds kLongestPoll{1000};

std::size_t take_body(const char* bytes, std::size_t /*one*/, std::size_t count, void* user) {
  std::string& body = *static_cast<std::string*>(user);
  body.append(bytes, std::min(count, HttpPost::kMostAnswerBytes - body.size()));
  return count;
}

/// Whether the URL means this machine, to which no proxy of the environment leads.
bool is_local(const std::string& url) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parsed(curl_url(), curl_url_cleanup);
  char* host = nullptr;
  if (!parsed || curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK ||
      curl_url_get(parsed.get(), CURLUPART_HOST, &host, 0) != CURLUE_OK) {
    return false;
  }
  const std::string name = host;
  curl_free(host);
  return name == "localhost" || name == "[::1]" || name.starts_with("127.");
}

}  // namespace

struct HttpPost::Handles {
  Handles() {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    easy = curl_easy_init();
    multi = curl_multi_init();
    if (easy == nullptr || multi == nullptr) throw std::bad_alloc();
  }
  ~Handles() {
    curl_multi_cleanup(multi);
    curl_easy_cleanup(easy);
    curl_slist_free_all(headers);
  }

  void add_header(const std::string& line) {
    curl_slist* longer = curl_slist_append(headers, line.c_str());
    if (longer == nullptr) throw std::bad_alloc();
    headers = longer;
  }

  CURL* easy = nullptr;
  CURLM* multi = nullptr;
  curl_slist* headers = nullptr;
  std::array<char, CURL_ERROR_SIZE> error{};
};

HttpPost::HttpPost(const std::string& url, const std::vector<std::pair<std::string, std::string>>& headers,
                   const std::string& ca_file)
    : handles_(std::make_unique<Handles>()) {
  handles_->add_header("Content-Type: application/json");
  handles_->add_header("Expect:");  // no round trip before a large body
  for (const auto& [name, value] : headers) handles_->add_header(fmt::format("{}: {}", name, value));
  CURL* easy = handles_->easy;
  curl_easy_setopt(easy, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);  // otherwise the end would wait for a name server
  curl_easy_setopt(easy, CURLOPT_POST, 1L);
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, handles_->headers);
  curl_easy_setopt(easy, CURLOPT_USERAGENT, fmt::format("OTel-OTLP-Exporter-segserve/{}", kVersion).c_str());
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, take_body);
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, handles_->error.data());
  if (!ca_file.empty()) curl_easy_setopt(easy, CURLOPT_CAINFO, ca_file.c_str());
  if (is_local(url)) curl_easy_setopt(easy, CURLOPT_NOPROXY, "*");
}

HttpPost::~HttpPost() = default;

void HttpPost::wake() { curl_multi_wakeup(handles_->multi); }

HttpAnswer HttpPost::post(const std::string& body, const std::function<Time()>& deadline) {
  CURL* easy = handles_->easy;
  CURLM* multi = handles_->multi;
  HttpAnswer answer;
  handles_->error.front() = '\0';
  curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
  curl_easy_setopt(easy, CURLOPT_POSTFIELDS, body.c_str());
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &answer.body);
  curl_multi_add_handle(multi, easy);
  CURLcode result = CURLE_OPERATION_TIMEDOUT;
  for (int running = 1; running > 0;) {
    curl_multi_perform(multi, &running);
    int left = 0;
    if (const CURLMsg* message = curl_multi_info_read(multi, &left)) result = message->data.result;
    const auto time_left = std::chrono::duration_cast<Milliseconds>(deadline() - std::chrono::steady_clock::now());
    if (time_left <= Milliseconds(0)) break;
    const auto wait = std::min(time_left, kLongestPoll);
    if (running > 0) curl_multi_poll(multi, nullptr, 0, static_cast<int>(wait.count()), nullptr);
  }
  curl_multi_remove_handle(multi, easy);
  if (result == CURLE_OK) {
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &answer.status);
    curl_off_t seconds = 0;
    curl_easy_getinfo(easy, CURLINFO_RETRY_AFTER, &seconds);
    constexpr curl_off_t kLongest = 86'400;  // the collector may say any number, which must fit into milliseconds
    if (seconds > 0) answer.retry_after = std::chrono::seconds(std::min(seconds, kLongest));
  } else {
    answer.error = handles_->error.front() != '\0' ? handles_->error.data() : curl_easy_strerror(result);
  }
  return answer;
}

}  // namespace segserve::server
