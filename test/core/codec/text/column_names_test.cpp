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
  for (const std::string_view names : {"x,y,z",
                                       "X,Y,Z",
                                       "x_m,y_m,z_m",
                                       "pos_x,pos_y,pos_z",
                                       "position.x,position.y,position.z",
                                       "px,py,pz",
                                       "X Coord,Y Coord,Z Coord",
                                       "x_coordinate,y_coordinate,z_coordinate",
                                       "field.x,field.y,field.z",
                                       "xyz[0],xyz[1],xyz[2]",
                                       "xyz_0,xyz_1,xyz_2",
                                       "Points:0,Points:1,Points:2",
                                       "Easting,Northing,Elevation",
                                       "E,N,Z",
                                       "X (m),Y (m),Z (m)",
                                       "Points_0,Points_1,Points_2",
                                       "PosX,PosY,PosZ",
                                       "lidar_x,lidar_y,lidar_z",
                                       "East,North,Up",
                                       "X/m,Y/m,Z/m",
                                       "x in m,y in m,z in m",
                                       "x_cam,y_cam,z_cam",
                                       "Ori_x,Ori_y,Ori_z",
                                       "Easting,Northing,Elev",
                                       "x,y,height",
                                       "X;Y;H",
                                       "X1 (m), Y1 (m), Z1 (m)"}) {
    const LabeledCloud cloud = read_table(std::string(names) + "\n1,2,3\n4,5,6\n");
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << names;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << names;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << names;
    EXPECT_TRUE(cloud.attributes.empty()) << names;
  }
  EXPECT_THAT(attributes_of(read_table("X1 (m), Y1 (m), Z1 (m), X2 (m), Y2 (m), Z2 (m)\n1,2,3,4,5,6\n")),
              ElementsAre("X2", "Y2", "Z2"));
  EXPECT_THAT(read_table("x,y,h,z\n1,2,8,3\n").cloud.z, ElementsAre(3));
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
                                         {"X/mm;Y/mm;Z/mm\n", 0.001},
                                         {"x in inches,y in inches,z in inches\n", 0.0254},
                                         {"x,y,z\nmm,mm,mm\n", 0.001},
                                         {"x,y,z\n[cm],[cm],[cm]\n", 0.01},
                                         {"x,y,z\n----,----,----\n", 1},
                                         {"x,y,z\nm,m,m\n", 1},
                                         {"X (US ft),Y (US ft),Z (US ft)\n", 0.3048},
                                         {"X (ftUS),Y (ftUS),Z (ftUS)\n", 0.3048},
                                         {"X [US survey foot],Y [US survey foot],Z [US survey foot]\n", 0.3048},
                                         {"x_usft,y_usft,z_usft\n", 0.3048},
                                         {"x_us_ft,y_us_ft,z_us_ft\n", 0.3048},
                                         {"x,y,z\nusft,usft,usft\n", 0.3048},
                                         {"x [],y [],z []\n", 1},
                                         {"x (m),y,z\n", 1}}) {
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

TEST(TextTable, AUnitThatIsNotKnownOrNotTheSameIsMentioned) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"x (yd),y (yd),z (yd)\n", "because the unit 'yd' of x is not known"},
      {"X [km],Y [km],Z [km]\n", "because the unit 'km' of x is not known"},
      {"x (dm),y (dm),z (dm)\n", "because the unit 'dm' of x is not known"},
      {"x [µm],y [µm],z [µm]\n", "because the unit 'um' of x is not known"},
      {"x (m),y (m),z (um)\n", "because the unit 'um' of z is not known"},
      {"x,y,z\nyd,yd,yd\n", "because the unit 'yd' of x is not known"},
      {"x (m),y (m),z (mm)\n", "though the units of x, y and z differ: m, m, mm"},
      {"x,y,z\nm,m,mm\n", "though the units of x, y and z differ: m, m, mm"},
      {"x_mm,y_mm,z_m\n", "though the units of x, y and z differ: mm, mm, m"},
      {"x,y,z_mm\n", "though the units of x, y and z differ: none, none, mm"},
      {"x [mm],y,z\n", "though the units of x, y and z differ: mm, none, none"}};
  for (const auto& [head, why] : cases) {
    const std::string file = head + "1,2,3\n4,5,6\n";
    const LabeledCloud cloud = read_table(file);
    EXPECT_EQ(cloud.placement.meters_per_unit(), 1) << head;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << head;
    ASSERT_EQ(cloud.warnings.size(), 1U) << head;
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kUnitGuessed);
    EXPECT_EQ(cloud.warnings[0].message, "the coordinates are taken as m, " + why);
    EXPECT_THAT(decode_cloud(bytes_of(file), {}, {.unit = LengthUnit::kFoot})->warnings, IsEmpty()) << head;
  }
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

TEST(TextTable, DegreesMayStandBesideCoordinates) {
  for (const std::string_view names :
       {"x,y,z,lat,lon", "lat,lon,x,y,z", "Latitude,Longitude,Easting,Northing,Elevation"}) {
    const LabeledCloud cloud = read_table(std::string(names) + "\n1,2,3,4,5\n");
    EXPECT_THAT(cloud.cloud.x, ElementsAre(names[0] == 'x' ? 1 : 3)) << names;
    EXPECT_EQ(cloud.attributes.size(), 2U) << names;
  }
}

TEST(TextTable, SeparatorsOfThousandsAreNamed) {
  for (const std::string_view row :
       {"499.999,9999;5.399.999,9998;3,5", "499'999.99;5'399'999.99;3.5", "499\u00a0999,99;5\u00a0399\u00a0999,99;3,5",
        "\"499,999.9999\";\"5,399,999.9998\";3.5"}) {
    const std::string file = "X;Y;Z\n" + std::string(row) + "\n";
    EXPECT_THAT(std::string(decode_text_table(bytes_of(file), {}).status().message()),
                HasSubstr("line 2 has numbers with separators of thousands"))
        << row;
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
  EXPECT_THAT(read_table("1 2 3 30 150 110 70\n").warnings.at(0).message, HasSubstr("x y z intensity red green blue;"));
}

TEST(TextTable, ALineThatNumbersTheColumnsIsNoPoint) {
  const LabeledCloud table = read_table("0,1,2,3,4,5\n1.5,2,3,40,50,60\n4.5,5,6,70,80,90\n");
  EXPECT_THAT(table.cloud.x, ElementsAre(1.5F, 4.5F));
  EXPECT_TRUE(table.cloud.has_color());
  ASSERT_EQ(table.warnings.size(), 1U);
  EXPECT_EQ(table.warnings[0].message, "the line 0 to 5 above the rows is taken as the numbers of the columns");
  for (const std::string_view file :
       {",0,1,2\n17,1.5,2,3\n4,4.5,5,6\n9,7.5,8,9\n", "\t0\t1\t2\n17\t1.5\t2\t3\n4\t4.5\t5\t6\n"}) {
    const LabeledCloud with_index = read_table(file);
    EXPECT_EQ(with_index.cloud.x[0], 1.5F) << file;
    EXPECT_THAT(attributes_of(with_index), ElementsAre("point_number")) << file;
  }
  for (const std::string_view file :
       {"V1,V2,V3,V4,V5,V6\n1,2,3,9,8,7\n4,5,6,9,8,7\n", "Var1;Var2;Var3;Var4;Var5;Var6\n1;2;3;9;8;7\n4;5;6;9;8;7\n",
        "V1 V2 V3 V4 V5 V6\n1 2 3 9 8 7\n4 5 6 9 8 7\n", "X1\tX2\tX3\tX4\tX5\tX6\n1\t2\t3\t9\t8\t7\n4\t5\t6\t9\t8\t7\n",
        "f0,f1,f2,f3,f4,f5\n1,2,3,9,8,7\n4,5,6,9,8,7\n"}) {
    const LabeledCloud made_up = read_table(file);
    EXPECT_THAT(made_up.cloud.x, ElementsAre(1, 4)) << file;
    EXPECT_TRUE(made_up.cloud.has_color()) << file;
    EXPECT_THAT(made_up.warnings.at(0).message, HasSubstr(" above the rows is taken")) << file;
  }
  for (const std::string_view file : {"\"\",\"V1\",\"V2\",\"V3\"\n\"7\",1.5,2,3\n\"5\",4.5,5,6\n\"8\",7,8,9\n",
                                      "\"V1\" \"V2\" \"V3\"\n\"7\" 1.5 2 3\n\"5\" 4.5 5 6\n\"8\" 7 8 9\n"}) {
    const LabeledCloud of_r = read_table(file);
    EXPECT_THAT(of_r.cloud.x, ElementsAre(1.5F, 4.5F, 7)) << file;
    EXPECT_THAT(attributes_of(of_r), ElementsAre("point_number")) << file;
  }
  EXPECT_FALSE(decode_text_table(bytes_of("V1,V2,V4\n1,2,3\n"), {}).ok());
  EXPECT_FALSE(decode_text_table(bytes_of("V2,V3,V4\n1,2,3\n"), {}).ok());
  EXPECT_FALSE(decode_text_table(bytes_of("feature0,feature1,feature2\n1,2,3\n"), {}).ok());
  EXPECT_EQ(read_table("0,1,2\n3,4,5\n").cloud.size(), 2U) << "so may points be";
  EXPECT_EQ(read_table("0 1 2\n3.5 4 5\n").cloud.size(), 2U);
  EXPECT_EQ(read_table("0,1,3\n3.5,4,5\n").cloud.size(), 2U);
}

TEST(TextTable, AFirstColumnThatCountsTheRowsIsNoCoordinate) {
  for (const std::string_view file :
       {"1,10.5,2,3\n2,20.5,2,3\n3,30.5,2,3\n", "7 10.5 2 3 1 2 3\n8 20.5 2 3 4 5 6\n9 30.5 2 3 0 0 9\n",
        "101;10.5;2;3;GND\n102;20.5;2;3;GND\n103;30.5;2;3;GND\n"}) {
    const LabeledCloud table = read_table(file);
    EXPECT_THAT(table.cloud.x, ElementsAre(10.5F, 20.5F, 30.5F)) << file;
    EXPECT_EQ(attributes_of(table).at(0), "point_number");
    EXPECT_THAT(table.warnings.at(0).message, HasSubstr("are taken as: point_number x y z")) << file;
  }
  EXPECT_THAT(read_table("1 2 3\n2 3 4\n3 4 5\n").cloud.x, ElementsAre(1, 2, 3)) << "x y z are needed";
  EXPECT_THAT(read_table("1 2 3 4\n2 3 4 4\n4 4 5 4\n").cloud.x, ElementsAre(1, 2, 4));
}

TEST(TextTable, AFourthColumnMayBePackedColors) {
  for (const std::string_view file : {"1 2 3 1056816\n1 3 3 255\n", "1 2 3 4279246896\n1 3 3 4278190335\n",
                                      "1 2 3 1.4809147e-39\n1 3 3 3.5733111e-43\n"}) {
    const LabeledCloud table = read_table(file);
    EXPECT_THAT(table.cloud.rgb, ElementsAre(0x102030U, 255U)) << file;
    EXPECT_THAT(table.warnings.at(0).message, HasSubstr("are taken as: x y z rgb")) << file;
  }
  EXPECT_THAT(attributes_of(read_table("1 2 3 70000\n1 3 3 70010\n")), ElementsAre("intensity")) << "as times do";
  EXPECT_THAT(attributes_of(read_table("1 2 3 65535\n1 3 3 0\n")), ElementsAre("intensity"));
}

TEST(TextTable, AnAlphaHasTheRangeOfItsColors) {
  const LabeledCloud table = read_table("1 2 3 0.1 0.2 1 1.0\n1 2 4 0.3 0.2 0 1.0\n");
  EXPECT_TRUE(table.cloud.has_color());
  EXPECT_TRUE(table.label.empty());
  EXPECT_THAT(attributes_of(table), ElementsAre("alpha"));
}

}  // namespace
}  // namespace segserve::codec
