// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// The pages that build.js bundles, for segctl and for the server. All are empty if this program was built without npm.
namespace segserve::page {

/// The page of `segctl view`, and that of `segctl bench`, without data.
std::string_view view_page();
std::string_view bench_page();

/// The page of `segctl view` as a server gives it, which segments the files that are dropped on it by asking that
/// server, and its Content-Security-Policy.
const std::string& server_page();
const std::string& server_page_policy();

}  // namespace segserve::page
