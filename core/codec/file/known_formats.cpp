// SPDX-License-Identifier: Apache-2.0
#include "core/codec/file/known_formats.hpp"

#include <fmt/format.h>

#include <array>

#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

struct KnownFormat {
  std::string_view begin;  ///< of the file
  std::string_view name;
  std::string_view advice;
};

constexpr std::string_view kPdal = "pdal translate makes a LAS or PLY file of it";
constexpr std::string_view kUnpack = "unpack it first";
constexpr std::string_view kImage =
    "images of a camera need its intrinsics: segctl takes --depth, --rgb and --intrinsics, HTTP a form with the "
    "parts depth and color, and the parameter intrinsics";
constexpr std::string_view kMesh = "sample points on the mesh, or save its vertices as PLY";
constexpr std::string_view kSave = "save its points as PLY or CSV";
constexpr std::string_view kDownload =
    "open it in an editor or browser to see what it says, and download the file again";
constexpr std::string_view kSmallPly = "the first line must be ply in small letters";
constexpr std::string_view kUtf8 = "save it as UTF-8, for example by iconv -f UTF-16 -t UTF-8";
constexpr std::string_view kReplay = "segctl segment FILE reads one recording, but not from standard input";
constexpr std::string_view kRecording = "take the clouds out of it, or record them as MCAP, which segctl segment reads";

constexpr std::array<KnownFormat, 32> kFormats{{
    {"ASTM-E57"sv, "E57", kPdal},
    {"\x1f\x8b"sv, "gzip within a compressed file", kUnpack},
    {"\x28\xb5\x2f\xfd"sv, "zstd within a compressed file", kUnpack},
    {"\xfd"
     "7zXZ\0"sv,
     "xz", kUnpack},
    {"BZh"sv, "bzip2", kUnpack},
    {"\x04\x22\x4d\x18"sv, "lz4", kUnpack},
    {"version https://git-lfs"sv, "a pointer of Git LFS instead of the file", "git lfs pull fetches the file"},
    {"<!DOCTYPE"sv, "a page in HTML, perhaps of a failed download", kDownload},
    {"<!doctype"sv, "a page in HTML, perhaps of a failed download", kDownload},
    {"<html"sv, "a page in HTML, perhaps of a failed download", kDownload},
    {"<HTML"sv, "a page in HTML, perhaps of a failed download", kDownload},
    {"PLY\n"sv, "PLY in capitals", kSmallPly},
    {"PLY\r\n"sv, "PLY in capitals", kSmallPly},
    {"\x89MCAP0\r\n"sv, "MCAP", kReplay},
    {"#ROSBAG V"sv, "a ROS bag", kReplay},
    {"SQLite format 3\0"sv, "a SQLite file, as ROS 2 records", kRecording},
    {"glTF"sv, "glTF", kMesh},
    {"# vtk DataFile"sv, "VTK", kSave},
    {"<?xml"sv, "XML, perhaps VTK or COLLADA", kSave},
    {"<VTKFile"sv, "VTK", kSave},
    {"\x89HDF\r\n"sv, "HDF5", kSave},
    {"Kaydara FBX"sv, "FBX", kMesh},
    {"\xff\xfe"sv, "text in UTF-16", kUtf8},
    {"\xfe\xff"sv, "text in UTF-16", kUtf8},
    {"{"sv, "JSON, perhaps glTF", kMesh},
    {"OFF"sv, "OFF", kMesh},
    {"solid "sv, "STL", kMesh},
    {"\x89PNG\r\n"sv, "a PNG image", kImage},
    {"\xff\xd8\xff"sv, "a JPEG image", kImage},
    {"II*\0"sv, "a TIFF image", kImage},
    {"MM\0*"sv, "a TIFF image", kImage},
    {"DRACO"sv, "Draco", "decode it first; the codec draco sends clouds in it"},
}};

std::string unreadable(std::string_view name, std::string_view advice) {
  return fmt::format("this is {}, which cannot be read; {} can: {}", name, kReadableFormats, advice);
}

/// Binary STL has no magic: 80 bytes of anything, the number of triangles, and 50 bytes for each.
bool is_binary_stl(std::string_view file) {
  constexpr std::size_t kCount = 80, kHeader = 84, kTriangle = 50;
  if (file.size() <= kHeader) return false;
  const auto triangles = load<std::uint32_t>(reinterpret_cast<const std::byte*>(file.data() + kCount));
  return file.size() - kHeader == std::uint64_t{triangles} * kTriangle;
}

}  // namespace

std::optional<std::string> advice_on_format(std::string_view file) {
  for (const KnownFormat& format : kFormats) {
    if (file.starts_with(format.begin)) return unreadable(format.name, format.advice);
  }
  if (is_binary_stl(file)) return unreadable("STL", kMesh);
  return std::nullopt;
}

}  // namespace segserve::codec
