// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "absl/status/status.h"
#include "fmt/format.h"

namespace segserve {

/// The status of the exception that is being handled; call it within `catch (...)`. `work` completes the sentence
/// "There is not enough memory to ...". Lack of memory is RESOURCE_EXHAUSTED, any other exception INTERNAL.
inline absl::Status exception_status(std::string_view work) {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(fmt::format("there is not enough memory to {}", work));
  } catch (const std::exception& error) {
    return absl::InternalError(fmt::format("an exception ended the attempt to {}: {}", work, error.what()));
  } catch (...) {
    return absl::InternalError(fmt::format("an exception of an unknown type ended the attempt to {}", work));
  }
}

}  // namespace segserve
