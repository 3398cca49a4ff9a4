// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "nlohmann/json_fwd.hpp"

namespace segserve::view_page {

/// Puts data into a page that client/page/build.js bundled: the JSON as an element that no browser runs, and behind it
/// `elements`. Texts in the JSON cannot end the element or begin another one, and bytes that are not UTF-8 are
/// replaced. INTERNAL if `bundle` is no such page.
absl::StatusOr<std::string> put_data(std::string_view bundle, const nlohmann::ordered_json& json,
                                     std::string_view elements = {});

}  // namespace segserve::view_page
