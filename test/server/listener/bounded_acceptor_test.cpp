// SPDX-License-Identifier: Apache-2.0
#include "server/listener/bounded_acceptor.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "server/listener/socket.hpp"
#include "server/options/listen_address.hpp"
#include "server/scheduling/client_address.hpp"

namespace segserve::server {
namespace {

constexpr int kLongMs = 20'000, kShortMs = 300;

/// An acceptor on the loopback whose connections get a byte each as soon as they are given away.
class BoundedAcceptorTest : public testing::Test {
 protected:
  void start(std::size_t most) {
    auto listeners = listen_at_all({"127.0.0.1", "0", false});
    ASSERT_TRUE(listeners.ok());
    port = port_of(listeners->front());
    auto started = BoundedAcceptor::start(
        *std::move(listeners), most,
        [this](Socket connection) {
          EXPECT_EQ(send(connection.descriptor(), "x", 1, 0), 1);
          given.push_back(std::move(connection));
        },
        [this](const std::string& address) { return holds && address == "ipv4:" + held_address; });
    ASSERT_TRUE(started.ok());
    acceptor = *std::move(started);
  }
  void TearDown() override { acceptor->close(); }

  /// A connection from an address of the loopback.
  Socket connect_from(const char* host) const {
    Socket connection(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {inet_addr(host)}, .sin_zero = {}};
    EXPECT_EQ(bind(connection.descriptor(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    address.sin_port = htons(static_cast<in_port_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(connection.descriptor(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return connection;
  }
  static bool is_given(const Socket& connection, int time_ms) {
    pollfd waiting{.fd = connection.descriptor(), .events = POLLIN, .revents = 0};
    char byte = 0;
    return poll(&waiting, 1, time_ms) == 1 && recv(connection.descriptor(), &byte, 1, 0) == 1;
  }
  static bool has_ended(const Socket& connection, int time_ms) {
    pollfd waiting{.fd = connection.descriptor(), .events = POLLIN, .revents = 0};
    char byte = 0;
    return poll(&waiting, 1, time_ms) == 1 && recv(connection.descriptor(), &byte, 1, 0) <= 0;
  }
  static std::string name_of(const Socket& connection) {
    sockaddr_in address{};
    socklen_t length = sizeof address;
    getsockname(connection.descriptor(), reinterpret_cast<sockaddr*>(&address), &length);
    return connection_name("ipv4:127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  }

  int port = 0;
  std::atomic<bool> holds{false};
  const std::string held_address = "127.0.0.2";
  std::vector<Socket> given;  // the acceptor's thread
  std::unique_ptr<BoundedAcceptor> acceptor;
};

TEST_F(BoundedAcceptorTest, OneTooManyEndsTheOldestOfTheAddressThatHasMost) {
  start(3);
  const Socket honest = connect_from("127.0.0.1");
  ASSERT_TRUE(is_given(honest, kLongMs));
  std::vector<Socket> flood;
  for (int i = 0; i < 4; ++i) {
    flood.push_back(connect_from("127.0.0.2"));
    ASSERT_TRUE(is_given(flood.back(), kLongMs));
  }
  EXPECT_TRUE(has_ended(flood[0], kLongMs));
  EXPECT_TRUE(has_ended(flood[1], kLongMs));
  EXPECT_FALSE(has_ended(flood[2], 0));
  EXPECT_FALSE(has_ended(flood[3], 0));
  EXPECT_FALSE(has_ended(honest, kShortMs));
  EXPECT_EQ(acceptor->accepted(), 5);
}

TEST_F(BoundedAcceptorTest, EndsAConnectionByItsName) {
  start(3);
  const Socket one = connect_from("127.0.0.1"), other = connect_from("127.0.0.1");
  ASSERT_TRUE(is_given(one, kLongMs));
  ASSERT_TRUE(is_given(other, kLongMs));
  acceptor->end(name_of(one));
  acceptor->end("ipv4:127.0.0.1 0");
  EXPECT_TRUE(has_ended(one, kLongMs));
  EXPECT_FALSE(has_ended(other, kShortMs));
}

TEST_F(BoundedAcceptorTest, HoldsConnectionsOfAnAddress) {
  start(3);
  holds = true;
  const Socket held = connect_from("127.0.0.2");
  EXPECT_TRUE(is_given(connect_from("127.0.0.1"), kLongMs));
  EXPECT_FALSE(is_given(held, kShortMs));
  holds = false;
  EXPECT_TRUE(is_given(held, kLongMs));
}

}  // namespace
}  // namespace segserve::server
