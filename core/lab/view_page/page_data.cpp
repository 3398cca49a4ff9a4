// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/page_data.hpp"

#include "absl/strings/str_replace.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::view_page {
namespace {

using Json = nlohmann::ordered_json;

/// Where the data go in the bundled page.
constexpr std::string_view kDataMark = "<!--DATA-->";

/// JSON as the content of an element. Nothing in it can end the element or begin another one.
std::string inert_text(const Json& json) {
  return absl::StrReplaceAll(json.dump(-1, ' ', true, Json::error_handler_t::replace), {{"<", "\\u003c"}});
}

}  // namespace

absl::StatusOr<std::string> put_data(std::string_view bundle, const Json& json, std::string_view elements) {
  const std::size_t mark = bundle.find(kDataMark);
  if (mark == std::string_view::npos) return absl::InternalError("the bundled page has no place for data");
  std::string page(bundle.substr(0, mark));
  page += fmt::format("<script type=\"application/json\" id=\"page-data\">{}</script>\n", inert_text(json));
  page += elements;
  page += bundle.substr(mark + kDataMark.size());
  return page;
}

}  // namespace segserve::view_page
