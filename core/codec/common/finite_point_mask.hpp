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

// The finite points of a cloud, as indices and as a bitmap. Bit i % 8 (0 is the lowest) of byte i / 8 of the bitmap is
// 1 if point i is finite.
namespace segserve::codec {

/// The indices of the finite points in ascending order.
std::vector<std::uint32_t> finite_points(const CloudView& cloud);

/// Bytes of the bitmap of so many points.
constexpr std::size_t bitmap_bytes(std::size_t points) { return (points + 7) / 8; }

/// Sets the bits of the `finite` indices in `bitmap`, which has bitmap_bytes zeros.
void write_bitmap(std::span<const std::uint32_t> finite, char* bitmap);

/// The indices of the bits that are set, in ascending order. nullopt unless exactly `finite` bits are set, all of them
/// among the first `points`. Once `check` has stopped, the result has no meaning.
std::optional<std::vector<std::uint32_t>> read_bitmap(std::string_view bitmap, std::size_t points, std::size_t finite,
                                                      StopCheck& check);

/// A cloud of width * height points at NaN, all black if it has color.
Cloud make_nan_cloud(std::uint32_t width, std::uint32_t height, bool color, const View& view);

}  // namespace segserve::codec
