// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/codec/text/text_table.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

// Helpers of the tests of text tables.
namespace segserve::codec {

/// The table, with all of its columns.
inline LabeledCloud read_table(std::string_view file) {
  EXPECT_TRUE(is_text_table(file)) << file;
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status() << "\n" << file;
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

/// The names of the columns that are kept as attributes.
inline std::vector<std::string> attributes_of(const LabeledCloud& cloud) {
  std::vector<std::string> names;
  for (const Attribute& attribute : cloud.attributes) names.push_back(attribute.name);
  return names;
}

}  // namespace segserve::codec
