// SPDX-License-Identifier: Apache-2.0
// Malformed PLY files. Each is refused with a message that names the fault, and none does harm.

#include <limits>

#include "segserve/codec/ply.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

struct Fault {
  std::string file;
  std::string words;
};

const std::string kAscii = "ply\nformat ascii 1.0\n";
const std::string kBinary = "ply\nformat binary_little_endian 1.0\n";
const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kVertex = "element vertex 2\n" + kXyz;
const std::string kEnd = "end_header\n";

std::vector<Fault> header_faults() {
  return {
      {"plyformat ascii 1.0\n", "not a PLY file"},
      {kAscii + kVertex, "ends without a line 'end_header'"},
      {kAscii + kVertex + "end_header", "ends without a line 'end_header'"},
      {"ply\n" + kVertex + kEnd, "has no line 'format'"},
      {kAscii + "format ascii 1.0\n" + kVertex + kEnd, "'format' occurs twice, again in line 3"},
      {"ply\nformat binary_middle_endian 1.0\n" + kVertex + kEnd, "format in line 2 is 'binary_middle_endian'"},
      {"ply\nformat ascii 2.0\n" + kVertex + kEnd, "line 2 must be 'format NAME 1.0'"},
      {kAscii + "elephant 1\n" + kEnd, "line 3 begins with 'elephant'"},
      {kAscii + "element vertex\n" + kEnd, "line 3 must be 'element NAME COUNT'"},
      {kAscii + "element vertex -1\n" + kEnd, "line 3 must be 'element NAME COUNT'"},
      {kAscii + kXyz + kEnd, "the property in line 3 belongs to no element"},
      {kAscii + "element vertex 1\nproperty x\n" + kEnd, "line 4 must be 'property TYPE NAME'"},
      {kAscii + "element vertex 1\nproperty half x\n" + kEnd, "line 4: 'half' is not a type"},
      {kAscii + "element vertex 1\nproperty list float int x\n" + kEnd, "line 4: 'float' is not an integer type"},
      {kAscii + "element face 1\n" + kEnd, "has no element 'vertex'"},
      {kAscii + kVertex + kVertex + kEnd, "elements: 'vertex' occurs twice"},
      {kAscii + "element vertex 1\nproperty float x\nproperty float y\n" + kEnd,
       "properties of 'vertex': x, y and z must be there"},
      {kAscii + kVertex + "property float x\n" + kEnd, "properties of 'vertex': 'x' occurs twice"},
      {kAscii + "element vertex 1\nproperty list int float x\nproperty float y\nproperty float z\n" + kEnd,
       "properties of 'vertex': 'x' must be one number for each point"},
      {kAscii + "element vertex 1152921504606846976\n" + kXyz + kEnd,
       "1152921504606846976 points exceed the limit of 64000000 points"},
  };
}

std::vector<Fault> body_faults() {
  const std::string zeros(24, '\0');
  const std::string faces = "element face 1\nproperty list int int vertex_indices\n";
  return {
      {kAscii + kVertex + kEnd + "1 2 3\n", "it is too short for 2 rows of 'vertex'"},
      {kAscii + kVertex + kEnd + "1.0 2.0 3.0\n", "row 1 (counted from 0) of 'vertex': line 8: it ends too early"},
      {kAscii + kVertex + kEnd + "1 2 3\n4 5\n6 7\n", "line 9: the value of 'z' is missing"},
      {kAscii + kVertex + kEnd + "1 2 3\n4 5 6 7\n", "line 9: '7' is one value too many"},
      {kAscii + kVertex + kEnd + "1 2 3\n4 five 6\n", "line 9: 'five' is not a value of 'y'"},
      {kAscii + faces + kVertex + kEnd + "-3 0 0 0\n1 2 3\n4 5 6\n", "'-3' is not the length of the list"},
      {kAscii + faces + kVertex + kEnd + "999999999999 0\n1 2 3\n4 5 6\n", "the list 'vertex_indices' is too short"},
      {kBinary + kVertex + kEnd + zeros.substr(1), "it is too short for 2 rows of 'vertex'"},
      {kBinary + "element face 1152921504606846976\nproperty uchar a\n" + kVertex + kEnd + zeros,
       "it is too short for 1152921504606846976 rows of 'face'"},
      {kBinary + faces + kVertex + kEnd + "\xff\xff\xff\xff" + zeros, "row 0 (counted from 0) of 'face'"},
      {kBinary + faces + kVertex + kEnd + "\xff\xff\xff\x7f" + zeros, "the length of a list is wrong"},
  };
}

TEST(PlyMalformed, EachFaultOfTheHeaderIsNamed) {
  for (const Fault& fault : header_faults()) {
    SCOPED_TRACE(fault.file);
    expect_fault(decode_ply(bytes_of(fault.file), DecodeLimits{}).status(), fault.words);
  }
}

TEST(PlyMalformed, HeadersBeyondAllReasonAreRefused) {
  std::string many = kAscii + kVertex;
  for (int i = 4; i < 4097; ++i) many += "property uchar p\n";
  expect_fault(decode_ply(bytes_of(many + kEnd), DecodeLimits{}).status(),
               "line 4099 is one more than the 4096 elements and properties");
  const std::string long_header = kAscii + std::string(2'000'000, '\n') + kVertex + kEnd + "1 2 3\n4 5 6\n";
  expect_fault(decode_ply(bytes_of(long_header), DecodeLimits{}).status(),
               "no line 'end_header' is in the first 1048576 bytes");
}

TEST(PlyMalformed, EachFaultOfTheBodyIsNamed) {
  for (const Fault& fault : body_faults()) {
    SCOPED_TRACE(fault.file);
    expect_fault(decode_ply(bytes_of(fault.file), DecodeLimits{}).status(), fault.words);
  }
}

TEST(PlyMalformed, MoreVerticesThanAWidthHoldsAreRefused) {
  const std::string file = kBinary + "element vertex 4294967296\n" + kXyz + kEnd;
  const std::uint64_t all = std::numeric_limits<std::uint64_t>::max();
  expect_fault(decode_ply(bytes_of(file), {.max_points = all}).status(), "element vertex 4294967296 does not fit");
}

TEST(PlyMalformed, LimitsAreNamed) {
  const std::string file = encode_ply(make_sample(1, 10, 10, true, true).cloud, {}, PlyEncoding::kBinaryLittleEndian);
  expect_over_limit(decode_ply(bytes_of(file), {.max_points = 99}).status(), "max_points",
                    "PLY header: 100 points exceed the limit of 99 points");
  expect_over_limit(decode_ply(bytes_of(file), {.max_bytes = 100}).status(), "max_bytes",
                    "bytes exceed the limit of 100 bytes");
}

class PlyDamage : public testing::TestWithParam<PlyEncoding> {};

TEST_P(PlyDamage, TruncatedFilesAreRefused) {
  const Sample sample = make_sample(3, 7, 3, true, true);
  const std::string file = encode_ply(sample.cloud, sample.label, GetParam());
  // A text that is cut within or behind its last number cannot be told from a whole one.
  const std::size_t surely_short = GetParam() == PlyEncoding::kAscii ? file.rfind(' ') + 1 : file.size() - 1;
  for (std::size_t size = 0; size <= surely_short; ++size) {
    const std::string part = file.substr(0, size);  // An allocation of its own lets ASan see a read beyond it.
    const auto read = decode_ply(bytes_of(part), DecodeLimits{});
    EXPECT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument) << "at " << size << " bytes";
  }
  EXPECT_TRUE(decode_ply(bytes_of(file), DecodeLimits{}).ok());
}

TEST_P(PlyDamage, FlippedBytesAreRefusedOrReadWithinBounds) {
  const Sample sample = make_sample(4, 9, 4, true, true);
  std::string file = encode_ply(sample.cloud, sample.label, GetParam());
  const std::string list = "property list uchar int neighbors\n";
  file.insert(file.find("end_header"), list);  // The length of the list is read from the bytes of the next point.
  std::mt19937 random(5);
  const DecodeLimits limits{.max_points = 100'000, .max_bytes = 1'000'000};
  for (int round = 0; round < 20'000; ++round) {
    std::string damaged = file;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    const auto read = decode_ply(bytes_of(damaged), limits);
    if (!read.ok()) {
      ASSERT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument);
      continue;
    }
    ASSERT_TRUE(read->label.empty() || read->label.size() == read->cloud.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, PlyDamage, testing::Values(PlyEncoding::kAscii, PlyEncoding::kBinaryLittleEndian));

}  // namespace
}  // namespace segserve::codec
