// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

// Lines of text tables that are comments.
namespace segserve::codec {

/// The comment in a line that begins with # or //, without its mark; nullopt if the line is none.
std::optional<std::string_view> text_comment(std::string_view line);

/// The comment in a line above the first row that begins with %, ! or ;, without its mark; nullopt if the line is none.
/// Such a line may also be the names of the columns, as ROS writes "%time,x,y,z", and is if the next line is a row of
/// them. The first lines of PDF, PostScript and MatrixMarket are no comments. `rest` is the text below the line.
std::optional<std::string_view> comment_above_rows(std::string_view line, std::string_view rest);

/// Whether a comment tells that the rows are those of COLMAP's points3D.txt.
bool is_colmap_header(std::string_view comment);

/// The columns of such rows, in front of the track of the point, which has two numbers for each image.
inline constexpr std::array<std::string_view, 8> kColmapColumns{"point3d_id", "x",     "y",    "z",
                                                                "red",        "green", "blue", "error"};

}  // namespace segserve::codec
