// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/decode_limits.hpp"

#include <fmt/format.h>

#include <sstream>

#include "absl/strings/cord.h"

namespace segserve::codec {
namespace {

/// The name under which a status carries "<limit> <actual> <allowed>".
constexpr const char* kPayload = "segserve/limit";

}  // namespace

absl::Status over_limit(std::string_view message, const LimitExcess& excess) {
  absl::Status status = absl::InvalidArgumentError(std::string(message));
  status.SetPayload(kPayload, absl::Cord(fmt::format("{} {} {}", excess.limit, excess.actual, excess.allowed)));
  return status;
}

std::optional<LimitExcess> limit_excess(const absl::Status& status) {
  const auto payload = status.GetPayload(kPayload);
  if (!payload) return std::nullopt;
  LimitExcess excess;
  std::istringstream(std::string(*payload)) >> excess.limit >> excess.actual >> excess.allowed;
  return excess;
}

}  // namespace segserve::codec
