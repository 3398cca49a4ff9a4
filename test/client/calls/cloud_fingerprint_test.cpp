// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/cloud_fingerprint.hpp"

#include <limits>

#include "gtest/gtest.h"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

TEST(CloudFingerprint, IsThatOfTheDocumentedBytes) {
  Cloud cloud;
  cloud.x = {1.0F}, cloud.y = {2.0F}, cloud.z = {-0.5F}, cloud.rgb = {0xff123456U};
  cloud.width = cloud.height = 1;
  // zlib.crc32(struct.pack("<3f", 1, 2, -0.5)), zlib.crc32(bytes([0x56, 0x34, 0x12, 0]))
  EXPECT_EQ(fingerprint(cloud), (CloudFingerprint{0x6f753639U, 0x94b4b2fdU}));
  cloud.y[0] = std::numeric_limits<float>::infinity();
  cloud.rgb.clear();
  // zlib.crc32(struct.pack("<3I", *[0x7fc00000] * 3))
  EXPECT_EQ(fingerprint(cloud), (CloudFingerprint{0x4d5a1683U, 0}));
}

TEST(CloudFingerprint, SeesEveryPointAndEveryColor) {
  const Cloud scene = table_scene();
  const CloudFingerprint print = fingerprint(scene);
  for (const std::size_t i : {std::size_t{0}, scene.size() / 2, scene.size() - 1}) {
    Cloud other = scene;
    other.x[i] = other.y[i] = other.z[i] = 0.5F;
    EXPECT_NE(fingerprint(other).coordinates, print.coordinates);
    EXPECT_EQ(fingerprint(other).colors, print.colors);
    other = scene;
    other.rgb[i] ^= 1U;
    EXPECT_EQ(fingerprint(other).coordinates, print.coordinates);
    EXPECT_NE(fingerprint(other).colors, print.colors);
  }
}

TEST(CloudFingerprint, DoesNotDependOnTheFormat) {
  const Cloud scene = table_scene();
  for (const auto encoding : {codec::PcdEncoding::kAscii, codec::PcdEncoding::kBinaryCompressed}) {
    const std::string bytes = codec::encode_pcd(scene, {}, encoding);
    EXPECT_EQ(fingerprint(codec::decode_pcd(std::as_bytes(std::span(bytes)), {})->cloud), fingerprint(scene));
  }
  const std::string bytes = codec::encode_ply(scene, {}, codec::PlyEncoding::kAscii);
  EXPECT_EQ(fingerprint(codec::decode_ply(std::as_bytes(std::span(bytes)), {})->cloud), fingerprint(scene));
}

}  // namespace
}  // namespace segserve::client
