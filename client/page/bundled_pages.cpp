// SPDX-License-Identifier: Apache-2.0
#include "client/page/bundled_pages.hpp"

#include "absl/strings/str_replace.h"

namespace segserve::page {
namespace {

/// A page of segctl asks nobody, and that of a server asks it alone.
constexpr const char* kAsksNobody = "connect-src 'none'";
constexpr const char* kAsksItsServer = "connect-src 'self'";

/// The policy that stands in the head of a page.
std::string_view policy_of(std::string_view page) {
  constexpr std::string_view kBegin = R"(http-equiv="Content-Security-Policy" content=")";
  const std::size_t begin = page.find(kBegin);
  if (begin == std::string_view::npos) return {};
  page.remove_prefix(begin + kBegin.size());
  return page.substr(0, page.find('"'));
}

}  // namespace

#ifdef SEGSERVE_WITH_PAGE
extern const std::string_view kViewPage, kBenchPage;  // They stand in sources that build.js makes.
#else
constexpr std::string_view kViewPage, kBenchPage;
#endif

std::string_view view_page() { return kViewPage; }
std::string_view bench_page() { return kBenchPage; }

const std::string& server_page() {
  static const std::string kPage =
      absl::StrReplaceAll({kViewPage.data(), kViewPage.size()}, {{kAsksNobody, kAsksItsServer}});
  return kPage;
}

const std::string& server_page_policy() {
  // Only a header can forbid frames.
  static const std::string kPolicy = std::string(policy_of(server_page())) + "; frame-ancestors 'none'";
  return kPolicy;
}

}  // namespace segserve::page
