// SPDX-License-Identifier: Apache-2.0
// Our reader and writer agree with those of PCL, in both directions and for every encoding.

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/pcd.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

class PclOracle : public testing::TestWithParam<PcdEncoding> {
 protected:
  void SetUp() override {
    // Other tests, and other runs of this one, have files of their own.
    path_ = testing::TempDir() + "segserve_pcl_oracle_" + std::to_string(getpid()) + ".pcd";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void write_ours(const Sample& sample) const {
    std::ofstream(path_, std::ios::binary) << encode_pcd(sample.cloud, sample.label, GetParam());
  }
  template <typename PointT>
  void write_pcls(const ::pcl::PointCloud<PointT>& cloud) const {
    ::pcl::PCDWriter writer;
    constexpr int kDigits = 9;  // These suffice for every float.
    const int status = GetParam() == PcdEncoding::kAscii    ? writer.writeASCII(path_, cloud, kDigits)
                       : GetParam() == PcdEncoding::kBinary ? writer.writeBinary(path_, cloud)
                                                            : writer.writeBinaryCompressed(path_, cloud);
    ASSERT_EQ(status, 0);
  }

  std::string path_;
};

/// A sample without infinities and denormals, which PCL cannot read from text.
Sample plain_sample(std::uint32_t width, std::uint32_t height) {
  Sample sample = make_sample(11, width, height, true, true);
  for (auto* plane : {&sample.cloud.x, &sample.cloud.y, &sample.cloud.z}) {
    for (float& value : *plane) {
      if (!std::isnormal(value) && !std::isnan(value)) value = 0.125F;
    }
  }
  sample.cloud.view = View::world(1.5F, -2.25F, 0.1F);
  return sample;
}

template <typename PointT>
void expect_pcl_has(const ::pcl::PointCloud<PointT>& actual, const Cloud& expected) {
  ASSERT_EQ(actual.width, expected.width);
  ASSERT_EQ(actual.height, expected.height);
  std::vector<float> x, y, z;
  std::vector<std::uint32_t> rgb;
  for (const auto& p : actual) {
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
    rgb.push_back(pack_rgb(p.r, p.g, p.b));
  }
  EXPECT_EQ(bits(x), bits(expected.x));
  EXPECT_EQ(bits(y), bits(expected.y));
  EXPECT_EQ(bits(z), bits(expected.z));
  EXPECT_EQ(rgb, expected.rgb);
}

TEST_P(PclOracle, PclReadsWhatWeWrite) {
  const Sample sample = plain_sample(23, 9);
  write_ours(sample);
  ::pcl::PointCloud<::pcl::PointXYZRGBL> labeled;
  ASSERT_EQ(::pcl::io::loadPCDFile(path_, labeled), 0);
  expect_pcl_has(labeled, sample.cloud);
  for (std::size_t i = 0; i < labeled.size(); ++i) EXPECT_EQ(labeled[i].label, sample.label[i]) << i;
  EXPECT_EQ(labeled.sensor_origin_.head<3>(), *sample.cloud.view.sensor);
  EXPECT_TRUE(labeled.sensor_orientation_.isApprox(Eigen::Quaternionf::Identity()));
}

TEST_P(PclOracle, PclReadsOurColorsAsRgbAndAsRgba) {
  Sample sample = plain_sample(31, 1);
  sample.label.clear();
  write_ours(sample);
  ::pcl::PointCloud<::pcl::PointXYZRGB> rgb;
  ASSERT_EQ(::pcl::io::loadPCDFile(path_, rgb), 0);
  expect_pcl_has(rgb, sample.cloud);
  ::pcl::PointCloud<::pcl::PointXYZRGBA> rgba;
  ASSERT_EQ(::pcl::io::loadPCDFile(path_, rgba), 0);
  expect_pcl_has(rgba, sample.cloud);
}

template <typename PointT>
::pcl::PointCloud<PointT> to_pcl(const Sample& sample) {
  ::pcl::PointCloud<PointT> cloud(sample.cloud.width, sample.cloud.height);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud[i].x = sample.cloud.x[i];
    cloud[i].y = sample.cloud.y[i];
    cloud[i].z = sample.cloud.z[i];
    cloud[i].rgba = 0xFF000000U | sample.cloud.rgb[i];
  }
  cloud.sensor_origin_.template head<3>() = *sample.cloud.view.sensor;
  return cloud;
}

TEST_P(PclOracle, WeReadWhatPclWrites) {
  const Sample sample = plain_sample(19, 12);
  write_pcls(to_pcl<::pcl::PointXYZRGB>(sample));
  const auto read = load_cloud(path_);
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
  EXPECT_EQ(read->cloud.width, 19U);
  EXPECT_EQ(read->cloud.height, 12U);
  EXPECT_EQ(read->cloud.view, sample.cloud.view);
}

TEST_P(PclOracle, WeReadPclsOtherPointTypes) {
  const Sample sample = plain_sample(40, 1);
  auto labeled = to_pcl<::pcl::PointXYZRGBL>(sample);
  for (std::size_t i = 0; i < labeled.size(); ++i) labeled[i].label = sample.label[i];
  write_pcls(labeled);
  auto read = load_cloud(path_);
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
  EXPECT_EQ(read->label, sample.label);

  write_pcls(to_pcl<::pcl::PointXYZRGBNormal>(sample));
  read = load_cloud(path_);
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);

  write_pcls(to_pcl<::pcl::PointXYZRGBA>(sample));
  read = load_cloud(path_);
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
}

std::string encoding_name(const testing::TestParamInfo<PcdEncoding>& info) {
  return info.param == PcdEncoding::kAscii ? "Ascii" : info.param == PcdEncoding::kBinary ? "Binary" : "Compressed";
}

INSTANTIATE_TEST_SUITE_P(Encodings, PclOracle,
                         testing::Values(PcdEncoding::kAscii, PcdEncoding::kBinary, PcdEncoding::kBinaryCompressed),
                         encoding_name);

TEST(PclOracleScene, ARealSceneIsReadAsPclReadsIt) {
  const std::string path = SEGSERVE_DATA_DIR "/osd/learn/learn0.pcd";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  ::pcl::PointCloud<::pcl::PointXYZRGBL> theirs;
  ASSERT_EQ(::pcl::io::loadPCDFile(path, theirs), 0);
  const auto ours = load_cloud(path);
  ASSERT_TRUE(ours.ok()) << ours.status();
  expect_pcl_has(theirs, ours->cloud);
  EXPECT_EQ(ours->cloud.view, View::camera());
  for (std::size_t i = 0; i < theirs.size(); ++i) ASSERT_EQ(theirs[i].label, ours->label[i]) << i;
}

}  // namespace
}  // namespace segserve::codec
