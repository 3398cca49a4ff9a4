// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "core/lab/eval/report.hpp"
#include "core/lab/eval/thumbnails.hpp"

// Reports as pages that people read in a browser or a repository. `peer` may be null. Texts from outside, such as names
// of files, are escaped.
namespace segserve::eval {

/// An HTML page that needs no other file and no script. The thumbnails are in it.
std::string to_html(const Report& report, const Peer* peer, std::span<const Thumbnails> worst);

/// A page of Markdown with the tables of GitHub. Thumbnails are shown from the files `folder`/picture_name(..), which
/// is relative to the page; without a folder they are only named.
std::string to_markdown(const Report& report, const Peer* peer, std::span<const Thumbnails> worst,
                        const std::string& folder);

/// The name of the file of a picture: "truth-1.png" or "segments-1.png" for the first of the thumbnails, number 0.
std::string picture_name(std::string_view which, std::size_t number);

}  // namespace segserve::eval
