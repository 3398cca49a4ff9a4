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
  const std::string tar = "scan.ply" + std::string(249, '\0') + "ustar";
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
      {"II*\0"sv, "a TIFF image"},
      {"COFF\n8 6 0\n"sv, "OFF with colors"},
      {"\x76\x2f\x31\x01\2\0\0\0"sv, "OpenEXR"},
      {"RIFF\x24\0\0\0WEBPVP8 "sv, "WebP"},
      {"RIFF\x24\0\0\0AVI LIST"sv, "AVI"},
      {"\0\0\0\x24"
       "ftypheic\0\0"sv,
       "HEIC"},
      {"\0\0\0\x20"
       "ftypisom\0\0"sv,
       "MP4"},
      {"\x1a\x45\xdf\xa3\x9f"sv, "Azure Kinect"},
      {"7z\xbc\xaf\x27\x1c\0\4"sv, "7z"},
      {"\xd4\xc3\xb2\xa1\2\0\4\0"sv, "pcap"},
      {"\x0a\x0d\x0d\x0a\x1c\0"sv, "pcapng"},
      {"MATLAB 5.0 MAT-file, Platform"sv, "MATLAB"},
      {"PAR1\x15\4"sv, "Parquet"},
      {"\x80\x04\x95"sv, "pickle"},
      {"CCB2\x2a"sv, "CloudCompare"},
      {"#VRML V2.0 utf8\n"sv, "VRML"},
      {"  0\r\nSECTION\r\n  2\r\nHEADER\r\n"sv, "DXF"},
      {"ncols 24\nnrows 24\n"sv, "raster of heights"},
      {"\0\5\x16\7\0\2\0\0"sv, "macOS"},
      {tar, "a tar archive"}};
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
