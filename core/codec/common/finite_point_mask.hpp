// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

// Which points are finite, as indices and as a bitmap: bit i % 8 (0 is the lowest) of byte i / 8 is point i.
namespace segserve::codec {

/// The indices of the finite points, ascending.
std::vector<std::uint32_t> finite_points(const CloudView& cloud);

constexpr std::size_t bitmap_bytes(std::size_t points) { return (points + 7) / 8; }

/// `bitmap` has bitmap_bytes of zeros.
void write_bitmap(std::span<const std::uint32_t> finite, char* bitmap);

/// The inverse; nullopt unless exactly `finite` bits are set and none beyond the last of `points`. Without meaning once
/// `check` has stopped.
std::optional<std::vector<std::uint32_t>> read_bitmap(std::string_view bitmap, std::size_t points, std::size_t finite,
                                                      StopCheck& check);

/// A cloud of points that are not finite, black.
Cloud cloud_of_nothing(std::uint32_t width, std::uint32_t height, bool color, const View& view);

}  // namespace segserve::codec
