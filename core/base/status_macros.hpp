// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Macros that return errors to the caller. Only private sources include them, so that users never see their names.

/// Leaves the function with the status of `expression` unless that is OK.
#define RETURN_IF_ERROR(expression)                                                        \
  do {                                                                                     \
    if (absl::Status status_or_ok = (expression); !status_or_ok.ok()) return status_or_ok; \
  } while (false)

/// Declares or assigns `target` from the StatusOr `expression`, or leaves the function with its status. The
/// target must not contain a comma.
#define ASSIGN_OR_RETURN(target, expression) \
  SEGSERVE_ASSIGN_OR_RETURN_IMPL(SEGSERVE_CONCATENATE(status_or_, __LINE__), target, expression)

#define SEGSERVE_CONCATENATE_IMPL(a, b) a##b
#define SEGSERVE_CONCATENATE(a, b) SEGSERVE_CONCATENATE_IMPL(a, b)
// NOLINTBEGIN(bugprone-macro-parentheses): a declaration in parentheses is none.
#define SEGSERVE_ASSIGN_OR_RETURN_IMPL(result, target, expression) \
  auto result = (expression);                                      \
  if (!result.ok()) return std::move(result).status();             \
  target = *std::move(result)
// NOLINTEND(bugprone-macro-parentheses)
