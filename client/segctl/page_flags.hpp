// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/staged_output.hpp"
#include "core/lab/eval/report_page.hpp"

namespace segserve::segctl {

/// The flags --markdown, --html and --worst of segctl eval: pages with the scores and with pictures of the worst
/// scenes. It must outlive the parsing of the command line.
class PageFlags {
 public:
  /// Each flag needs the flag `data`.
  void add_to(CLI::App& app, CLI::Option* data);

  /// The number of scenes that are shown as pictures: 0 if no page is asked for.
  std::size_t worst() const { return markdown_.empty() && html_.empty() ? 0 : worst_; }

  /// Announces the pages (StagedOutput::announce) and the folder for the pictures of Markdown.
  absl::Status announce(StagedOutput& output) const;

  /// Adds the pages that were asked for. The pictures of Markdown are files in a folder beside it. Without a folder, on
  /// standard output, they are left out. `peer` may be null.
  void add(StagedOutput& output, const eval::Report& report, const eval::Peer* peer,
           std::span<const eval::Thumbnails> worst) const;

 private:
  std::string picture_folder() const;

  std::string markdown_;
  std::string html_;
  std::size_t worst_ = 5;
  CLI::Option* worst_option_ = nullptr;
};

}  // namespace segserve::segctl
