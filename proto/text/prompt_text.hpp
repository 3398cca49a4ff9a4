// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/prompts.hpp"

namespace segserve::text {

/// Reads a position "X,Y,Z" in the coordinates and unit of a file, or a pixel "U,V": column and row from the upper
/// left, from 0. INVALID_ARGUMENT for any other text.
absl::StatusOr<Prompt> parse_prompt(std::string_view text);

/// The text that parse_prompt reads as this prompt.
std::string prompt_text(const Prompt& prompt);

}  // namespace segserve::text
