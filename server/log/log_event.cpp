// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_event.hpp"

#include <string>

#include "server/log/log_payload.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {

void log_event(spdlog::level::level_enum level, std::string_view message, std::span<const LogField> fields) noexcept {
  try {
    if (!spdlog::should_log(level)) return;
    spdlog::default_logger_raw()->log(fields_mark(), level, spdlog::string_view_t(pack_payload(message, fields)));
  } catch (...) {  // without memory for the line, there is none
  }
}

}  // namespace segserve::server
