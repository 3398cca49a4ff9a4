// SPDX-License-Identifier: Apache-2.0
#include "server/listener/listener_watch.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <future>
#include <string>

#include "gtest/gtest.h"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/listener_probe.hpp"
#include "test/temporary_path.hpp"

namespace segserve::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A socket that listens on a free port of the loopback and answers nothing by itself.
class DeafListener {
 public:
  DeafListener() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(listen(socket_, 8), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length), 0);
    port_ = ntohs(address.sin_port);
  }
  ~DeafListener() { close(socket_); }
  DeafListener(const DeafListener&) = delete;
  DeafListener& operator=(const DeafListener&) = delete;

  int port() const { return port_; }
  bool has_client(milliseconds time) const {
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    return poll(&waiting, 1, static_cast<int>(time.count())) == 1;
  }
  /// Takes the next connection, and says something on it.
  void answer() const {
    const int connection = accept(socket_, nullptr, nullptr);
    EXPECT_EQ(send(connection, "x", 1, 0), 1);
    close(connection);
  }

 private:
  int socket_;
  int port_ = 0;
};

/// As long as it lives, this process can open no file.
class ShortageOfDescriptors {
 public:
  ShortageOfDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit none{.rlim_cur = 0, .rlim_max = before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  }
  ~ShortageOfDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
  ShortageOfDescriptors(const ShortageOfDescriptors&) = delete;
  ShortageOfDescriptors& operator=(const ShortageOfDescriptors&) = delete;

 private:
  rlimit before_{};
};

const ListenAddress kLoopback{"127.0.0.1", "0", false};

TEST(ListenerProbe, TellsSilenceFromAnAnswerAndFromNobody) {
  int free_port = 0;
  {
    const DeafListener listener;
    free_port = listener.port();
    EXPECT_EQ(ListenerProbe(kLoopback, listener.port()).look(milliseconds(100)), Listener::kSilent);
  }
  EXPECT_EQ(ListenerProbe(kLoopback, free_port).look(milliseconds(100)), Listener::kNone);
  const DeafListener listener;
  auto answered = std::async(std::launch::async, [&] { listener.answer(); });
  EXPECT_EQ(ListenerProbe(kLoopback, listener.port()).look(seconds(10)), Listener::kAnswers);
  answered.get();
}

TEST(ListenerProbe, FindsWhoServesOnAUnixSocket) {
  const std::string path = test::temporary_path("probe.sock");
  std::remove(path.c_str());
  const ListenAddress address{path, "", true};
  EXPECT_EQ(ListenerProbe(address, 0).look(milliseconds(100)), Listener::kNone) << "there is no such file";
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof(name.sun_path));
  std::memcpy(name.sun_path, path.c_str(), path.size());
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&name), sizeof(name)), 0);
  ASSERT_EQ(listen(listener, 8), 0);
  EXPECT_EQ(ListenerProbe(address, 0).look(milliseconds(100)), Listener::kSilent);
  close(listener);
  EXPECT_EQ(ListenerProbe(address, 0).look(milliseconds(100)), Listener::kNone) << "the file is a leftover";
  std::remove(path.c_str());
}

TEST(ListenerWatch, ReportsAListenerThatTakesConnectionsAndSaysNothing) {
  const DeafListener listener;
  std::promise<void> deaf;
  const ListenerWatch watch({{kLoopback, listener.port(), nullptr}}, milliseconds(20), [&deaf] { deaf.set_value(); });
  EXPECT_EQ(deaf.get_future().wait_for(seconds(30)), std::future_status::ready);
}

TEST(ListenerWatch, OneAnswerOutOfThreeIsEnough) {
  const DeafListener listener;
  std::promise<void> deaf;
  auto reported = deaf.get_future();
  const ListenerWatch watch({{kLoopback, listener.port(), nullptr}}, milliseconds(200), [&deaf] { deaf.set_value(); });
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(reported.wait_for(milliseconds(50)), std::future_status::timeout);
    listener.answer();
  }
}

TEST(ListenerWatch, AListenerThatAcceptsConnectionsIsNotDeaf) {
  const DeafListener listener;
  std::promise<void> deaf;
  auto reported = deaf.get_future();
  std::atomic<std::uint64_t> accepted{0};
  std::atomic<bool> accepts{true};
  const ListenerWatch watch({{kLoopback, listener.port(), [&] { return accepts ? ++accepted : accepted.load(); }}},
                            milliseconds(20), [&deaf] { deaf.set_value(); });
  EXPECT_EQ(reported.wait_for(seconds(1)), std::future_status::timeout);
  accepts = false;
  EXPECT_EQ(reported.wait_for(seconds(30)), std::future_status::ready);
}

TEST(ListenerWatch, EveryListenerMustAnswer) {
  const DeafListener first, second;
  std::promise<void> deaf;
  auto reported = deaf.get_future();
  const ListenerWatch watch({{kLoopback, first.port(), nullptr}, {kLoopback, second.port(), nullptr}},
                            milliseconds(100), [&deaf] { deaf.set_value(); });
  const auto end = std::chrono::steady_clock::now() + seconds(30);
  while (reported.wait_for(milliseconds(0)) != std::future_status::ready && std::chrono::steady_clock::now() < end) {
    if (first.has_client(milliseconds(10))) first.answer();
  }
  EXPECT_EQ(reported.wait_for(milliseconds(0)), std::future_status::ready);
}

TEST(ListenerWatch, NoDescriptorForAProbeIsNoAnswer) {
  const DeafListener listener;
  const ListenerProbe probe({"localhost", "0", false}, listener.port());
  ShortageOfDescriptors shortage;
  EXPECT_EQ(probe.look(milliseconds(100)), Listener::kNoDescriptors);
}

TEST(FileDescriptors, AreCountedAndTheirLimitIsRaised) {
  raise_file_descriptor_limit();
  const FileDescriptors before = file_descriptors();
  const DeafListener listener;
  EXPECT_EQ(file_descriptors().open, before.open + 1);
  EXPECT_GT(before.limit, before.open);
}

}  // namespace
}  // namespace segserve::server
