// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/server_directory.hpp"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Answer = std::vector<HostAddress>;

HostAddress v4(std::string text) { return {HostAddress::Family::kIpv4, std::move(text)}; }
HostAddress v6(std::string text) { return {HostAddress::Family::kIpv6, std::move(text)}; }

std::vector<std::string> targets(const ServerDirectory& directory) {
  std::vector<std::string> targets;
  for (const Server& server : directory.list().servers) targets.push_back(server.target);
  return targets;
}

TEST(ServerDirectory, AddressesAreServersAtOnceAndNamesLater) {
  ServerDirectory directory({"10.0.0.1:7", "robots:8"}, true);
  EXPECT_THAT(targets(directory), ElementsAre("10.0.0.1:7"));
  ASSERT_EQ(directory.names().size(), 1U);
  EXPECT_TRUE(directory.update(0, Answer{v4("10.0.0.3"), v4("10.0.0.2"), v4("10.0.0.3")}));
  EXPECT_THAT(targets(directory), ElementsAre("10.0.0.1:7", "ipv4:10.0.0.2:8", "ipv4:10.0.0.3:8"));
  const Server& server = directory.list().servers[1];
  EXPECT_EQ(server.authority, "robots:8") << "TLS verifies the name";
  EXPECT_EQ(server.address, "10.0.0.2:8");
}

TEST(ServerDirectory, ServersThatStayKeepTheirId) {
  ServerDirectory directory({"robots:8"}, true);
  directory.update(0, Answer{v4("10.0.0.1"), v4("10.0.0.2")});
  const ServerId second = directory.list().servers[1].id;
  EXPECT_FALSE(directory.update(0, Answer{v4("10.0.0.2"), v4("10.0.0.1")})) << "the order has no meaning";
  EXPECT_TRUE(directory.update(0, Answer{v4("10.0.0.2"), v4("10.0.0.3")}));
  ASSERT_EQ(directory.list().servers.size(), 2U);
  EXPECT_EQ(directory.list().servers[0].id, second);
  EXPECT_TRUE(directory.update(0, Answer{v4("10.0.0.1"), v4("10.0.0.2")}));
  EXPECT_GT(directory.list().servers[0].id, second + 1) << "no id is used twice";
}

TEST(ServerDirectory, AFailedLookupTakesNoServerAway) {
  ServerDirectory directory({"robots:8"}, true);
  EXPECT_TRUE(directory.list().trouble.ok()) << "it is being looked up";
  EXPECT_TRUE(directory.update(0, absl::UnavailableError("Name or service not known")));
  EXPECT_THAT(std::string(directory.list().trouble.message()), HasSubstr("robots:8 is not known: Name or service"));
  EXPECT_FALSE(directory.update(0, absl::UnavailableError("Name or service not known"))) << "that is no news";
  EXPECT_TRUE(directory.update(0, Answer{v4("10.0.0.1")}));
  EXPECT_TRUE(directory.list().trouble.ok());
  EXPECT_FALSE(directory.update(0, absl::UnavailableError("Temporary failure")));
  EXPECT_FALSE(directory.update(0, Answer{}));
  EXPECT_THAT(targets(directory), ElementsAre("ipv4:10.0.0.1:8"));
  EXPECT_TRUE(directory.list().trouble.ok());
}

TEST(ServerDirectory, AServerWithAnAddressOfEachFamilyIsOne) {
  ServerDirectory directory({"robot:8"}, true);
  directory.update(0, Answer{v6("fe80::1%eth0"), v4("10.0.0.1")});
  EXPECT_THAT(targets(directory), ElementsAre("dns:///robot:8"));
}

TEST(ServerDirectory, OfTwoFamiliesTheFirstOneCounts) {
  ServerDirectory directory({"robots:8"}, true);
  directory.update(0, Answer{v6("fd::1"), v6("fd::2"), v4("10.0.0.1"), v4("10.0.0.2")});
  EXPECT_THAT(targets(directory), ElementsAre("ipv6:[fd::1]:8", "ipv6:[fd::2]:8"));
  directory.update(0, Answer{v4("10.0.0.1"), v4("10.0.0.2"), v6("fd::1")});
  EXPECT_THAT(targets(directory), ElementsAre("ipv4:10.0.0.1:8", "ipv4:10.0.0.2:8"));
  directory.update(0, Answer{v6("fe80::1%eth0")});
  EXPECT_THAT(targets(directory), ElementsAre("ipv6:[fe80::1%25eth0]:8"));
}

TEST(ServerDirectory, LeavesNamesToGrpcIfToldTo) {
  const ServerDirectory directory({"robots:8"}, false);
  EXPECT_THAT(directory.names(), IsEmpty());
  EXPECT_THAT(targets(directory), ElementsAre("robots:8"));
}

}  // namespace
}  // namespace segserve::client
