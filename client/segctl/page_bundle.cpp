// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/page_bundle.hpp"

#include "client/page/bundled_pages.hpp"

namespace segserve::segctl {
namespace {

absl::StatusOr<std::string_view> if_built(std::string_view page) {
  if (!page.empty()) return page;
  return absl::InvalidArgumentError(
      "this segctl was built without its pages; configure it where npm is installed and reaches its registry");
}

}  // namespace

absl::StatusOr<std::string_view> page_bundle() { return if_built(page::view_page()); }
absl::StatusOr<std::string_view> bench_page_bundle() { return if_built(page::bench_page()); }

}  // namespace segserve::segctl
