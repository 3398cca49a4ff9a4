// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/output_kind.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <vector>

#include "fmt/format.h"
#include "fmt/ranges.h"
#include "segserve/codec/file_format.hpp"

namespace segserve::segctl {
namespace {

struct KindNames {
  OutputKind kind;
  std::string_view format;             ///< "a picture is written as PNG"
  std::vector<std::string_view> ends;  ///< of names; empty: any that no other format has
};

const std::array<KindNames, 7>& kinds() {
  static const std::array<KindNames, 7> kKinds{{
      {OutputKind::kPicture, "a picture is written as PNG", {".png"}},
      {OutputKind::kPage, "a page is written as HTML", {".html", ".htm"}},
      {OutputKind::kMarkdown, "the tables are written as Markdown", {".md", ".markdown"}},
      {OutputKind::kCsv, "the timeline is written as CSV", {".csv", ".txt"}},
      {OutputKind::kJson, "the summary is written as JSON", {}},
      {OutputKind::kResult, "the result is written in a format of its own, for segctl cut", {}},
      {OutputKind::kHistogramLog, "the histograms are written as a log of HdrHistogram", {}},
  }};
  return kKinds;
}

constexpr std::array<std::string_view, 16> kForeign{".jpg", ".jpeg", ".gif",  ".bmp", ".webp", ".tif", ".tiff", ".svg",
                                                    ".pdf", ".ppm",  ".mcap", ".bag", ".zip",  ".xml", ".gz",   ".zst"};

/// The end of a file's name, in lower case; empty if it has none. Numbers such as the .5 of "cut-0.5" are none.
std::string end_of(const std::string& path) {
  std::string end = std::filesystem::path(path).extension().string();
  std::ranges::transform(end, end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::any_of(end, [](unsigned char c) { return std::isalpha(c) != 0; }) ? end : "";
}

/// Whether the end tells a format that is not `written`.
bool tells_other_format(const std::string& path, const std::string& end, OutputKind written) {
  const bool is_text = end == ".txt" || (end == ".json" && written == OutputKind::kJson);
  if (is_text) return false;
  const bool is_of_kind = std::ranges::any_of(
      kinds(), [&](const KindNames& names) { return std::ranges::find(names.ends, end) != names.ends.end(); });
  return is_of_kind || std::ranges::find(kForeign, end) != kForeign.end() || codec::file_format_of(path) ||
         codec::has_readable_extension(path);
}

}  // namespace

absl::Status check_output_name(std::string_view flag, const std::string& path, OutputKind kind) {
  const std::string end = end_of(path);
  if (end.empty()) return absl::OkStatus();
  const KindNames& written = *std::ranges::find(kinds(), kind, &KindNames::kind);
  if (!written.ends.empty()) {
    if (std::ranges::find(written.ends, end) != written.ends.end()) return absl::OkStatus();
    return absl::InvalidArgumentError(fmt::format("{} {}: {}, so that the name must end in {}", flag, path,
                                                  written.format, fmt::join(written.ends, " or ")));
  }
  if (!tells_other_format(path, end, kind)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} {}: {}, so that the name must not end in {}", flag, path, written.format, end));
}

}  // namespace segserve::segctl
