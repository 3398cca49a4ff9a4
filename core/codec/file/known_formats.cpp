// SPDX-License-Identifier: Apache-2.0
#include "core/codec/file/known_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

struct KnownFormat {
  std::string_view begin;  ///< of the file
  std::string_view name;
  std::string_view advice;
};

constexpr std::string_view kPdal = "pdal translate makes a PLY file of it";
constexpr std::string_view kUnpack = "unpack it first";
constexpr std::string_view kImage = "the options --depth, --rgb and --intrinsics take images";
constexpr std::string_view kMesh = "sample points on the mesh, or save its vertices as PLY";
constexpr std::string_view kRecording = "take the clouds out of it, as PCD or PLY files";

constexpr std::array<KnownFormat, 17> kFormats{{
    {"LASF"sv, "LAS or LAZ", kPdal},
    {"ASTM-E57"sv, "E57", kPdal},
    {"\x1f\x8b"sv, "gzip", kUnpack},
    {"\x28\xb5\x2f\xfd"sv, "zstd", kUnpack},
    {"\xfd"
     "7zXZ\0"sv,
     "xz", kUnpack},
    {"BZh"sv, "bzip2", kUnpack},
    {"PK\3\4"sv, "a zip archive", kUnpack},
    {"\x93NUMPY"sv, "NumPy's NPY", "write it as PLY or PCD"},
    {"\x89MCAP0\r\n"sv, "MCAP", kRecording},
    {"#ROSBAG V"sv, "a ROS bag", kRecording},
    {"SQLite format 3\0"sv, "a SQLite file, as ROS 2 records", kRecording},
    {"glTF"sv, "glTF", kMesh},
    {"OFF"sv, "OFF", kMesh},
    {"solid "sv, "STL", kMesh},
    {"\x89PNG\r\n"sv, "a PNG image", kImage},
    {"\xff\xd8\xff"sv, "a JPEG image", kImage},
    {"DRACO"sv, "Draco", "decode it first; --codec draco sends clouds in it"},
}};

std::string unreadable(std::string_view name, std::string_view advice) {
  return fmt::format("this is {}, which cannot be read; PCD and PLY can: {}", name, advice);
}

bool is_number(std::string_view word) {
  double value = 0;
  return parse_scalar(word, ScalarType::kFloat64, reinterpret_cast<std::byte*>(&value));
}

/// The first line that has anything in it but a comment. It may end within a word.
std::string_view first_line(std::string_view file) {
  constexpr std::size_t kEnough = 4096;
  LineReader lines(without_byte_order_mark(file.substr(0, kEnough)));
  while (const auto line = lines.next()) {
    if (!is_blank(line->text) && !line->text.starts_with('#')) return line->text;
  }
  return {};
}

}  // namespace

std::optional<std::string> advice_on_format(std::string_view file) {
  for (const KnownFormat& format : kFormats) {
    if (file.starts_with(format.begin)) return unreadable(format.name, format.advice);
  }
  std::string line(first_line(file));
  std::ranges::replace_if(
      line, [](char c) { return c == ',' || c == ';'; }, ' ');
  const auto words = split_words(line);
  if (words.size() >= 3 && (words[0] == "v" || words[0] == "vn" || words[0] == "o" || words[0] == "g") &&
      std::ranges::all_of(words.begin() + 1, words.end(), is_number)) {
    return unreadable("OBJ", kMesh);
  }
  if (words.size() >= 3 && std::ranges::all_of(words, is_number)) {
    return unreadable("a table of numbers, such as XYZ, PTS or CSV", "write a header of PLY or PCD in front of it");
  }
  return std::nullopt;
}

}  // namespace segserve::codec
