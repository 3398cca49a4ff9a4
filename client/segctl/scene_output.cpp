// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/scene_output.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <vector>

#include "client/segctl/point_subset.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/picture/picture.hpp"
#include "fmt/format.h"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::segctl {
namespace {

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

bool has_ply_name(const std::string& path) { return lower_extension(path) == ".ply"; }

codec::PcdEncoding pcd_encoding(const std::string& name) {
  if (name == "ascii") return codec::PcdEncoding::kAscii;
  return name == "binary" ? codec::PcdEncoding::kBinary : codec::PcdEncoding::kBinaryCompressed;
}

std::vector<std::uint32_t> segment_colors(std::span<const std::uint32_t> labels) {
  std::vector<std::uint32_t> colors(labels.size());
  std::ranges::transform(labels, colors.begin(), picture::segment_color);
  return colors;
}

/// The points with a label other than 0, in their order, as an unorganized cloud, with their labels.
codec::LabeledCloud labeled_points(const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels) {
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != 0) points.push_back(i);
  }
  codec::LabeledCloud kept = subset_of(scene, points);
  for (const std::size_t i : points) kept.label.push_back(labels[i]);
  return kept;
}

void add_picture(StagedOutput& output, const std::string& path, const CloudView& cloud,
                 std::span<const std::uint32_t> labels) {
  auto image = std::make_shared<const picture::Image>(picture::render(cloud, labels));
  output.add(path, [image](const std::string& target) { return picture::write_png(target, *image); });
}

}  // namespace

void SceneOutput::add_to(CLI::App& app) {
  app.add_option("-o,--output", cloud_path_,
                 "write the cloud with its labels (field \"label\"): .pcd or .ply; - is PCD to standard output; of a "
                 "recording .mcap, with the other topics as they were")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--encoding", encoding_, "encoding of that file; binary_compressed is for PCD only")
      ->check(CLI::IsMember({"ascii", "binary", "binary_compressed"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group("Output");
  app.add_option("--color", color_, "colors in that file: the points' own, or those of their segments")
      ->check(CLI::IsMember({"own", "segment"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group("Output");
  app.add_flag("--drop-unlabelled", drop_unlabelled_,
               "leave points with label 0 out of that file, which then has no rows and columns")
      ->group("Output");
  app.add_option("--picture", picture_path_, "write a picture of the labels: PNG; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--plain-picture", plain_picture_path_, "write a picture of the cloud in its own colors, as --picture")
      ->type_name("FILE")
      ->group("Output");
}

absl::Status SceneOutput::announce(StagedOutput& output) const {
  if (!cloud_path_.empty()) {
    if (cloud_path_ != "-" && !has_ply_name(cloud_path_) && lower_extension(cloud_path_) != ".pcd") {
      return absl::InvalidArgumentError(fmt::format("-o {}: the name must end in .pcd or .ply", cloud_path_));
    }
    if (has_ply_name(cloud_path_) && encoding_ == "binary_compressed") {
      return absl::InvalidArgumentError("--encoding binary_compressed: PLY has ascii and binary only");
    }
  }
  for (const std::string& path : {cloud_path_, picture_path_, plain_picture_path_}) {
    if (!path.empty()) RETURN_IF_ERROR(output.announce(path));
  }
  return absl::OkStatus();
}

std::string SceneOutput::encode(const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels,
                                Format format) const {
  codec::LabeledCloud kept;
  if (drop_unlabelled_) kept = labeled_points(scene, labels);
  codec::FileContent content =
      drop_unlabelled_ ? codec::content_of(kept, kept.label) : codec::content_of(scene, labels);
  std::vector<std::uint32_t> colors;
  if (color_ == "segment") {
    colors = segment_colors(content.label);
    content.cloud.rgb = colors;
  }
  if (format == Format::kPcd) return codec::encode_pcd(content, pcd_encoding(encoding_));
  const bool ascii = encoding_ == "ascii";
  return codec::encode_ply(content, ascii ? codec::PlyEncoding::kAscii : codec::PlyEncoding::kBinaryLittleEndian);
}

std::string SceneOutput::encode_pcd(const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels) const {
  return encode(scene, labels, Format::kPcd);
}

void SceneOutput::add(StagedOutput& output, const codec::LabeledCloud& scene,
                      std::span<const std::uint32_t> labels) const {
  if (!cloud_path_.empty()) {
    output.add(cloud_path_, encode(scene, labels, has_ply_name(cloud_path_) ? Format::kPly : Format::kPcd));
  }
  if (!picture_path_.empty()) add_picture(output, picture_path_, scene.cloud, labels);
  if (!plain_picture_path_.empty()) add_picture(output, plain_picture_path_, scene.cloud, {});
}

std::string SceneOutput::format_key() const {
  std::string key;
  if (encoding_ != "binary") key += " " + encoding_;
  if (color_ != "own") key += " colors of segments";
  if (drop_unlabelled_) key += " without unlabeled points";
  return key;
}

}  // namespace segserve::segctl
