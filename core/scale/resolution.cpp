// SPDX-License-Identifier: Apache-2.0
#include "segserve/resolution.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace segserve {
namespace {

constexpr std::array<std::string_view, 6> kNames = {"given", "dense", "spacing", "noise", "extent", "sweep"};

}  // namespace

std::string_view name(ResolutionReason reason) { return kNames[static_cast<std::size_t>(reason)]; }

std::optional<ResolutionReason> resolution_reason(std::string_view name) {
  const auto* found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ResolutionReason>(found - kNames.begin());
}

}  // namespace segserve
