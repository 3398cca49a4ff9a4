// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_table.hpp"

#include <atomic>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

LabeledCloud read(std::string_view file) {
  EXPECT_TRUE(is_text_table(file)) << file;
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status() << "\n" << file;
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

std::vector<std::string> attributes_of(const LabeledCloud& cloud) {
  std::vector<std::string> names;
  for (const Attribute& attribute : cloud.attributes) names.push_back(attribute.name);
  return names;
}

TEST(TextTable, EverySeparatorIsRead) {
  for (const std::string_view file : {"1 2 3\n4 5 6\n", "1\t2\t3\r\n4\t5\t6\r\n", "1,2,3\n4,5,6\n", "1, 2, 3\n4, 5, 6",
                                      "1;2;3\n4;5;6\n", "1,2,3,\n4,5,6,\n", "  1  2 3 \n\n# a remark\n4 5 6\n"}) {
    const LabeledCloud cloud = read(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << file;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << file;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << file;
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
    const LabeledCloud cloud = read(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1)) << file;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0))) << file;
    EXPECT_THAT(cloud.label, ElementsAre(7)) << file;
    EXPECT_THAT(attributes_of(cloud), testing::Contains("intensity")) << file;
  }
}

TEST(TextTable, ValuesTellTheColumnsThatHaveNoNames) {
  EXPECT_THAT(attributes_of(read("1 2 3 0.5\n")), ElementsAre("intensity"));
  EXPECT_THAT(read("1 2 3 255 128 0\n").cloud.rgb, ElementsAre(pack_rgb(255, 128, 0)));
  EXPECT_THAT(read("1 2 3 1.0 0.5 0\n1 2 3 0.5 0.5 0.5\n").cloud.rgb,
              ElementsAre(pack_rgb(255, 128, 0), pack_rgb(128, 128, 128)));
  const LabeledCloud normals = read("1 2 3 0 0 -1\n1 2 3 0.6 0.8 0\n1 2 3 0 0 0\n");
  EXPECT_THAT(attributes_of(normals), ElementsAre("nx", "ny", "nz"));
  EXPECT_FALSE(normals.cloud.has_color());
  const LabeledCloud pts = read("2\n1 2 3 -1200 255 128 0\n4 5 6 -7 0 0 255\n");
  EXPECT_THAT(pts.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(0, 0, 255)));
  EXPECT_THAT(attributes_of(pts), ElementsAre("intensity"));
  EXPECT_THAT(pts.warnings, IsEmpty());
  const LabeledCloud both = read("1 2 3 10 20 30 40\n");
  EXPECT_THAT(both.cloud.rgb, ElementsAre(pack_rgb(20, 30, 40)));
  ASSERT_EQ(both.warnings.size(), 1U);
  EXPECT_THAT(both.warnings[0].message, HasSubstr("taken as: x y z intensity red green blue"));
  const LabeledCloud last = read("1 2 3 10 20 30 -4\n");
  EXPECT_THAT(last.cloud.rgb, ElementsAre(pack_rgb(10, 20, 30)));
  EXPECT_THAT(attributes_of(last), ElementsAre("column_7"));
}

TEST(TextTable, AllBlocksOfPtsAreRead) {
  const LabeledCloud cloud = read("2\n1 2 3\n4 5 6\n1\n7 8 9\n");
  EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4, 7));
  EXPECT_THAT(cloud.warnings, IsEmpty());
  const LabeledCloud cut = read("3\n1 2 3\n4 5 6\n");
  ASSERT_EQ(cut.warnings.size(), 1U);
  EXPECT_THAT(cut.warnings[0].message, HasSubstr("3 points are promised, and 2 are there"));
}

TEST(TextTable, UnknownPositionsAndFarOnesAreKept) {
  const LabeledCloud cloud = read("x,y,z\nnan,NaN,1.#QNAN\n500000.125,5800000.25,1e2\n500001.125,5800000.25,+1\n");
  EXPECT_TRUE(std::isnan(cloud.cloud.x[0]));
  EXPECT_EQ(cloud.cloud.x[2] - cloud.cloud.x[1], 1);
  EXPECT_EQ(cloud.file_position[0][1], 500000.125);
}

TEST(TextTable, ACommentTellsTheView) {
  EXPECT_EQ(read("# segserve view world 1 2 3\nx,y,z\n1,2,3\n").cloud.view, View::world(1, 2, 3));
  EXPECT_EQ(read("//segserve view camera\n//x y z\n1 2 3\n").cloud.view, View::camera());
}

TEST(TextTable, ColumnsOfWordsAreMentioned) {
  const LabeledCloud cloud = read("x,y,z,kind\n1,2,3,\"a tree, tall\"\n4,5,6,car\n");
  EXPECT_THAT(cloud.attributes, IsEmpty());
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
}

TEST(TextTable, EachFaultNamesItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"1 2 3\n4 5\n", "line 2: the value of column 3 is missing"},
      {"x,y,z\n1,2,3\n4,,6\n", "line 3: the value of 'y' is missing; nan stands for"},
      {"1 2 3\n4 5 6 7\n", "line 2: '7' is one value too many; the rows have 3"},
      {"1 2 3\n4 five 6\n", "line 2: 'five' is not a value of column 2"},
      {"x y z kind label\n1 2 3 a b\n", "line 2: 'b' is not a value of 'label'"},
      {"1,5 2,5 3,5\n", "line 1: '1,5' has a decimal comma"},
      {"1,5;2,5;3,5\n", "line 1: '1,5' has a decimal comma"},
      {"x y z x\n1 2 3 4\n", "'x' occurs twice"},
      {"x y z\n", "it has no row of numbers"},
      {"10\n20\n1 2 3\n", "two counts, as PTX"},
      {"5\n1 2\n", "line 2 has 2 columns; x, y and z are needed"},
      {"x y z\na b c\n", "line 2 is neither numbers nor the names"},
  };
  for (const auto& [file, words] : cases) expect_fault(decode_text_table(bytes_of(file), {}).status(), words);
}

TEST(TextTable, LimitsHold) {
  expect_over_limit(decode_text_table(bytes_of("1 2 3\n4 5 6\n"), {.max_points = 1}).status(), "max_points",
                    "2 points exceed");
  expect_over_limit(decode_text_table(bytes_of("1 2 3\n4 5 6\n"), {.max_bytes = 47}).status(), "max_bytes",
                    "exceed the limit of 47");
  std::string wide;
  for (int i = 0; i < 5000; ++i) wide += "1 ";
  expect_fault(decode_text_table(bytes_of(wide), {}).status(), "more than 4096 columns");
}

TEST(TextTable, DamageDoesNoHarm) {
  const std::string file = "# segserve view world 1 2 3\nx,y,z,r,g,b,label\n1,2,3,4,5,6,7\n-1.5,2e3,nan,1,1,1,3\n";
  const auto decode = [](const std::string& bytes) -> absl::StatusOr<Cloud> {
    auto cloud = decode_cloud(bytes_of(bytes), kDamageLimits, {.keep_everything = true});
    if (!cloud.ok()) return cloud.status();
    return cloud->cloud;
  };
  for (std::size_t size = 0; size < file.size(); ++size) {
    ASSERT_NO_FATAL_FAILURE(expect_sound(decode(file.substr(0, size)))) << size;
  }
  expect_flips_survived(file, decode);
}

TEST(TextTable, AStopIsHeard) {
  std::string file;
  for (int i = 0; i < 100'000; ++i) file += "1 2 3\n";
  const std::atomic<bool> cancelled = true;
  WorkMeter meter;
  const StopToken stop(&cancelled, std::nullopt, &meter);
  EXPECT_EQ(decode_text_table(bytes_of(file), {}, {}, stop).status().code(), absl::StatusCode::kCancelled);
  EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
}

}  // namespace
}  // namespace segserve::codec
