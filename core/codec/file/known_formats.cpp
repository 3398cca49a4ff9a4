// SPDX-License-Identifier: Apache-2.0
#include "core/codec/file/known_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

struct KnownFormat {
  std::string_view signature;  ///< at the beginning of the file, or at `offset`
  std::string_view name;
  std::string_view advice;
  std::size_t offset = 0;
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

constexpr std::string_view kArchive = "unpack it, and take the file of a cloud in it";
constexpr std::string_view kArrays = "save the points as NPY, CSV or PLY in the program that made it";
constexpr std::string_view kPackets = "the software of the LiDAR makes PCD, LAS or CSV of its packets";
constexpr std::string_view kVideo =
    "take depth and color images out of it as PNG; segctl takes them by --depth, --rgb and --intrinsics";
constexpr std::string_view kPicture =
    "save images of a camera as PNG, depth with 16 bits; segctl takes them by --depth, --rgb and --intrinsics";
constexpr std::string_view kSplats = "save the splats as PLY, whose centers and colors are read";
constexpr std::string_view kOtherFile = "take another file";

constexpr std::array<KnownFormat, 83> kFormats{{
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
    {"COFF"sv, "OFF with colors", kMesh},
    {"NOFF"sv, "OFF with normals", kMesh},
    {"CNOFF"sv, "OFF with colors and normals", kMesh},
    {"solid "sv, "STL", kMesh},
    {"\x89PNG\r\n"sv, "a PNG image", kImage},
    {"\xff\xd8\xff"sv, "a JPEG image", kImage},
    {"II*\0"sv, "a TIFF image", kImage},
    {"MM\0*"sv, "a TIFF image", kImage},
    {"II+\0"sv, "a TIFF image", kPicture},
    {"MM\0+"sv, "a TIFF image", kPicture},
    {"\x76\x2f\x31\x01"sv, "an OpenEXR image", kPicture},
    {"BM"sv, "a BMP image", kPicture},
    {"GIF8"sv, "a GIF image", kPicture},
    {"WEBP"sv, "a WebP image", kPicture, 8},
    {"#?RADIANCE"sv, "a Radiance HDR image", kPicture},
    {"\0\0\0\x0cjP  "sv, "a JPEG 2000 image", kPicture},
    {"ftypheic"sv, "a HEIC image", kPicture, 4},
    {"ftypmif1"sv, "a HEIC image", kPicture, 4},
    {"ftypavif"sv, "an AVIF image", kPicture, 4},
    {"DICM"sv, "a DICOM image", kPicture, 128},
    {"ftyp"sv, "a video in MP4", kVideo, 4},
    {"AVI "sv, "a video in AVI", kVideo, 8},
    {"\x1a\x45\xdf\xa3"sv, "a video in Matroska, as Azure Kinect records", kVideo},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7z archive", kArchive},
    {"Rar!\x1a\x07"sv, "a RAR archive", kArchive},
    {"ustar"sv, "a tar archive", kArchive, 257},
    {"LZIP"sv, "lzip", kUnpack},
    {"\x1f\x9d"sv, "a file of compress (.Z)", kUnpack},
    {"\xd4\xc3\xb2\xa1"sv, "a capture of network packets (pcap)", kPackets},
    {"\xa1\xb2\xc3\xd4"sv, "a capture of network packets (pcap)", kPackets},
    {"\x4d\x3c\xb2\xa1"sv, "a capture of network packets (pcap)", kPackets},
    {"\x0a\x0d\x0d\x0a"sv, "a capture of network packets (pcapng)", kPackets},
    {"MATLAB "sv, "a MAT file of MATLAB", kArrays},
    {"PAR1"sv, "Parquet", kArrays},
    {"ARROW1"sv, "Arrow, as Feather writes it", kArrays},
    {"FEA1"sv, "Feather", kArrays},
    {"\x80\x02"sv, "a pickle of Python", kArrays},
    {"\x80\x03"sv, "a pickle of Python", kArrays},
    {"\x80\x04"sv, "a pickle of Python", kArrays},
    {"\x80\x05"sv, "a pickle of Python", kArrays},
    {"%YAML"sv, "YAML", kArrays},
    {"CCB2"sv, "a BIN file of CloudCompare", "save it there as PLY or LAS"},
    {"pnts"sv, "a tile of 3D Tiles", kSave},
    {"b3dm"sv, "a tile of 3D Tiles", kMesh},
    {"NGSP"sv, "SPZ, Gaussian splats", kSplats},
    {"PXR-USDC"sv, "USD", kMesh},
    {"#usda"sv, "USD", kMesh},
    {"#VRML"sv, "VRML", kMesh},
    {"ISO-10303-21"sv, "STEP", kMesh},
    {"BLENDER"sv, "a file of Blender", kMesh},
    {"3D Geometry File Format"sv, "a file of Rhino", kMesh},
    {"AC10"sv, "DWG", kSave},
    {"ncols"sv, "a raster of heights of Esri (ASCII grid)", "gdal2xyz.py makes a table of x, y and z of it"},
    {"NCOLS"sv, "a raster of heights of Esri (ASCII grid)", "gdal2xyz.py makes a table of x, y and z of it"},
    {"%PDF-"sv, "a PDF", kOtherFile},
    {"\0\5\x16\7"sv, "a file in which macOS keeps attributes of another one",
     "take that one, without ._ in front of its name"},
    {"DRACO"sv, "Draco", "decode it first; the codec draco sends clouds in it"},
}};

const KnownFormat* find_format(std::string_view file) {
  const auto* const found = std::ranges::find_if(kFormats, [file](const KnownFormat& format) {
    return file.substr(std::min(file.size(), format.offset)).starts_with(format.signature);
  });
  return found == kFormats.end() ? nullptr : found;
}

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

/// DXF in text begins with the code 0 and the word SECTION, each on a line.
bool is_dxf(std::string_view file) {
  constexpr std::size_t kEnough = 64;
  std::string_view begin = file.substr(0, kEnough);
  return take_word(begin) == "0" && take_word(begin) == "SECTION";
}

}  // namespace

std::string_view format_name(std::string_view file) {
  const KnownFormat* const format = find_format(file);
  return format == nullptr ? std::string_view() : format->name;
}

std::optional<std::string> advice_on_format(std::string_view file) {
  if (const KnownFormat* const format = find_format(file)) return unreadable(format->name, format->advice);
  if (is_dxf(file)) return unreadable("DXF", kSave);
  if (is_binary_stl(file)) return unreadable("STL", kMesh);
  return std::nullopt;
}

}  // namespace segserve::codec
