// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace segserve {

/// The least number of letters that must be inserted, removed, replaced, or swapped with the next one to make `b` of
/// `a`, where no letter is changed twice (optimal string alignment distance).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name that somebody may have meant who typed `typed`: the one of least edit distance, if that is at most a third
/// of the letters typed and at least 1, or else the first that begins with at least three typed letters. Leading dashes
/// do not count.
std::optional<std::string> closest_name(std::string_view typed, std::span<const std::string> names);

}  // namespace segserve
