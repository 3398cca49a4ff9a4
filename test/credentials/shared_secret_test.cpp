// SPDX-License-Identifier: Apache-2.0
#include "credentials/shared_secret.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"
#include "test/temporary_path.hpp"

namespace segserve::credentials {
namespace {

TEST(SharedSecret, ProofIsTheHmacOfRfc4231) {
  EXPECT_EQ(proof_of("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

TEST(SharedSecret, OnlyItsOwnProofIsTaken) {
  const std::string proof = proof_of("secret", "challenge");
  EXPECT_TRUE(is_proof_of(proof, "secret", "challenge"));
  EXPECT_FALSE(is_proof_of(proof, "Secret", "challenge"));
  EXPECT_FALSE(is_proof_of(proof, "secret", "challenge2"));
  EXPECT_FALSE(is_proof_of("", "secret", "challenge"));
  EXPECT_FALSE(is_proof_of(proof.substr(1), "secret", "challenge"));
}

TEST(SharedSecret, IsReadFromAFile) {
  const std::string path = test::temporary_path("secret");
  std::ofstream(path) << " 0123456789abcdef\n";
  EXPECT_EQ(*read_shared_secret(path), "0123456789abcdef");
  for (const std::string& wrong : {std::string("0123456789abcde\n"), std::string(1025, 'x'), std::string(5000, 'x')}) {
    std::ofstream(path) << wrong;
    EXPECT_TRUE(absl::IsInvalidArgument(read_shared_secret(path).status())) << wrong;
  }
  std::filesystem::remove(path);
  EXPECT_TRUE(absl::IsNotFound(read_shared_secret(path).status()));
  EXPECT_TRUE(absl::IsNotFound(read_shared_secret("/dev/zero").status()));
}

}  // namespace
}  // namespace segserve::credentials
