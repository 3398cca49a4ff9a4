// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

// Limits of the headers of files. Headers that programs write are far below them. They bound the time and
// the memory of parsing a header, so that this need not look at a StopToken.
namespace segserve::codec {

/// The longest header, bytes.
inline constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 20U;
/// The most fields of a point in a PCD file, and the most elements and properties together in a PLY file.
inline constexpr std::size_t kMostHeaderFields = 4096;
/// The most numbers that the fields of a point have together. Descriptors of programs have up to a few thousand.
inline constexpr std::size_t kMostPointNumbers = std::size_t{1} << 16U;

/// The part of a file in which its header must be.
constexpr std::string_view header_part(std::string_view file) { return file.substr(0, kMostHeaderBytes); }

}  // namespace segserve::codec
