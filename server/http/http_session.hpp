// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/stream_traits.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "fmt/format.h"
#include "server/http/answer_text.hpp"
#include "server/http/http_connection.hpp"
#include "server/http/http_error.hpp"
#include "server/http/http_handler.hpp"
#include "server/http/http_server.hpp"

namespace segserve::server {

/// The steps of one connection, from its first request to its end. `Stream` is a boost::beast::tcp_stream or TLS over
/// one. All steps come in the order of one strand.
template <typename Stream>
class HttpSession {
  using Clock = std::chrono::steady_clock;
  using Error = boost::system::error_code;
  using Parser = boost::beast::http::request_parser<boost::beast::http::buffer_body>;
  template <typename Result>
  using Awaitable = boost::asio::awaitable<Result>;

 public:
  HttpSession(Stream& stream, HttpConnection& connection, std::string certificate_name, HttpHandler& handler,
              const HttpLimits& limits)
      : stream_(stream),
        connection_(connection),
        certificate_name_(std::move(certificate_name)),
        handler_(handler),
        limits_(limits) {}

  Awaitable<void> run() {
    auto time = limits_.header_time;
    while (co_await serve_one(time)) time = limits_.keep_alive_time;
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{32} << 10U;
  static constexpr std::uint64_t kFirstBytes = std::uint64_t{1} << 20U;
  static constexpr std::size_t kAnswerPiece = std::size_t{256} << 10U;
  static constexpr std::uint64_t kFreeSteps = 256, kBytesPerStep = 64;
  static constexpr std::chrono::milliseconds kTick{200};
  // A client that still sends when its request was refused may read the answer for so long.
  static constexpr std::chrono::milliseconds kLingerTime{2000};

  auto to(Error& error) { return boost::asio::redirect_error(boost::asio::use_awaitable, error); }
  boost::beast::tcp_stream& tcp() { return boost::beast::get_lowest_layer(stream_); }

  /// Serves one request; false if the connection ends.
  Awaitable<bool> serve_one(std::chrono::milliseconds time) {
    connection_.enter(HttpConnection::Phase::kIdle);
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(limits_.header_bytes));
    parser.body_limit(std::numeric_limits<std::uint64_t>::max());  // the handler bounds it
    Error error;
    tcp().expires_after(time);
    co_await boost::beast::http::async_read_header(stream_, buffer_, parser, to(error));
    if (error) {
      if (const auto answer = answer_of_bad_header(error)) {
        co_await write(*answer, false, true);
        co_await linger();
      }
      co_return false;
    }
    const auto& request = parser.get();
    const bool is_head = request.method() == boost::beast::http::verb::head;
    bool closes = !request.keep_alive();
    HttpAnswer answer;
    auto begun = has_host(request) ? handler_.begin(head_of(parser))
                                   : http_fault_answer(400, "a request of HTTP/1.1 has one header Host");
    if (auto* upload = std::get_if<std::shared_ptr<HttpUpload>>(&begun)) {
      answer = co_await take(parser, **upload);
    } else {
      answer = std::get<HttpAnswer>(std::move(begun));
    }
    // The unread rest of a body would be taken for the next request.
    closes = closes || answer.closes || !parser.is_done();
    connection_.enter(HttpConnection::Phase::kBusy);
    const bool was_read = co_await write(answer, is_head, closes);
    answer = {};  // its memory is free now
    if (was_read && !parser.is_done()) co_await linger();
    co_return was_read && !closes;
  }

  /// Whether the request says once for which host it is, as HTTP/1.1 wants.
  static bool has_host(const Parser::value_type& request) {
    const auto count = request.count(boost::beast::http::field::host);
    return count == 1 || (count == 0 && request.version() < 11);
  }

  HttpHead head_of(const Parser& parser) const {
    const auto& request = parser.get();
    const std::string target(request.target());
    const std::size_t question = std::min(target.find('?'), target.size());
    HttpHead head{.method = std::string(request.method_string()),
                  .path = target.substr(0, question),
                  .query = target.substr(std::min(question + 1, target.size()))};
    for (const auto& field : request) {
      std::string name(field.name_string());
      std::ranges::transform(name, name.begin(),
                             [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | ' ') : c; });
      head.headers.emplace_back(std::move(name), std::string(field.value()));
    }
    if (const auto length = parser.content_length()) head.body_bytes = *length;
    if (!parser.chunked() && !head.body_bytes) head.body_bytes = 0;
    head.peer = connection_.peer();
    head.certificate_name = certificate_name_;
    return head;
  }

  /// Reads the body and waits for the answer.
  Awaitable<HttpAnswer> take(Parser& parser, HttpUpload& upload) {
    connection_.enter(HttpConnection::Phase::kBusy);
    std::string body;
    std::uint64_t reserved = 0;  // bytes, for the body
    if (const auto length = parser.content_length()) {
      if (auto refusal = upload.announce(*length)) co_return *std::move(refusal);
      reserved = std::min<std::uint64_t>(*length, kFirstBytes);
      if (auto refusal = upload.reserve(reserved)) co_return *std::move(refusal);
      body.reserve(reserved);
    }
    if (!parser.is_done()) {
      if (auto ended = co_await read_body(parser, upload, reserved, body)) co_return *std::move(ended);
    }
    connection_.enter(HttpConnection::Phase::kBusy);
    co_return co_await wait_for_answer(upload, std::move(body));
  }

  /// Returns an answer if the body does not come to its end. So many bytes are `reserved` for it.
  Awaitable<std::optional<HttpAnswer>> read_body(Parser& parser, HttpUpload& upload, std::uint64_t reserved,
                                                 std::string& body) {
    Error error;
    if (boost::beast::iequals(parser.get()[boost::beast::http::field::expect], "100-continue")) {
      static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
      tcp().expires_after(limits_.header_time);
      co_await boost::asio::async_write(stream_, boost::asio::buffer(kContinue.data(), kContinue.size()), to(error));
      if (error) co_return HttpAnswer{.status = 400, .closes = true};
    }
    const Clock::time_point begin = Clock::now();
    std::vector<char> piece(kPiece);
    std::uint64_t steps = 0;
    while (!parser.is_done()) {
      parser.get().body().data = piece.data();
      parser.get().body().size = piece.size();
      tcp().expires_at(end_of_piece(begin, body.size(), parser.content_length().value_or(body.size())));
      co_await boost::beast::http::async_read_some(stream_, buffer_, parser, to(error));
      if (error == boost::beast::http::error::need_buffer) error = {};
      if (error == boost::beast::error::timeout) co_return upload.stalled();
      if (error) co_return upload.broken("the body of the request is broken, or ended too early");
      // Each chunk costs work, however few bytes it has.
      if (++steps > kFreeSteps + body.size() / kBytesPerStep) {
        co_return upload.broken("the body of the request comes in too many small chunks");
      }
      const std::size_t received = piece.size() - parser.get().body().size;
      const std::uint64_t most = parser.content_length().value_or(upload.most_bytes());
      const std::uint64_t needed = body.size() + received;
      if (needed > most || needed > reserved) {
        // A body beyond the limit asks for more than that, and is refused.
        const std::uint64_t wanted = std::max(needed, std::min<std::uint64_t>(most, 2 * needed));
        if (auto refusal = upload.reserve(wanted)) co_return *std::move(refusal);
        body.reserve(wanted);
        reserved = wanted;  // The capacity tells too much: a string has some bytes without any.
      }
      body.append(piece.data(), received);
    }
    co_return std::nullopt;
  }

  /// When the next part of a body must have come, of which `received` bytes have.
  Clock::time_point end_of_piece(Clock::time_point begin, std::uint64_t received, std::uint64_t all) const {
    const UploadPace pace = handler_.upload_pace();
    const double all_at_once = static_cast<double>(all) / std::chrono::duration<double>(pace.most_time).count();
    const double rate = std::max(static_cast<double>(pace.least_rate), all_at_once);
    const std::chrono::duration<double> time_of_received(static_cast<double>(received) / rate);
    const auto slowest = begin + pace.grace + std::chrono::duration_cast<Clock::duration>(time_of_received);
    return std::min(Clock::now() + pace.between_chunks, slowest);
  }

  Awaitable<HttpAnswer> wait_for_answer(HttpUpload& upload, std::string body) {
    struct Slot {
      explicit Slot(boost::asio::any_io_executor of) : executor(std::move(of)), changed(executor) {}
      boost::asio::any_io_executor executor;
      boost::asio::steady_timer changed;
      std::optional<HttpAnswer> answer;
    };
    const auto slot = std::make_shared<Slot>(stream_.get_executor());
    upload.finish(std::move(body), [slot](HttpAnswer answer) {
      boost::asio::post(slot->executor, [slot, answer = std::move(answer)]() mutable {
        slot->answer = std::move(answer);
        slot->changed.cancel();
      });
    });
    tcp().expires_never();
    bool is_cancelled = false;
    while (!slot->answer) {
      Error error;
      slot->changed.expires_after(kTick);
      co_await slot->changed.async_wait(to(error));
      if (slot->answer) break;
      upload.on_tick(Clock::now());
      if (is_cancelled || !is_gone()) continue;
      is_cancelled = true;
      upload.cancel();
    }
    co_return *std::move(slot->answer);
  }

  /// Whether the other end has closed the connection, or it was cut.
  bool is_gone() {
    if (!tcp().socket().is_open()) return true;
    tcp_info info{};
    socklen_t length = sizeof info;
    if (getsockopt(tcp().socket().native_handle(), IPPROTO_TCP, TCP_INFO, &info, &length) != 0) return true;
    return info.tcpi_state != TCP_ESTABLISHED;
  }

  /// Writes an answer, of which each part must be read in time. False if that failed.
  Awaitable<bool> write(const HttpAnswer& answer, bool without_body, bool closes) {
    const std::string header = answer_header(answer, closes);
    Error error;
    tcp().expires_after(handler_.answer_timeout());
    co_await boost::asio::async_write(stream_, boost::asio::buffer(header), to(error));
    for (std::size_t at = 0; !error && !without_body && at < answer.body.size(); at += kAnswerPiece) {
      const std::size_t size = std::min(kAnswerPiece, answer.body.size() - at);
      tcp().expires_after(handler_.answer_timeout());
      co_await boost::asio::async_write(stream_, boost::asio::buffer(answer.body.data() + at, size), to(error));
    }
    co_return !error;
  }

  /// Lets a client that still sends read the answer: a connection that is closed at once may take it away.
  Awaitable<void> linger() {
    Error error;
    tcp().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
    const auto end = Clock::now() + kLingerTime;
    std::vector<char> ignored(kPiece);
    while (!error && Clock::now() < end) {
      tcp().expires_at(end);
      co_await tcp().async_read_some(boost::asio::buffer(ignored), to(error));
    }
  }

  /// The answer to a header that cannot be read; nothing if the connection just ended.
  std::optional<HttpAnswer> answer_of_bad_header(const Error& error) const {
    namespace http = boost::beast::http;
    if (error == boost::beast::error::timeout || error == http::error::end_of_stream) return std::nullopt;
    if (error.category() != http::make_error_code(http::error::end_of_stream).category()) return std::nullopt;
    const bool is_large = error == http::error::header_limit || error == http::error::buffer_overflow;
    if (!is_large) return http_fault_answer(400, "the header of the request is wrong: " + error.message());
    return http_fault_answer(431,
                             fmt::format("the header of the request has more than {} bytes", limits_.header_bytes));
  }

  Stream& stream_;
  HttpConnection& connection_;
  const std::string certificate_name_;
  HttpHandler& handler_;
  const HttpLimits& limits_;
  boost::beast::flat_buffer buffer_{2 * kPiece};
};

}  // namespace segserve::server
