// SPDX-License-Identifier: Apache-2.0
#include "server/listener/listener_watch.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <future>
#include <string>

#include "gtest/gtest.h"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/listener_probe.hpp"

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

const ListenAddress kLoopback{"127.0.0.1", "0", false};

TEST(ListenerProbe, TellsSilenceFromAnAnswerAndFromNobody) {
  int free_port = 0;
  {
    const DeafListener listener;
    free_port = listener.port();
    EXPECT_EQ(probe_listener(kLoopback, listener.port(), milliseconds(100)), Listener::kSilent);
  }
  EXPECT_EQ(probe_listener(kLoopback, free_port, milliseconds(100)), Listener::kNone);
  const DeafListener listener;
  auto answered = std::async(std::launch::async, [&] { listener.answer(); });
  EXPECT_EQ(probe_listener(kLoopback, listener.port(), seconds(10)), Listener::kAnswers);
  answered.get();
}

TEST(ListenerProbe, FindsWhoServesOnAUnixSocket) {
  const std::string path = testing::TempDir() + "listener_probe.sock";
  std::remove(path.c_str());
  const ListenAddress address{path, "", true};
  EXPECT_EQ(probe_listener(address, 0, milliseconds(100)), Listener::kNone) << "there is no such file";
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  ASSERT_LT(path.size(), sizeof(name.sun_path));
  std::memcpy(name.sun_path, path.c_str(), path.size());
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&name), sizeof(name)), 0);
  ASSERT_EQ(listen(listener, 8), 0);
  EXPECT_EQ(probe_listener(address, 0, milliseconds(100)), Listener::kSilent);
  close(listener);
  EXPECT_EQ(probe_listener(address, 0, milliseconds(100)), Listener::kNone) << "the file is a leftover";
  std::remove(path.c_str());
}

TEST(ListenerWatch, ReportsAListenerThatTakesConnectionsAndSaysNothing) {
  const DeafListener listener;
  std::promise<void> deaf;
  const ListenerWatch watch(kLoopback, listener.port(), milliseconds(20), [&deaf] { deaf.set_value(); });
  EXPECT_EQ(deaf.get_future().wait_for(seconds(30)), std::future_status::ready);
}

TEST(ListenerWatch, OneAnswerOutOfThreeIsEnough) {
  const DeafListener listener;
  std::promise<void> deaf;
  auto reported = deaf.get_future();
  const ListenerWatch watch(kLoopback, listener.port(), milliseconds(200), [&deaf] { deaf.set_value(); });
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(reported.wait_for(milliseconds(50)), std::future_status::timeout);
    listener.answer();
  }
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
