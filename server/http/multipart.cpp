// SPDX-License-Identifier: Apache-2.0
#include "server/http/multipart.hpp"

#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr std::size_t kMostParts = 16, kMostPartHeaderBytes = 4096, kMostBoundaryBytes = 70;
constexpr std::string_view kLineEnd = "\r\n", kHeaderEnd = "\r\n\r\n";

absl::Status broken(std::string_view what) { return absl::InvalidArgumentError(fmt::format("the form {}", what)); }

/// The value of a parameter such as boundary=X or name="X" in a header.
std::optional<std::string> parameter(std::string_view header, std::string_view name) {
  while (true) {
    const std::size_t begin = header.find(';');
    if (begin == std::string_view::npos) return std::nullopt;
    header.remove_prefix(begin + 1);
    while (header.starts_with(' ')) header.remove_prefix(1);
    if (header.size() <= name.size() || header[name.size()] != '=' ||
        !absl::EqualsIgnoreCase({header.data(), name.size()}, {name.data(), name.size()})) {
      continue;
    }
    header.remove_prefix(name.size() + 1);
    const bool is_quoted = header.starts_with('"');
    if (is_quoted) header.remove_prefix(1);
    const std::size_t end = header.find_first_of(is_quoted ? "\"" : "; ");
    if (is_quoted && end == std::string_view::npos) return std::nullopt;
    return std::string(header.substr(0, end));
  }
}

/// The name of a part, from its headers.
std::optional<std::string> name_of(std::string_view headers) {
  constexpr std::string_view kDisposition = "content-disposition:";
  while (!headers.empty()) {
    const std::string_view line = headers.substr(0, headers.find(kLineEnd));
    headers.remove_prefix(std::min(headers.size(), line.size() + kLineEnd.size()));
    if (absl::StartsWithIgnoreCase({line.data(), line.size()}, {kDisposition.data(), kDisposition.size()})) {
      return parameter(line, "name");
    }
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<std::vector<FormPart>> parse_form(std::string_view content_type, std::string_view body) {
  const auto boundary = parameter(content_type, "boundary");
  if (!boundary || boundary->empty() || boundary->size() > kMostBoundaryBytes) {
    return broken("has no boundary, or one of more than 70 bytes");
  }
  const std::string first = "--" + *boundary, delimiter = "\r\n--" + *boundary;
  if (!body.starts_with(first)) return broken("does not begin with its boundary");
  body.remove_prefix(first.size());
  std::vector<FormPart> parts;
  while (!body.starts_with("--")) {
    if (!body.starts_with(kLineEnd)) return broken("has a boundary that is not the end of a line");
    if (parts.size() == kMostParts) return broken(fmt::format("has more than {} parts", kMostParts));
    const std::size_t header_end = body.substr(0, kMostPartHeaderBytes).find(kHeaderEnd);
    if (header_end == std::string_view::npos) return broken("has a part without an end of its headers");
    auto name = name_of(body.substr(kLineEnd.size(), header_end));
    if (!name) return broken("has a part without a name");
    body.remove_prefix(header_end + kHeaderEnd.size());
    const std::size_t end = body.find(delimiter);
    if (end == std::string_view::npos) return broken("ends within a part");
    parts.push_back({*std::move(name), body.substr(0, end)});
    body.remove_prefix(end + delimiter.size());
  }
  return parts;
}

}  // namespace segserve::server
