// SPDX-License-Identifier: Apache-2.0
#include "core/base/append_generated.hpp"

#include <cstdint>

#include "gmock/gmock.h"

namespace segserve::math {
namespace {

using testing::ElementsAre;

TEST(AppendGenerated, AppendsTheValuesInOrder) {
  std::vector<std::uint32_t> values{7};
  append_generated(values, 3, 6, [](std::size_t i) { return static_cast<std::uint32_t>(i * i); });
  EXPECT_THAT(values, ElementsAre(7, 9, 16, 25));
  append_generated(values, 6, 6, [](std::size_t) { return 1U; });
  EXPECT_EQ(values.size(), 4U);
}

TEST(AppendGenerated, AllocatesOnce) {
  std::vector<std::uint32_t> values;
  values.reserve(10);
  const std::uint32_t* const data = values.data();
  append_generated(values, 0, 4, [](std::size_t i) { return static_cast<std::uint32_t>(i); });
  append_generated(values, 4, 10, [](std::size_t i) { return static_cast<std::uint32_t>(i); });
  EXPECT_EQ(values.data(), data);
  EXPECT_EQ(values.back(), 9U);
}

}  // namespace
}  // namespace segserve::math
