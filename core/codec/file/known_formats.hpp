// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace segserve::codec {

/// Names the format of a file that is neither PCD nor PLY, and says what to do with it. nullopt for unknown bytes.
std::optional<std::string> advice_on_format(std::string_view file);

}  // namespace segserve::codec
