// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/column_names.hpp"

#include <string>
#include <string_view>
#include <vector>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"
#include "test/core/codec/text/read_table.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(TextTable, CoordinatesHaveNamesOfManyKinds) {
  for (const std::string_view names :
       {"x,y,z", "X,Y,Z", "x_m,y_m,z_m", "pos_x,pos_y,pos_z", "position.x,position.y,position.z", "px,py,pz",
        "X Coord,Y Coord,Z Coord", "x_coordinate,y_coordinate,z_coordinate", "field.x,field.y,field.z",
        "xyz[0],xyz[1],xyz[2]", "xyz_0,xyz_1,xyz_2", "Points:0,Points:1,Points:2", "Easting,Northing,Elevation",
        "E,N,Z", "X (m),Y (m),Z (m)"}) {
    const LabeledCloud cloud = read_table(std::string(names) + "\n1,2,3\n4,5,6\n");
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << names;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << names;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << names;
    EXPECT_TRUE(cloud.attributes.empty()) << names;
  }
  EXPECT_THAT(read_table("id,northing,easting,elevation\n7,1,2,3\n8,4,5,6\n").cloud.x, ElementsAre(2, 5));
}

TEST(TextTable, AUnitBesideOrBelowTheNamesIsTaken) {
  struct Case {
    std::string_view head;
    double meters;
  };
  for (const Case& c : std::vector<Case>{{"x [mm],y [mm],z [mm]\n", 0.001},
                                         {"X (mm), Y (mm), Z (mm)\n", 0.001},
                                         {"x_mm,y_mm,z_mm\n", 0.001},
                                         {"pos_x_cm,pos_y_cm,pos_z_cm\n", 0.01},
                                         {"x (feet),y (feet),z (feet)\n", 0.3048},
                                         {"x,y,z\nmm,mm,mm\n", 0.001},
                                         {"x,y,z\n[cm],[cm],[cm]\n", 0.01},
                                         {"x,y,z\n----,----,----\n", 1},
                                         {"x,y,z\nm,m,m\n", 1},
                                         {"x (px),y (px),z (px)\n", 1},
                                         {"x [mm],y [m],z [m]\n", 1}}) {
    const std::string file = std::string(c.head) + "1,2,3\n4,5,6\n";
    const LabeledCloud cloud = read_table(file);
    EXPECT_DOUBLE_EQ(cloud.placement.meters_per_unit(), c.meters) << c.head;
    EXPECT_FLOAT_EQ(cloud.cloud.x[1], static_cast<float>(4 * c.meters)) << c.head;
    EXPECT_EQ(cloud.warnings.size(), c.meters == 1 ? 0U : 1U) << c.head;
    const auto given = decode_cloud(bytes_of(file), {}, {.unit = LengthUnit::kMeter});
    ASSERT_TRUE(given.ok()) << given.status();
    EXPECT_EQ(given->placement.meters_per_unit(), 1) << "a unit that is given wins: " << c.head;
  }
  EXPECT_THAT(read_table("x_mm,y_mm,z_mm\n1,2,3\n").warnings[0].message, HasSubstr("are taken as mm, as the names"));
}

TEST(TextTable, TitlesAboveTheNamesAreMentioned) {
  const LabeledCloud cloud = read_table("Scan of a table\nProject: 7, phase 2\n\nx,y,z\n1,2,3\n4,5,6\n");
  EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4));
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kRowsNotUsed);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("2 lines of words above the names"));
  EXPECT_FALSE(is_text_table("a title\nand another one\n1 2 3\n"));
  EXPECT_FALSE(is_text_table("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n"));
}

TEST(TextTable, AnAlphaBehindColorsIsNoIntensityBeforeThem) {
  const LabeledCloud cloud = read_table("1 2 3 150 110 70 255\n4 5 6 40 60 200 255\n");
  EXPECT_THAT(cloud.cloud.rgb, ElementsAre(0x966E46U, 0x283CC8U));
  EXPECT_THAT(attributes_of(cloud), ElementsAre("alpha"));
  EXPECT_THAT(read_table("1 2 3 9 150 110 70\n4 5 6 8 40 60 200\n").cloud.rgb, ElementsAre(0x966E46U, 0x283CC8U));
}

TEST(TextTable, DegreesAreNoCoordinates) {
  for (const std::string_view names : {"lat,lon,alt", "Latitude,Longitude,Height", "lng,lat,z"}) {
    const auto status = decode_text_table(bytes_of(std::string(names) + "\n52.5,13.4,30\n"), {}).status();
    EXPECT_THAT(std::string(status.message()), HasSubstr("latitudes and longitudes are no coordinates")) << names;
  }
}

TEST(TextTable, NamesTellTheColumns) {
  for (const std::string_view file :
       {"x,y,z,red,green,blue,intensity,label\n1,2,3,255,128,0,0.5,7\n",
        "\"X\";\"Y\";\"Z\";\"R\";\"G\";\"B\";\"intensity\";\"label\"\n1;2;3;255;128;0;0.5;7\n",
        "//X Y Z R G B intensity scalar_Label\n1 2 3 255 128 0 0.5 7\n",
        "# x y z r g b intensity label\n# a remark with eight words in it, then\n# x y z r g b intensity label\n"
        "1 2 3 255 128 0 0.5 7\n",
        "label intensity z y x b g r\n7 0.5 3 2 1 0 128 255\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1)) << file;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0))) << file;
    EXPECT_THAT(cloud.label, ElementsAre(7)) << file;
    EXPECT_THAT(attributes_of(cloud), testing::Contains("intensity")) << file;
  }
}

TEST(TextTable, NamesOfOtherProgramsAreKnown) {
  for (const std::string_view file :
       {"X\tY\tZ\tR\tG\tB\tReturn Number\n1\t2\t3\t9\t8\t7\t1\n",
        "\"RGB:0\",\"RGB:1\",\"RGB:2\",\"Points:0\",\"Points:1\",\"Points:2\"\n9,8,7,1,2,3\n",
        "Points_m_XYZ:0,Points_m_XYZ:1,Points_m_XYZ:2,r,g,b\n1,2,3,9,8,7\n", "X [m],Y [m],Z [m],R,G,B\n1,2,3,9,8,7\n",
        "X [m] Y [m] Z [m] R G B\n1 2 3 9 8 7\n", "x(m),y(m),z(m),r,g,b\n1,2,3,9,8,7\n",
        "Easting,Northing,Elevation,Red,Green,Blue\n1,2,3,9,8,7\n", "sep=;\nx;y;z;r;g;b\n1;2;3;9;8;7\n",
        "x|y|z|r|g|b\n1|2|3|9|8|7\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1)) << file;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3)) << file;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(9, 8, 7))) << file;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << file;
  }
  EXPECT_TRUE(is_text_table("a,b,c\n1,2,3\n"));  // so that the fault is about the names
  EXPECT_FALSE(is_text_table("some,words,here\nand,no,number\n"));
  EXPECT_FALSE(is_text_table("f 1 2 3\nf 4 5 6\n"));
  EXPECT_FALSE(is_text_table("SIZE 4 4 4\nCOUNT 1 1 1\n"));
}

TEST(TextTable, ValuesTellTheColumnsThatHaveNoNames) {
  EXPECT_THAT(attributes_of(read_table("1 2 3 0.5\n")), ElementsAre("intensity"));
  EXPECT_THAT(read_table("1 2 3 255 128 0\n").cloud.rgb, ElementsAre(pack_rgb(255, 128, 0)));
  EXPECT_THAT(read_table("1 2 3 1.0 0.5 0\n1 2 3 0.5 0.5 0.5\n").cloud.rgb,
              ElementsAre(pack_rgb(255, 128, 0), pack_rgb(128, 128, 128)));
  const LabeledCloud normals = read_table("1 2 3 0 0 -1\n1 2 3 0.6 0.8 0\n1 2 3 0 0 0\n");
  EXPECT_THAT(attributes_of(normals), ElementsAre("nx", "ny", "nz"));
  EXPECT_FALSE(normals.cloud.has_color());
  const LabeledCloud pts = read_table("2\n1 2 3 -1200 255 128 0\n4 5 6 -7 0 0 255\n");
  EXPECT_THAT(pts.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(0, 0, 255)));
  EXPECT_THAT(attributes_of(pts), ElementsAre("intensity"));
  EXPECT_THAT(pts.warnings, IsEmpty());
  const LabeledCloud both = read_table("1 2 3 10 20 30 40\n");
  EXPECT_THAT(both.cloud.rgb, ElementsAre(pack_rgb(20, 30, 40)));
  ASSERT_EQ(both.warnings.size(), 1U);
  EXPECT_THAT(both.warnings[0].message, HasSubstr("taken as: x y z intensity red green blue"));
  const LabeledCloud last = read_table("1 2 3 10 20 30 -4\n");
  EXPECT_THAT(last.cloud.rgb, ElementsAre(pack_rgb(10, 20, 30)));
  EXPECT_THAT(attributes_of(last), ElementsAre("column_7"));
}

TEST(TextTable, ALastColumnOfSmallIntegersBehindColorsIsALabel) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"1 2 3 150 110 70 0\n1 2 3 150 110 70 2\n", "x y z red green blue label"},
      {"1 2 3 0.59 0.43 0.27 0\n1 2 3 0.59 0.43 0.27 2\n", "x y z red green blue label"},
      {"1 2 3 3 150 110 70 0\n1 2 3 3 150 110 70 2\n", "x y z intensity red green blue label"},
  };
  for (const auto& [file, names] : cases) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.label, ElementsAre(0, 2)) << file;
    EXPECT_EQ(cloud.cloud.rgb[0] >> 16U, 150U) << file;
    ASSERT_EQ(cloud.warnings.size(), 1U) << file;
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("taken as: " + names + ";"));
  }
  EXPECT_EQ(read_table("1 2 3 -3 150 110 70 0\n").label.size(), 1U);
  const LabeledCloud two = read_table("1 2 3 150 110 70 4 0\n");
  EXPECT_THAT(two.warnings[0].message, HasSubstr("x y z red green blue column_7"));
  EXPECT_THAT(read_table("1 2 3 3 150 110 70\n").warnings[0].message, HasSubstr("x y z intensity red green blue;"));
}

}  // namespace
}  // namespace segserve::codec
