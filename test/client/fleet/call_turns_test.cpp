// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/call_turns.hpp"

#include <set>

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class CallTurnsTest : public testing::Test {
 protected:
  CallTurnsTest() { book_.set_servers(servers_); }
  ServerId begin() { return turns_.begin(servers_, book_, now_).server.id; }
  void end(ServerId server, bool reached = true) { turns_.end(server, reached, now_); }

  Time now_{std::chrono::hours(1)};
  const std::vector<Server> servers_{{.id = 1}, {.id = 2}, {.id = 3}};
  ServerBook book_{RetryOptions{}, 1};
  CallTurns turns_{1};
};

TEST_F(CallTurnsTest, ServersHaveTheirTurn) {
  std::set<ServerId> used;
  for (int i = 0; i < 3; ++i) {
    const ServerId server = begin();
    used.insert(server);
    end(server);
  }
  EXPECT_EQ(used.size(), 3U);
}

TEST_F(CallTurnsTest, TheServerWithTheFewestCallsIsNext) {
  const ServerId first = begin(), second = begin(), third = begin();
  end(second);
  EXPECT_EQ(begin(), second);
  end(third);
  end(first);
  begin();
  begin();
  end(first);
  EXPECT_EQ(begin(), first);
}

TEST_F(CallTurnsTest, ServersThatFailedOtherCallsAreLastForAWhile) {
  const ServerId failed = begin();
  end(failed, false);
  for (int i = 0; i < 4; ++i) EXPECT_NE(begin(), failed);
  now_ += seconds(5);
  EXPECT_EQ(begin(), failed);
}

TEST_F(CallTurnsTest, ACallObeysItsOwnBook) {
  for (const ServerId server : {1, 2, 3}) book_.failed(server, now_, milliseconds(1000 * server));
  const CallTurns::Choice choice = turns_.begin(servers_, book_, now_);
  EXPECT_EQ(choice.server.id, 1U);
  EXPECT_EQ(choice.not_before, now_ + milliseconds(1000));
  EXPECT_TRUE(book_.nobody_in_reach());
  book_.reached(3);
  EXPECT_FALSE(book_.nobody_in_reach());
  EXPECT_EQ(begin(), 3U);
}

TEST(ServerBook, KeepsWhatItKnowsOfServersThatStay) {
  const Time now{std::chrono::hours(1)};
  ServerBook book(RetryOptions{}, 1);
  EXPECT_FALSE(book.nobody_in_reach()) << "no server is known yet";
  book.set_servers({{.id = 1}, {.id = 2}});
  book.failed(1, now, {});
  book.failed(7, now, {});
  book.set_servers({{.id = 1}, {.id = 3}});
  EXPECT_TRUE(book.is_failing(1));
  EXPECT_GT(book.not_before(1), now);
  EXPECT_FALSE(book.is_failing(3));
  book.set_servers({{.id = 1}});
  EXPECT_TRUE(book.nobody_in_reach());
}

}  // namespace
}  // namespace segserve::client
