// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace segserve::segctl {

/// The names of the outputs of these files, without extension, relative to the output folder. A file is named by its
/// stem: "s1" for "scans/s1.pcd". Files that would have the same name are told apart, and others keep their names:
///
/// - by their extension, unless it is .pcd: "s1" for "s1.pcd" and "s1.ply" for "s1.ply",
/// - then by the least number of folders that it takes: "a/s1" for "a/s1.pcd" and "b/s1" for "b/s1.pcd".
///
/// The name of a file does not depend on the order of the files. Two are the same only if that is not enough, as for
/// "s1.pcd" and "s1.PCD" in one folder.
std::vector<std::string> output_names(const std::vector<std::string>& files);

}  // namespace segserve::segctl
