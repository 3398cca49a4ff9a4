// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/view_flag.hpp"

#include "fmt/format.h"
#include "proto/text/view_text.hpp"

namespace segserve::segctl {

absl::StatusOr<View> parse_view(std::string_view text) {
  if (const auto view = text::parse_view(text)) return *view;
  return absl::InvalidArgumentError(fmt::format("--view {}: must be {}", text, text::kViewRule));
}

}  // namespace segserve::segctl
