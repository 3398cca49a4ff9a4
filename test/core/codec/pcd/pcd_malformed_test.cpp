// SPDX-License-Identifier: Apache-2.0
// Malformed PCD files. Each is refused with a message that names the fault, and none does harm.

#include <atomic>
#include <cstring>

#include "segserve/codec/pcd.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

struct Fault {
  std::string file;
  std::string words;
};

const std::string kFields = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
const std::string kTwoPoints = "WIDTH 2\nHEIGHT 1\nPOINTS 2\n";
const std::string kTwelve = std::string(12, '\0');

std::string compressed(std::uint32_t compressed_size, std::uint32_t size, const std::string& bytes) {
  std::string body(8, '\0');
  std::memcpy(body.data(), &compressed_size, 4);
  std::memcpy(body.data() + 4, &size, 4);
  return kFields + kTwoPoints + "DATA binary_compressed\n" + body + bytes;
}

std::vector<Fault> header_faults() {
  return {
      {"", "not a PCD file"},
      {"\n\n# only a comment\n", "not a PCD file"},
      {"\x89PNG\r\n\x1a\n garbage", "not a PCD file: line 1"},
      {kFields + kTwoPoints, "ends without a line DATA"},
      {kFields + kTwoPoints + "DATA bin", "ends without a line DATA"},
      {kFields + kTwoPoints + "DATA gzip\n", "DATA in line 7 is 'gzip'"},
      {kFields + kTwoPoints + "DATA\n", "DATA in line 7 is ''"},
      {kFields + "COLOR 1\n" + kTwoPoints + "DATA ascii\n", "line 4 begins with 'COLOR'"},
      {kFields + kTwoPoints + "WIDTH 2\nDATA ascii\n", "WIDTH occurs twice, in lines 4 and 7"},
      {kTwoPoints + "DATA ascii\n", "FIELDS is missing"},
      {"FIELDS x y z\nTYPE F F F\n" + kTwoPoints + "DATA ascii\n", "SIZE is missing"},
      {"FIELDS x y z\nSIZE 4 4 4\n" + kTwoPoints + "DATA ascii\n", "TYPE is missing"},
      {"FIELDS x y z\nSIZE 4 4\nTYPE F F F\n" + kTwoPoints + "DATA ascii\n",
       "SIZE in line 2 has 2 values for 3 FIELDS"},
      {kFields + "COUNT 1 1\n" + kTwoPoints + "DATA ascii\n", "COUNT in line 4 has 2 values for 3 FIELDS"},
      {kFields + "COUNT 1 1 0\n" + kTwoPoints + "DATA ascii\n", "COUNT of field 'z' is '0'"},
      {kFields + "COUNT 1 1 -1\n" + kTwoPoints + "DATA ascii\n", "COUNT of field 'z' is '-1'"},
      {kFields + "COUNT 1 1 2\n" + kTwoPoints + "DATA ascii\n", "FIELDS: 'z' must be one number for each point"},
      {kFields + "COUNT 1 1 1152921504606846976\n" + kTwoPoints + "DATA binary\n", "COUNT 1152921504606846976"},
      {"FIELDS x y z\nSIZE 4 4 2\nTYPE F F F\n" + kTwoPoints + "DATA ascii\n", "field 'z' has TYPE 'F' and SIZE '2'"},
      {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F Q\n" + kTwoPoints + "DATA ascii\n", "field 'z' has TYPE 'Q'"},
      {"FIELDS x y w\nSIZE 4 4 4\nTYPE F F F\n" + kTwoPoints + "DATA ascii\n", "FIELDS: x, y and z must be there"},
      {"FIELDS x y z x\nSIZE 4 4 4 4\nTYPE F F F F\n" + kTwoPoints + "DATA ascii\n", "'x' occurs twice"},
      {"FIELDS x y z rgb rgb\nSIZE 4 4 4 4 4\nTYPE F F F F F\n" + kTwoPoints + "DATA ascii\n", "'rgb' occurs twice"},
      {kFields + "DATA ascii\n", "POINTS and WIDTH are missing"},
      {kFields + "WIDTH 2\nHEIGHT 3\nPOINTS 7\nDATA ascii\n", "POINTS 7 is not WIDTH 2 x HEIGHT 3"},
      {kFields + "WIDTH -2\nDATA ascii\n", "WIDTH in line 4 must be one whole number"},
      {kFields + "WIDTH 99999999999999999999\nDATA ascii\n", "WIDTH in line 4 must be one whole number"},
      {kFields + "POINTS 1152921504606846976\nDATA binary\n", "WIDTH 1152921504606846976 x HEIGHT 1 exceeds"},
      {kFields + "WIDTH 4294967295\nHEIGHT 4294967295\nDATA binary\n", "exceed the limit of 64000000 points"},
      {kFields + "WIDTH 4294967296\nHEIGHT 4294967296\nPOINTS 0\nDATA binary\n", "exceeds the limit"},
      {kFields + "POINTS 64000001\nDATA binary\n", "64000001 points exceed the limit of 64000000 points"},
      {kFields + kTwoPoints + "VIEWPOINT 0 0 0\nDATA ascii\n", "VIEWPOINT in line 7 must be 7 finite numbers"},
      {kFields + kTwoPoints + "VIEWPOINT 0 0 nan 1 0 0 0\nDATA ascii\n", "VIEWPOINT in line 7"},
  };
}

std::vector<Fault> body_faults() {
  const std::string lzf_of_24 = compressed(26, 24, std::string(1, '\x17') + std::string(25, '\0'));
  return {
      {kFields + kTwoPoints + "DATA binary\n" + kTwelve, "it has 12 bytes, but POINTS 2 of 12 bytes each need more"},
      {kFields + kTwoPoints + "DATA ascii\n1.00 2.00 3.00\n\n", "ends after 1 of POINTS 2"},
      {kFields + kTwoPoints + "DATA ascii\n1\n", "it has 2 bytes, but POINTS 2 of 3 values each need more"},
      {kFields + kTwoPoints + "DATA ascii\n1 2 3\n\n4 5\n6 7 8\n",
       "line 10 has 2 values, but FIELDS and COUNT promise 3"},
      {kFields + kTwoPoints + "DATA ascii\n1 2 3\n4 5 6 7\n", "line 9 has more values than the 3"},
      {kFields + kTwoPoints + "DATA ascii\n1 2 3\n4 5 6,0\n",
       "line 9: '6,0' is not a value of field 'z' (a float of 4"},
      {kFields + kTwoPoints + "DATA ascii\n1 2 3\n4 5 +-6\n", "line 9: '+-6' is not a value of field 'z'"},
      {kFields + kTwoPoints + "DATA ascii\n1 2 3\n4 5 \x01\xff\n", "line 9: '?\?' is not a value"},
      {kFields + kTwoPoints + "DATA binary_compressed\n1234567", "it has 7 bytes, but binary_compressed begins with"},
      {compressed(100, 24, kTwelve), "claims 100 compressed bytes, but has 12"},
      {compressed(12, 25, kTwelve), "claims 25 bytes when decompressed, which is not POINTS 2 of 12"},
      {compressed(12, 36, kTwelve), "claims 36 bytes when decompressed, which is not POINTS 2 of 12"},
      {compressed(12, 4294967295U, kTwelve), "claims 4294967295 bytes when decompressed"},
      {compressed(0, 24, ""), "more than 0 compressed bytes can hold"},
      {compressed(12, 24, std::string(12, '\xff')), "the 12 compressed bytes are damaged"},
      {lzf_of_24, "are damaged"},
  };
}

TEST(PcdMalformed, EachFaultOfTheHeaderIsNamed) {
  for (const Fault& fault : header_faults()) {
    SCOPED_TRACE(fault.file);
    expect_fault(decode_pcd(bytes_of(fault.file), DecodeLimits{}).status(), fault.words);
  }
}

TEST(PcdMalformed, HeadersBeyondAllReasonAreRefused) {
  std::string fields = "FIELDS x y z", sizes = "SIZE 4 4 4", types = "TYPE F F F";
  for (int i = 3; i < 4097; ++i) fields += " _", sizes += " 1", types += " U";
  const std::string many = fields + "\n" + sizes + "\n" + types + "\n" + kTwoPoints + "DATA binary\n";
  expect_fault(decode_pcd(bytes_of(many), DecodeLimits{}).status(), "4097 FIELDS are more than the 4096");
  const std::string long_header = kFields + std::string(2'000'000, '\n') + kTwoPoints + "DATA ascii\n1 2 3\n4 5 6\n";
  expect_fault(decode_pcd(bytes_of(long_header), DecodeLimits{}).status(),
               "no line DATA is in the first 1048576 bytes");
  const std::string only_newlines(2'000'000, '\n');
  expect_fault(decode_pcd(bytes_of(only_newlines), DecodeLimits{}).status(), "not a PCD file");
}

TEST(PcdMalformed, LinesOfManyValuesAreStopped) {
  constexpr int kLines = 2, kPadding = 65'000;  // as many as a point may have
  std::string file = "FIELDS x y z _\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 65000\nPOINTS 2\nDATA ascii";
  for (int line = 0; line < kLines; ++line) {
    file += "\n1 2 3";
    for (int i = 0; i < kPadding; ++i) file += " 0";
  }
  const std::atomic<bool> cancelled = true;
  WorkMeter meter;
  const auto read = decode_pcd(bytes_of(file), {}, {}, StopToken(&cancelled, std::nullopt, &meter));
  EXPECT_EQ(read.status().code(), absl::StatusCode::kCancelled);
  EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
  EXPECT_TRUE(decode_pcd(bytes_of(file), {}).ok());
}

TEST(PcdMalformed, EachFaultOfTheBodyIsNamed) {
  for (const Fault& fault : body_faults()) {
    SCOPED_TRACE(fault.file);
    expect_fault(decode_pcd(bytes_of(fault.file), DecodeLimits{}).status(), fault.words);
  }
}

TEST(PcdMalformed, LimitsAreNamed) {
  const Sample sample = make_sample(1, 10, 10, true, true);
  const std::string file = encode_pcd(sample.cloud, sample.label, PcdEncoding::kBinaryCompressed);
  expect_over_limit(decode_pcd(bytes_of(file), {.max_points = 99}).status(), "max_points",
                    "PCD header: 100 points exceed the limit of 99 points");
  expect_over_limit(decode_pcd(bytes_of(file), {.max_bytes = 100}).status(), "max_bytes",
                    "bytes exceed the limit of 100 bytes");
  const std::string wide = kFields + "COUNT 1 1 1000\n" + kTwoPoints + "DATA binary\n";
  expect_over_limit(decode_pcd(bytes_of(wide), {.max_bytes = 4000}).status(), "max_bytes",
                    "COUNT 1000 of field 'z' makes one point larger than the limit of 4000 bytes");
  EXPECT_TRUE(decode_pcd(bytes_of(file), {.max_points = 100, .max_bytes = file.size()}).ok());
}

TEST(PcdMalformed, AFewBytesClaimNoMemory) {
  for (const char* points : {"0", "1"}) {
    const std::string file =
        std::string("VERSION 0.7\nFIELDS x y z f\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1000000000\nWIDTH ") +
        points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA ascii\n1 2 3\n";
    expect_fault(decode_pcd(bytes_of(file), {}, {.keep_everything = true}).status(),
                 "a point has more than 65536 numbers, 1000000000 of them in 'f'");
  }
}

TEST(PcdMalformed, ABodyThatDecompressesToMoreThanTheLimitIsRefused) {
  Cloud cloud;
  cloud.resize(1000, false);
  cloud.width = 1000;
  cloud.height = 1;
  const std::string file = encode_pcd(cloud, {}, PcdEncoding::kBinaryCompressed);
  ASSERT_LT(file.size(), 1000U);
  expect_over_limit(decode_pcd(bytes_of(file), {.max_bytes = 11999}).status(), "max_bytes",
                    "its decompressed 12000 bytes exceed the limit of 11999 bytes");
}

class PcdDamage : public testing::TestWithParam<PcdEncoding> {};

TEST_P(PcdDamage, TruncatedFilesAreRefused) {
  const Sample sample = make_sample(3, 7, 3, true, true);
  const std::string file = encode_pcd(sample.cloud, sample.label, GetParam());
  // A text that is cut within or behind its last number cannot be told from a whole one.
  const std::size_t surely_short = GetParam() == PcdEncoding::kAscii ? file.rfind(' ') + 1 : file.size() - 1;
  for (std::size_t size = 0; size <= surely_short; ++size) {
    const std::string part = file.substr(0, size);  // An allocation of its own lets ASan see a read beyond it.
    const auto read = decode_pcd(bytes_of(part), DecodeLimits{});
    EXPECT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument) << "at " << size << " bytes";
  }
  EXPECT_TRUE(decode_pcd(bytes_of(file), DecodeLimits{}).ok());
}

TEST_P(PcdDamage, FlippedBytesAreRefusedOrReadWithinBounds) {
  const Sample sample = make_sample(4, 9, 4, true, true);
  const std::string file = encode_pcd(sample.cloud, sample.label, GetParam());
  std::mt19937 random(5);
  const DecodeLimits limits{.max_points = 100'000, .max_bytes = 1'000'000};
  for (int round = 0; round < 20'000; ++round) {
    std::string damaged = file;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    const auto read = decode_pcd(bytes_of(damaged), limits);
    if (!read.ok()) {
      ASSERT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument);
      continue;
    }
    ASSERT_EQ(std::uint64_t{read->cloud.width} * read->cloud.height, read->cloud.size());
    ASSERT_TRUE(read->label.empty() || read->label.size() == read->cloud.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, PcdDamage,
                         testing::Values(PcdEncoding::kAscii, PcdEncoding::kBinary, PcdEncoding::kBinaryCompressed));

}  // namespace
}  // namespace segserve::codec
