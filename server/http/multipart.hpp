// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::server {

/// A part of a body of the type multipart/form-data.
struct FormPart {
  std::string name;
  std::string_view content;  ///< lies in the body
};

/// The parts of a form (RFC 7578), of which there are at most 16. `content_type` is that of the request. The body must
/// outlive the parts. INVALID_ARGUMENT says what is wrong with the form.
absl::StatusOr<std::vector<FormPart>> parse_form(std::string_view content_type, std::string_view body);

}  // namespace segserve::server
