// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_html.hpp"

#include <utility>

#include "client/segctl/output_kind.hpp"
#include "client/segctl/page_bundle.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/view_page/page_data.hpp"
#include "nlohmann/json.hpp"

namespace segserve::segctl {

void BenchHtmlFlag::add_to(CLI::App& app) {
  app.add_option("--html", path_, "write a page with charts, which needs no network; - is standard output")
      ->type_name("FILE")
      ->group("Output");
}

absl::Status BenchHtmlFlag::announce(StagedOutput& output) const {
  if (!given()) return absl::OkStatus();
  RETURN_IF_ERROR(bench_page_bundle().status());
  RETURN_IF_ERROR(output.announce(path_));
  return check_output_name("--html", path_, OutputKind::kPage);
}

absl::Status BenchHtmlFlag::add(StagedOutput& output, const nlohmann::ordered_json& run) const {
  if (!given()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string_view bundle, bench_page_bundle());
  ASSIGN_OR_RETURN(std::string page, view_page::put_data(bundle, run));
  output.add(path_, std::move(page));
  return absl::OkStatus();
}

}  // namespace segserve::segctl
