// SPDX-License-Identifier: Apache-2.0
// The lines above the rows of a text table that are no names.

#include <string>
#include <string_view>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"
#include "test/core/codec/text/read_table.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(TextTable, ARowOfDashesIsARuleOnlyIfItLooksLikeOne) {
  for (const std::string_view file : {"x,y,z\n---,---,---\n1,2,3\n", "x y z\n- - -\n1 2 3\n",
                                      "x  y  z\n__  __  __\n1 2 3\n", "x|y|z\n--|--|--\n1|2|3\n"}) {
    EXPECT_THAT(read_table(file).cloud.x, ElementsAre(1)) << file;
  }
  EXPECT_EQ(read_table("x,y,z\n-,-,-\n1,2,3\n").cloud.size(), 2U);
  expect_fault(decode_text_table(bytes_of("x,y,z\n1,2,3\n---,1,1\n"), {}).status(), "'---' is not a value of 'x'");
}

TEST(TextTable, LinesAboveTheRowsMayBeComments) {
  for (const std::string_view mark : {"%", "!", ";", "#", "//", "%%"}) {
    const std::string begin(mark);
    for (const std::string& file :
         {begin + " by a program, 2024\n" + begin + " x y z r g b\n1 2 3 9 8 7\n", begin + "x y z r g b\n1 2 3 9 8 7\n",
          begin + " by a program\nx,y,z,r,g,b\n" + begin + " a remark\n1,2,3,9,8,7\n", begin + "\n1 2 3 9 8 7\n"}) {
      const LabeledCloud cloud = read_table(file);
      EXPECT_THAT(cloud.cloud.x, ElementsAre(1)) << file;
      EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(9, 8, 7))) << file;
    }
  }
  EXPECT_THAT(attributes_of(read_table("%time,field.x,field.y,field.z\n17,1,2,3\n")), ElementsAre("%time"));
  EXPECT_THAT(read_table(";x;y;z\n0;1;2;3\n1;4;5;6\n").cloud.x, ElementsAre(1, 4));
  EXPECT_TRUE(std::isnan(read_table(";;;1\n1;2;3;4\n").cloud.x[0]));
  EXPECT_FALSE(is_text_table("%PDF-1.4\n1 0 obj\n"));
  const std::string matrix = "%%MatrixMarket matrix coordinate real general\n3 3 1\n1 1 5\n";
  expect_fault(decode_text_table(bytes_of(matrix), {}).status(), "line 1 is neither numbers nor the names of columns");
}

TEST(TextTable, RowsOfColmapHaveTracks) {
  const std::string head =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
      "# Number of points: 3, mean track length: 1\n";
  const LabeledCloud cloud =
      read_table(head + "63 1.5 2 3 150 110 70 0.5 1 17 2 30\n7 4.5 5 6 9 8 7 1.25 3 4\n8 7 8 9 1 2 3 0\n");
  EXPECT_THAT(cloud.cloud.x, ElementsAre(1.5F, 4.5F, 7));
  EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(150, 110, 70), pack_rgb(9, 8, 7), pack_rgb(1, 2, 3)));
  EXPECT_THAT(attributes_of(cloud), ElementsAre("point3d_id", "error"));
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("the images in which the 3 points were seen"));
  expect_fault(decode_text_table(bytes_of(head + "63 1.5 2 3 150 110 70\n"), {}).status(),
               "value of 'error' is missing");
}

}  // namespace
}  // namespace segserve::codec
