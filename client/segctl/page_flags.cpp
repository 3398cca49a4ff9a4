// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/page_flags.hpp"

#include <filesystem>

#include "client/segctl/output_kind.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::segctl {

void PageFlags::add_to(CLI::App& app, CLI::Option* data) {
  app.add_option("--markdown", markdown_,
                 "write tables as Markdown, and the pictures into a folder named after it; - is standard output, "
                 "without pictures")
      ->type_name("FILE")
      ->needs(data)
      ->group("Output");
  app.add_option("--html", html_, "write tables and pictures as one HTML page; - is standard output")
      ->type_name("FILE")
      ->needs(data)
      ->group("Output");
  worst_option_ =
      app.add_option("--worst", worst_,
                     "number of scenes in pictures of --markdown and --html: those with the smallest WOv of objects");
  worst_option_->check(CLI::Range(0, 1000))->capture_default_str()->needs(data)->group("Output");
}

/// "report.md" has its pictures in "report_pictures".
std::string PageFlags::picture_folder() const {
  return std::filesystem::path(markdown_).replace_extension().string() + "_pictures";
}

absl::Status PageFlags::announce(StagedOutput& output) const {
  if (markdown_.empty() && html_.empty() && worst_option_->count() > 0) {
    return absl::InvalidArgumentError("--worst needs --markdown or --html");
  }
  if (!html_.empty()) {
    RETURN_IF_ERROR(output.announce(html_));
    RETURN_IF_ERROR(check_output_name("--html", html_, OutputKind::kPage));
  }
  if (markdown_.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(markdown_));
  RETURN_IF_ERROR(check_output_name("--markdown", markdown_, OutputKind::kMarkdown));
  return markdown_ == "-" || worst_ == 0 ? absl::OkStatus() : output.announce_folder(picture_folder());
}

void PageFlags::add(StagedOutput& output, const eval::Report& report, const eval::Peer* peer,
                    std::span<const eval::Thumbnails> worst) const {
  if (!html_.empty()) output.add(html_, eval::to_html(report, peer, worst));
  if (markdown_.empty()) return;
  if (markdown_ == "-") return output.add(markdown_, eval::to_markdown(report, peer, worst, ""));
  const std::filesystem::path folder = picture_folder();
  output.add(markdown_, eval::to_markdown(report, peer, worst, folder.filename().string()));
  for (std::size_t i = 0; i < worst.size(); ++i) {
    output.add((folder / eval::picture_name("truth", i)).string(), worst[i].truth);
    output.add((folder / eval::picture_name("segments", i)).string(), worst[i].segments);
  }
}

}  // namespace segserve::segctl
