// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace segserve::segctl {

/// The kinds of outputs that have one format each, whatever their names.
enum class OutputKind : std::uint8_t { kPicture, kPage, kMarkdown, kCsv, kJson, kResult, kHistogramLog };

/// INVALID_ARGUMENT, with the flag and the ends that names may have, if the name of an output ends as that of another
/// kind of file does. A name without an end, such as /dev/stdout, and "-" promise nothing. Pictures, pages and tables
/// are opened by their names, so that these must end as they should; of other kinds only the ends of known formats are
/// refused.
absl::Status check_output_name(std::string_view flag, const std::string& path, OutputKind kind);

}  // namespace segserve::segctl
