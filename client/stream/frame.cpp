// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/frame.hpp"

namespace segserve::client {

const char* name(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kResult:
      return "RESULT";
    case OutcomeKind::kDropped:
      return "DROPPED";
    case OutcomeKind::kExpired:
      return "EXPIRED";
    case OutcomeKind::kCancelled:
      return "CANCELLED";
    case OutcomeKind::kFailed:
      return "FAILED";
  }
  return "?";
}

}  // namespace segserve::client
