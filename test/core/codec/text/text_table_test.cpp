// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_table.hpp"

#include <atomic>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"
#include "test/core/codec/text/read_table.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(TextTable, EverySeparatorIsRead) {
  for (const std::string_view file : {"1 2 3\n4 5 6\n", "1\t2\t3\r\n4\t5\t6\r\n", "1,2,3\n4,5,6\n", "1, 2, 3\n4, 5, 6",
                                      "1;2;3\n4;5;6\n", "1,2,3,\n4,5,6,\n", "  1  2 3 \n\n# a remark\n4 5 6\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << file;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << file;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << file;
  }
}

TEST(TextTable, ExponentsOfFortranAndEndsOfDosAreRead) {
  for (const std::string_view end : {"", "\n", "\n\x1a", "\r\n\x1a"}) {
    EXPECT_THAT(read_table("1.5D-01 2 3\n-4.D+2 5d0 6" + std::string(end)).cloud.x, ElementsAre(0.15F, -400)) << end;
  }
  EXPECT_THAT(read_table("1 2 3\n4 5 6\n" + std::string(512, '\0')).cloud.z, ElementsAre(3, 6));
}

TEST(TextTable, AllBlocksOfPtsAreRead) {
  const LabeledCloud cloud = read_table("2\n1 2 3\n4 5 6\n1\n7 8 9\n");
  EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4, 7));
  EXPECT_THAT(cloud.warnings, IsEmpty());
  const LabeledCloud cut = read_table("3\n1 2 3\n4 5 6\n");
  ASSERT_EQ(cut.warnings.size(), 1U);
  EXPECT_THAT(cut.warnings[0].message, HasSubstr("3 points are promised, and 2 are there"));
}

TEST(TextTable, UnknownPositionsAndFarOnesAreKept) {
  const LabeledCloud cloud =
      read_table("x,y,z\nnan,NaN,1.#QNAN\n500000.125,5800000.25,1e2\n500001.125,5800000.25,+1\n");
  EXPECT_TRUE(std::isnan(cloud.cloud.x[0]));
  EXPECT_EQ(cloud.cloud.x[2] - cloud.cloud.x[1], 1);
  EXPECT_EQ(cloud.file_position[0][1], 500000.125);
}

TEST(TextTable, NumbersThatMicrosoftRoundsAreRead) {
  for (const std::string_view word : {"-1.#J", "1.#R", "-1.#IO", "1.#IND00", "1.#QNAN", "1.#SNAN", "1.#S", "1.#Q"}) {
    const LabeledCloud cloud = read_table("0 0 0\n" + std::string(word) + " 2 3\n");
    EXPECT_TRUE(std::isnan(cloud.cloud.x[1])) << word;
  }
  EXPECT_TRUE(std::isinf(read_table("x y z t\n0 0 0 1\n1 1 1.#INF 2\n").cloud.z[1]));
  expect_fault(decode_text_table(bytes_of("1 2 3\n1.#X 2 3\n"), {}).status(), "'1.#X' is not a value");
}

TEST(TextTable, ACommentTellsTheView) {
  EXPECT_EQ(read_table("# segserve view world 1 2 3\nx,y,z\n1,2,3\n").cloud.view, View::world(1, 2, 3));
  EXPECT_EQ(read_table("//segserve view camera\n//x y z\n1 2 3\n").cloud.view, View::camera());
}

TEST(TextTable, ColumnsOfWordsAreMentioned) {
  const LabeledCloud cloud = read_table("x,y,z,kind\n1,2,3,\"a tree, tall\"\n4,5,6,car\n");
  EXPECT_THAT(cloud.attributes, IsEmpty());
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
}

TEST(TextTable, LabelsThatAreWordsAreMentioned) {
  const LabeledCloud cloud = read_table("x,y,z,label\n1,2,3,table\n4,5,6,7\n");
  EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(cloud.label, IsEmpty());
  EXPECT_THAT(cloud.attributes, IsEmpty());
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kLabelNotUsed);
  EXPECT_EQ(cloud.warnings[0].message, "the labels are not used: line 2: 'table' is not a value of 'label'");
}

TEST(TextTable, ColorsThatAreWordsAreMentioned) {
  for (const std::string_view file : {"x,y,z,r,g,b\n1,2,3,dark,0,0\n", "x,y,z,rgb\n1,2,3,#ff0000\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1)) << file;
    EXPECT_FALSE(cloud.cloud.has_color());
    ASSERT_EQ(cloud.warnings.size(), 1U);
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kColorNotUsed);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("the cloud has no color: line 2"));
  }
}

TEST(TextTable, PackedColorsAreIntegersOrTheirBitsAsFloats) {
  for (const std::string_view file :
       {"x,y,z,rgb\n1,2,3,9858630\n4,5,6,-6918586\n4,5,6,4288048710\n",
        "x,y,z,rgb\n1,2,3,1.3814883079346571e-38\n4,5,6,-9.997838589542423e+37\n4,5,6,1.3814883079346571e-38\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.rgb, testing::AllOf(testing::SizeIs(3), testing::Each(pack_rgb(0x96, 0x6e, 0x46)))) << file;
    EXPECT_THAT(cloud.warnings, IsEmpty());
  }
  for (const std::string_view file : {"x,y,z,rgb\n1,2,3,0.5\n", "x,y,z,rgb\n1,2,3,5000000000\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_FALSE(cloud.cloud.has_color());
    ASSERT_EQ(cloud.warnings.size(), 1U);
    EXPECT_EQ(cloud.warnings[0].message,
              "the cloud has no color: some values of 'rgb' are no colors packed into 4 bytes");
  }
}

TEST(TextTable, LabelsThatAreMissingAreZero) {
  const LabeledCloud cloud = read_table("x,y,z,label\n1,2,3,\n4,5,6,nan\n7,8,9,2\n7,8,9,None\n");
  EXPECT_THAT(cloud.label, ElementsAre(0, 0, 2, 0));
  EXPECT_THAT(cloud.warnings, IsEmpty());
}

TEST(TextTable, EmptyCellsAreUnknown) {
  for (const std::string_view file :
       {"x,y,z,r,g,b\n,,,150,110,70\n1,,3,150,110,70\n", ",,,150,110,70\n1,,3,150,110,70\n",
        "x\ty\tz\tr\tg\tb\n\t\t\t150\t110\t70\n1\t\t3\t150\t110\t70\n",
        "x;y;z;r;g;b\nNA;NA;NA;150;110;70\n1;null;3;150;110;70\n",
        "x,y,z,r,g,b\nn/a,-,--,150,110,70\n1,?,3,150,110,70\n", "-,-,-,150,110,70\n1,-,3,150,110,70\n",
        "x,y,z,r,g,b\n#N/A,1,2,150,110,70\n1,#VALUE!,3,150,110,70\n", "#NV;1;2;150;110;70\n1;#NV;3;150;110;70\n",
        "? ? ? 150 110 70\n1 ? 3 150 110 70\n", "n/a n/a n/a 150 110 70\n1 -- 3 150 110 70\n"}) {
    const LabeledCloud cloud = read_table(file);
    ASSERT_EQ(cloud.cloud.size(), 2U) << file;
    EXPECT_TRUE(std::isnan(cloud.cloud.x[0]) && std::isnan(cloud.cloud.y[1])) << file;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(150, 110, 70), pack_rgb(150, 110, 70))) << file;
    EXPECT_THAT(cloud.warnings, IsEmpty()) << file;
  }
  EXPECT_EQ(attributes_of(read_table("x,y,z,intensity\n1,2,3,\n4,5,6,7\n")).size(), 1U);
}

TEST(TextTable, TheFirstColumnMayHaveWords) {
  for (const std::string_view file :
       {"name,x,y,z\ncup,1,2,3\ncup,4,5,6\n", "time,x,y,z\n2024-01-01 10:00:00.1,1,2,3\n2024-01-01 10:00:00.2,4,5,6\n",
        "id x y z\np0 1 2 3\np1 4 5 6\n", "name\tx\ty\tz\na cup\t1\t2\t3\na cup\t4\t5\t6\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << file;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6)) << file;
    ASSERT_EQ(cloud.warnings.size(), 1U) << file;
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept) << file;
  }
}

TEST(TextTable, RowsMayHaveNamesInFront) {
  for (const std::string_view file : {" x y z r g b\n0 1 2 3 9 8 7\n1 4 5 6 9 8 7\n",
                                      "\"x\" \"y\" \"z\" \"r\" \"g\" \"b\"\n\"1\" 1 2 3 9 8 7\n\"2\" 4 5 6 9 8 7\n",
                                      "x,y,z,r,g,b\n0,1,2,3,9,8,7\n1,4,5,6,9,8,7\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 4)) << file;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(9, 8, 7), pack_rgb(9, 8, 7))) << file;
  }
}

TEST(TextTable, DecimalCommasAreReadUnlessCommasSeparate) {
  for (const std::string_view file : {"X;Y;Z;kind\n1,5;-2,5;3,0e1;a,b\n", "1,5;-2,5;30\n", "1,5 -2,5 30,0\n",
                                      "1,5\t-2,5\t30,0\n", "x\ty\tz\n1,5\t-2,5\t30,0\n"}) {
    const LabeledCloud cloud = read_table(file);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1.5F)) << file;
    EXPECT_THAT(cloud.cloud.y, ElementsAre(-2.5F)) << file;
    EXPECT_THAT(cloud.cloud.z, ElementsAre(30)) << file;
  }
}

TEST(TextTable, LargeIntegersStayExact) {
  const LabeledCloud cloud =
      read_table("x,y,z,timestamp\n1,2,3,5\n1,2,3,1700000000123456789\n1,2,3,-1700000000123456789\n");
  ASSERT_EQ(cloud.attributes.size(), 1U);
  ASSERT_EQ(cloud.attributes[0].type, ScalarType::kInt64);
  std::vector<std::int64_t> values(3);
  std::memcpy(values.data(), cloud.attributes[0].values.data(), 3 * sizeof(std::int64_t));
  EXPECT_THAT(values, ElementsAre(5, 1700000000123456789, -1700000000123456789));
  EXPECT_THAT(cloud.warnings, IsEmpty());
}

TEST(TextTable, LargeIntegersMayHaveNoSign) {
  const LabeledCloud cloud = read_table("x,y,z,hash\n1,2,3,5\n1,2,3,18446744073709551615\n1,2,3,9007199254740993\n");
  ASSERT_EQ(cloud.attributes.size(), 1U);
  ASSERT_EQ(cloud.attributes[0].type, ScalarType::kUint64);
  std::vector<std::uint64_t> values(3);
  std::memcpy(values.data(), cloud.attributes[0].values.data(), 3 * sizeof(std::uint64_t));
  EXPECT_THAT(values, ElementsAre(5U, 18446744073709551615U, 9007199254740993U));
  EXPECT_THAT(cloud.warnings, IsEmpty());
}

TEST(TextTable, LargeIntegersAmongOtherNumbersAreRoundedWithAWarning) {
  for (const std::string_view file :
       {"x,y,z,t\n1,2,3,0.5\n1,2,3,1700000000123456789\n", "x,y,z,t\n1,2,3,1700000000123456789\n1,2,3,\n",
        "x,y,z,t\n1,2,3,99999999999999999999\n", "x,y,z,t\n1,2,3,-5\n1,2,3,18446744073709551615\n"}) {
    const LabeledCloud cloud = read_table(file);
    ASSERT_EQ(cloud.warnings.size(), 1U) << file;
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("integers beyond 2^53 of 't' are rounded"));
    EXPECT_EQ(cloud.attributes[0].type, ScalarType::kFloat64);
  }
  EXPECT_THAT(read_table("x,y,z,t\n1,2,3,1e300\n").warnings, IsEmpty());
}

TEST(TextTable, EachFaultNamesItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"1 2 3\n4 5\n", "line 2: the value of column 3 is missing"},
      {"x,y,z,r\n1,2,3,0\n4,5\n", "line 3: the value of 'z' is missing; nan stands for"},
      {"1 2 3\n4 5 6 7\n", "line 2: '7' is one value too many; the rows have 3"},
      {"1 2 3\n4 five 6\n", "line 2: 'five' is not a value of column 2"},
      {"x y z kind\n1 2 3 a\n1 b 3 a\n", "line 3: 'b' is not a value of 'y'"},
      {"x,y,z\n\"1,5\",2,3\n", "line 2: '1,5' has a decimal comma, but commas separate"},
      {"x y z\n5 2 3 4\n5 7 8 9\n", "line 2: '4' is one value too many"},
      {"x y z\n1.5 2 3 4\n2.5 7 8 9\n", "line 2: '4' is one value too many"},
      {"a,b,c\n1,2,3\n",
       "line 1 is neither numbers nor the names of columns, x, y and z among them: 'a,b,c'; names "
       "that are known are x y z, also with a unit as in x_mm"},
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
