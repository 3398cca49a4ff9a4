// SPDX-License-Identifier: Apache-2.0
#include "core/codec/file/known_formats.hpp"

#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

TEST(KnownFormats, AreNamed) {
  const std::vector<std::pair<std::string_view, std::string_view>> cases{
      {"ASTM-E57\1\0"sv, "E57"},
      {"\x1f\x8b\x08"sv, "gzip within"},
      {"\x89MCAP0\r\n"sv, "MCAP"},
      {"solid cube\n"sv, "STL"},
      {"\x04\x22\x4d\x18\x64"sv, "lz4"},
      {"version https://git-lfs.github.com/spec/v1\n"sv, "a pointer of Git LFS"},
      {"<!DOCTYPE html>\n<html>"sv, "a page in HTML"},
      {"<html><body>"sv, "a page in HTML"},
      {"PLY\nformat ascii 1.0\n"sv, "PLY in capitals"},
      {"OFF\n8 6 12\n"sv, "OFF"},
      {"# vtk DataFile Version 3.0\n"sv, "VTK"},
      {"<?xml version=\"1.0\"?>"sv, "XML"},
      {"\xff\xfex\0"sv, "text in UTF-16"},
      {"\x89HDF\r\n\x1a\n"sv, "HDF5"},
      {"II*\0"sv, "a TIFF image"}};
  for (const auto& [file, name] : cases) {
    const auto advice = advice_on_format(file);
    ASSERT_TRUE(advice) << name;
    EXPECT_THAT(*advice, testing::HasSubstr(std::string(name)));
    EXPECT_THAT(*advice, testing::HasSubstr(std::string(kReadableFormats) + " can: "));
  }
}

TEST(KnownFormats, FormatsThatAreReadAndNonsenseAreNone) {
  for (const std::string_view file : {"# .PCD v0.7\nVERSION 0.7\n"sv, "FIELDS x y z\n"sv, "ply\nformat"sv, ""sv,
                                      "hello"sv, "1 2\n"sv, "1 2 3\n"sv, "v 1 2 3\n"sv, "LASF"sv, "\0\0\0\0"sv}) {
    EXPECT_FALSE(advice_on_format(file)) << file;
  }
}

}  // namespace
}  // namespace segserve::codec
