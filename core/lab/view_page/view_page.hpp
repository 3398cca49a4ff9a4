// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/placement.hpp"
#include "segserve/segment.hpp"

// A page that shows segmented clouds in 3D. It is one HTML file that loads nothing.
namespace segserve::view_page {

/// A cloud of N points. The spans must outlive the call.
struct PageCloud {
  CloudView points;
  std::span<const std::uint32_t> truth;  ///< N labels of the file, of which 0 is "not labeled"; empty if it has none
  codec::Placement placement;            ///< from the file's coordinates to those of the points
};

/// A segmentation of one of the clouds, which has supervoxels, a tree and a resolution.
struct PageResult {
  std::string name;                            ///< for people; may hold anything
  std::string method;                          ///< the name of the method
  std::size_t cloud = 0;                       ///< the index of its cloud
  const Segmentation* segmentation = nullptr;  ///< with `threshold` of the cut, unless `regions` is set
  std::optional<std::uint32_t> regions;        ///< the number of regions at which it was cut
};

/// The data of clouds and results in the form that the page reads.
struct PageData {
  nlohmann::ordered_json json;                              ///< descriptions, which name arrays by their ids
  std::vector<std::pair<std::string, std::string>> arrays;  ///< ids, and the base64 of a gzip; see PageArrays
};

/// The data of clouds and one or two results. Points that are not finite, and those without depth in a CAMERA view, are
/// left out. INVALID_ARGUMENT if the arrays of a result do not fit its cloud.
absl::StatusOr<PageData> page_data(const std::string& title, std::span<const PageCloud> clouds,
                                   std::span<const PageResult> results);

/// Puts clouds and one or two results into the page that client/page/build.js bundled. Points that are not finite, and
/// those without depth in a CAMERA view, are left out. Names become text of the page and nothing else.
/// INVALID_ARGUMENT if the arrays of a result do not fit its cloud; INTERNAL if `bundle` is no such page.
absl::StatusOr<std::string> make_page(std::string_view bundle, const std::string& title,
                                      std::span<const PageCloud> clouds, std::span<const PageResult> results);

}  // namespace segserve::view_page
