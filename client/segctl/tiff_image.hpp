// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

// TIFF images, of which the first one of a file counts. libtiff has a history of faults with hostile bytes. So it reads
// the files of its own user only, and makes images of them that servers read.
namespace segserve::segctl {

/// Whether the bytes begin as a TIFF or BigTIFF file.
bool is_tiff(std::string_view bytes);

/// Turns a depth image into PGM, if it has unsigned integers of 16 bits, or into PFM, if it has floats of 32 or 64
/// bits. INVALID_ARGUMENT for other kinds of pixels, broken files, and more than 64 million pixels.
absl::StatusOr<std::string> depth_from_tiff(std::string_view bytes);

/// Turns any image that libtiff can show into PPM. INVALID_ARGUMENT for others, and as above.
absl::StatusOr<std::string> color_from_tiff(std::string_view bytes);

}  // namespace segserve::segctl
