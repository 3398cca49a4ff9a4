#include "server/draining.hpp"

#include <chrono>

#include "proto/wire/status_message.hpp"

namespace segserve::server {

absl::Status draining() {
  constexpr std::chrono::milliseconds kRetryElsewhere{500};
  return wire::with_details(absl::UnavailableError("the server is about to stop; try again with another replica"),
                            {.reason = v1::ERROR_REASON_DRAINING, .retry_delay = kRetryElsewhere});
}

}  // namespace segserve::server
