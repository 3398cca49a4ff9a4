// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/field_roles.hpp"

#include "gmock/gmock.h"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<Field> fields_of(const std::vector<std::string_view>& names, ScalarType type = ScalarType::kFloat32) {
  std::vector<Field> fields;
  for (const std::string_view name : names) fields.push_back({name, type, true});
  return fields;
}

struct Found {
  FieldRoles roles;
  std::vector<Warning> warnings;
};

Found find(const std::vector<Field>& fields) {
  Found found;
  auto roles = find_field_roles(fields, found.warnings);
  EXPECT_TRUE(roles.ok()) << roles.status();
  if (roles.ok()) found.roles = *roles;
  return found;
}

TEST(FieldRoles, NamesCountInAnyCaseAndTheUsualCaseComesFirst) {
  EXPECT_THAT(find(fields_of({"X", "Y", "Z"})).roles.position, ElementsAre(0, 1, 2));
  EXPECT_THAT(find(fields_of({"X", "Y", "Z", "x", "y", "z"})).roles.position, ElementsAre(3, 4, 5));
  EXPECT_EQ(find(fields_of({"x", "y", "z", "Scalar_label"})).roles.label, 3U);
}

TEST(FieldRoles, ColorsHaveManyNames) {
  for (const auto& [red, green, blue] :
       std::vector<std::array<std::string_view, 3>>{{"r", "g", "b"},
                                                    {"R", "G", "B"},
                                                    {"Red", "Green", "Blue"},
                                                    {"diffuse_red", "diffuse_green", "diffuse_blue"},
                                                    {"color_r", "color_g", "color_b"},
                                                    {"c_r", "c_g", "c_b"},
                                                    {"ColorR", "ColorG", "ColorB"},
                                                    {"vertex_red", "vertex_green", "vertex_blue"},
                                                    {"R8", "G8", "B8"},
                                                    {"R255", "G255", "B255"},
                                                    {"r_channel", "g_channel", "b_channel"},
                                                    {"Col.r", "Col.g", "Col.b"},
                                                    {"R_8bit", "G_8bit", "B_8bit"},
                                                    {"RGB_0", "RGB_1", "RGB_2"},
                                                    {"rgb[0]", "rgb[1]", "rgb[2]"},
                                                    {"color_1", "color_2", "color_3"},
                                                    {"Colors:0", "Colors:1", "Colors:2"},
                                                    {"rgba.0", "rgba.1", "rgba.2"},
                                                    {"Rot", "Grün", "Blau"},
                                                    {"Rouge", "Vert", "Bleu"},
                                                    {"rojo", "verde", "azul"},
                                                    {"赤", "緑", "青"}}) {
    const Found found = find(fields_of({"x", "y", "z", blue, green, red}));
    ASSERT_TRUE(found.roles.channels) << red;
    EXPECT_THAT(*found.roles.channels, ElementsAre(5, 4, 3));
    EXPECT_EQ(found.roles.channel_kind, ChannelKind::kIntensity);
    EXPECT_TRUE(found.warnings.empty());
  }
  EXPECT_EQ(find(fields_of({"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"})).roles.channel_kind,
            ChannelKind::kSphericalHarmonic);
  EXPECT_EQ(find(fields_of({"x", "y", "z", "RGBA"})).roles.packed, 3U);
}

TEST(FieldRoles, ColorsInOneNumberArePacked) {
  for (const ScalarType type : {ScalarType::kInt32, ScalarType::kInt64, ScalarType::kUint64, ScalarType::kFloat64}) {
    EXPECT_EQ(find(fields_of({"x", "y", "z", "rgb"}, type)).roles.packed, 3U);
  }
}

TEST(FieldRoles, ColorsInOneFieldAreThreeOrFourNumbers) {
  struct Case {
    std::string_view name;
    std::size_t count;
    bool is_reversed, is_told;
  };
  for (const Case& c : std::vector<Case>{{"rgb", 3, false, false},
                                         {"rgb", 4, false, true},
                                         {"RGBA", 4, false, false},
                                         {"bgr", 3, true, false},
                                         {"bgra", 4, true, false},
                                         {"color", 3, false, false},
                                         {"Colors", 4, false, true}}) {
    for (const ScalarType type : {ScalarType::kUint8, ScalarType::kFloat32}) {
      std::vector<Field> fields = fields_of({"x", "y", "z", c.name}, type);
      fields[3].count = c.count;
      const Found found = find(fields);
      EXPECT_EQ(found.roles.color_vector, 3U) << c.name;
      EXPECT_EQ(found.roles.color_vector_is_reversed, c.is_reversed) << c.name;
      EXPECT_THAT(found.roles.fields(), ElementsAre(0, 1, 2, 3));
      EXPECT_EQ(found.warnings.size(), c.is_told ? 1U : 0U) << c.name;
    }
  }
  EXPECT_FALSE(find(fields_of({"x", "y", "z", "color"})).roles.has_color()) << "one number is no color";
}

TEST(FieldRoles, AColorThatCannotBeUsedIsMentioned) {
  std::vector<Field> fields = fields_of({"x", "y", "z", "rgb", "intensity"});
  fields[3].type = ScalarType::kUint8;
  fields[3].count = 2;
  const Found found = find(fields);
  EXPECT_FALSE(found.roles.has_color());
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_EQ(found.warnings[0].reason, WarningReason::kColorNotUsed);
  EXPECT_THAT(found.warnings[0].message, HasSubstr("'rgb' cannot be used"));
  EXPECT_EQ(find(fields_of({"x", "y", "z", "red", "green"})).warnings.size(), 1U);
  for (const std::string_view name : {"vertexRed", "my_colour", "Kd.g", "rgb8", "f_dc_1", "basecolor"}) {
    const Found other = find(fields_of({"x", "y", "z", name, name == "Kd.g" ? "Kd.b" : "time"}));
    EXPECT_EQ(other.warnings.size(), 1U) << name;
  }
}

TEST(FieldRoles, WordsThatOnlyEndLikeColorsAreNone) {
  for (const std::string_view name : {"intensity", "ring", "r", "DESTAGGERED COLUMN", "filtered", "infrared",
                                      "evergreen", "is_registered", "range_r"}) {
    EXPECT_TRUE(find(fields_of({"x", "y", "z", name})).warnings.empty()) << name;
  }
}

TEST(FieldRoles, ACoordinateIsOneNumberThatOccursOnce) {
  std::vector<Warning> warnings;
  std::vector<Field> fields = fields_of({"x", "y", "z"});
  fields[1].count = 0;
  EXPECT_THAT(std::string(find_field_roles(fields, warnings).status().message()), HasSubstr("'y' must be one number"));
  EXPECT_FALSE(find_field_roles(fields_of({"x", "y"}), warnings).ok());
  EXPECT_FALSE(find_field_roles(fields_of({"x", "x", "y", "z"}), warnings).ok());
}

TEST(FieldRoles, CoordinatesHaveOneUnit) {
  std::vector<Warning> warnings;
  EXPECT_EQ(find(fields_of({"x_mm", "y_mm", "z_mm"})).roles.unit, LengthUnit::kMillimeter);
  expect_fault(find_field_roles(fields_of({"x_mm", "y_mm", "z_m"}), warnings).status(),
               "the units of 'x_mm', 'y_mm' and 'z_m' differ; give all three the same one");
}

TEST(FieldRoles, APointHasABoundedNumberOfNumbers) {
  std::vector<Warning> warnings;
  std::vector<Field> fields = fields_of({"x", "y", "z", "a", "b"});
  fields[3].count = fields[4].count = 32000;
  EXPECT_TRUE(find_field_roles(fields, warnings).ok());
  fields[4].count = 40000;
  EXPECT_THAT(std::string(find_field_roles(fields, warnings).status().message()),
              HasSubstr("a point has more than 65536 numbers, 40000 of them in 'b'"));
}

TEST(WarningReason, NamesReadBack) {
  for (const WarningReason reason : {WarningReason::kColorNotUsed, WarningReason::kLabelNotUsed,
                                     WarningReason::kRowsNotUsed, WarningReason::kOther}) {
    EXPECT_EQ(warning_reason(name(reason)), reason);
  }
  EXPECT_EQ(warning_reason("OF_A_LATER_VERSION"), WarningReason::kOther);
}

}  // namespace
}  // namespace segserve::codec
