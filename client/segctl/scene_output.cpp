#include "client/segctl/scene_output.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

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

bool is_ply(const std::string& path) { return lower_extension(path) == ".ply"; }

codec::PcdEncoding pcd_encoding(const std::string& name) {
  if (name == "ascii") return codec::PcdEncoding::kAscii;
  return name == "binary" ? codec::PcdEncoding::kBinary : codec::PcdEncoding::kBinaryCompressed;
}

std::vector<std::uint32_t> segment_colors(std::span<const std::uint32_t> labels) {
  std::vector<std::uint32_t> colors(labels.size());
  std::ranges::transform(labels, colors.begin(), picture::segment_color);
  return colors;
}

}  // namespace

void SceneOutput::add_to(CLI::App& app, bool with_color) {
  app.add_option("-o,--output", cloud_path_,
                 "write the cloud with its labels (field \"label\"): .pcd or .ply; - is PCD to standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--encoding", encoding_, "of that file; binary_compressed is for PCD only")
      ->check(CLI::IsMember({"ascii", "binary", "binary_compressed"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group("Output");
  if (with_color) {
    app.add_option("--color", color_, "of that file: the points' own, or that of their segment")
        ->check(CLI::IsMember({"own", "segment"}))
        ->type_name("NAME")
        ->capture_default_str()
        ->group("Output");
  }
  app.add_option("--picture", picture_path_, "write a picture of the labels: PNG; - is standard output")
      ->type_name("FILE")
      ->group("Output");
}

absl::Status SceneOutput::announce(StagedOutput& output) const {
  if (!cloud_path_.empty()) {
    if (cloud_path_ != "-" && !is_ply(cloud_path_) && lower_extension(cloud_path_) != ".pcd") {
      return absl::InvalidArgumentError(fmt::format("-o {}: the name must end in .pcd or .ply", cloud_path_));
    }
    if (is_ply(cloud_path_) && encoding_ == "binary_compressed") {
      return absl::InvalidArgumentError("--encoding binary_compressed: PLY has ascii and binary only");
    }
    if (absl::Status status = output.announce(cloud_path_); !status.ok()) return status;
  }
  return picture_path_.empty() ? absl::OkStatus() : output.announce(picture_path_);
}

std::string SceneOutput::encode(const CloudView& cloud, std::span<const std::uint32_t> labels) const {
  if (!is_ply(cloud_path_)) return codec::encode_pcd(cloud, labels, pcd_encoding(encoding_));
  const bool ascii = encoding_ == "ascii";
  return codec::encode_ply(cloud, labels, ascii ? codec::PlyEncoding::kAscii : codec::PlyEncoding::kBinaryLittleEndian);
}

std::string SceneOutput::encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> labels) const {
  if (color_ == "own") return codec::encode_pcd(cloud, labels, pcd_encoding(encoding_));
  const std::vector<std::uint32_t> colors = segment_colors(labels);
  CloudView painted = cloud;
  painted.rgb = colors;
  return codec::encode_pcd(painted, labels, pcd_encoding(encoding_));
}

void SceneOutput::add(StagedOutput& output, const CloudView& cloud, std::span<const std::uint32_t> labels) const {
  if (!cloud_path_.empty() && color_ == "own") {
    output.add(cloud_path_, encode(cloud, labels));
  } else if (!cloud_path_.empty()) {
    const std::vector<std::uint32_t> colors = segment_colors(labels);
    CloudView painted = cloud;
    painted.rgb = colors;
    output.add(cloud_path_, encode(painted, labels));
  }
  if (!picture_path_.empty()) {
    auto image = std::make_shared<const picture::Image>(picture::render(cloud, labels));
    output.add(picture_path_, [image](const std::string& path) { return picture::write_png(path, *image); });
  }
}

}  // namespace segserve::segctl
