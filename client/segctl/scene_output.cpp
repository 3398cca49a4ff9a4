// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/scene_output.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <locale>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "client/segctl/output_kind.hpp"
#include "client/segctl/point_subset.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "segserve/codec/pcd.hpp"

namespace segserve::segctl {
namespace {

/// The format of the cloud that is written to a path; "-" is PCD.
std::optional<codec::FileFormat> format_of(const std::string& path) {
  return path == "-" ? codec::FileFormat::kPcd : codec::file_format_of(path);
}

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
                 std::span<const std::uint32_t> labels, const picture::RenderOptions& options) {
  auto image = std::make_shared<const picture::Image>(picture::render(cloud, labels, options));
  output.add(path, [image](const std::string& target) { return picture::write_png(target, *image); });
}

absl::Status announce_picture(std::string_view flag, const std::string& path, StagedOutput& output) {
  if (path.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(path));
  return check_output_name(flag, path, OutputKind::kPicture);
}

/// The position X,Y,Z that --view-from gives, in meters along the axes of the file.
absl::StatusOr<Eigen::Vector3d> parse_view_from(const std::string& text) {
  constexpr double kFarthest = 1e8;  // also of places on a globe
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  Eigen::Vector3d position;
  char comma = ',';
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) words >> comma;
    words >> position[axis];
    if (comma != ',') words.setstate(std::ios::failbit);
  }
  if (!words || words.peek() != std::char_traits<char>::eof() || !position.allFinite() ||
      position.cwiseAbs().maxCoeff() > kFarthest) {
    return absl::InvalidArgumentError(
        fmt::format("--view-from {}: must be X,Y,Z, a position in meters such as 1.5,-2,1", text));
  }
  return position;
}

}  // namespace

void SceneOutput::add_to(CLI::App& app) {
  app.add_option("-o,--output", cloud_path_,
                 "write the cloud with its labels: " + codec::writable_extensions() +
                     ", of a recording .mcap; - is PCD to standard output")
      ->type_name("FILE")
      ->group("Output");
  CLI::Option* encoding = app.add_option(
      "--encoding", encoding_, "encoding of that file, if it is PCD or PLY; binary_compressed is for PCD only");
  encoding->check(CLI::IsMember({"ascii", "binary", "binary_compressed"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group("Output");
  CLI::Option* color =
      app.add_option("--color", color_, "colors in that file: the points' own, or those of their segments");
  color->check(CLI::IsMember({"own", "segment"}))->type_name("NAME")->capture_default_str()->group("Output");
  CLI::Option* drop = app.add_flag("--drop-unlabeled", drop_unlabeled_,
                                   "leave points with label 0 out of that file, which then has no rows and columns");
  drop->group("Output");
  CLI::Option* old_drop = app.add_flag("--drop-unlabelled", drop_unlabeled_);  // its name of version 0.1
  old_drop->group("");
  cloud_options_ = {encoding, color, drop, old_drop};
  app.add_option("--picture", picture_path_, "write a picture of the labels: PNG; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--plain-picture", plain_picture_path_, "write a picture of the cloud in its own colors, as --picture")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--view-from", view_from_,
                 "where pictures look from, in meters along the axes of the file, towards the middle of the cloud; "
                 "default: an image as it is, other clouds from the sensor, or obliquely from above")
      ->type_name("X,Y,Z")
      ->group("Output");
  app.add_flag("--legend", legend_,
               "numbers on the segments of --picture, and a legend with labels and sizes beside it")
      ->group("Output");
}

absl::Status SceneOutput::check_without_pictures() const {
  if (!legend_ && view_from_.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError("--legend and --view-from are for the pictures of one cloud");
}

absl::Status SceneOutput::check_cloud_flags(bool writes_other_clouds) const {
  if (writes_other_clouds || !cloud_path_.empty()) return absl::OkStatus();
  for (const CLI::Option* option : cloud_options_) {
    if (option->count() == 0) continue;
    return absl::InvalidArgumentError(
        fmt::format("{} says how a cloud is written, and none is: -o FILE writes one", option->get_name()));
  }
  return absl::OkStatus();
}

absl::Status SceneOutput::announce(StagedOutput& output) const {
  if (!view_from_.empty()) RETURN_IF_ERROR(parse_view_from(view_from_).status());
  if (!view_from_.empty() && !wants_picture()) {
    return absl::InvalidArgumentError("--view-from needs --picture or --plain-picture");
  }
  if (legend_ && picture_path_.empty()) return absl::InvalidArgumentError("--legend needs --picture");
  if (!cloud_path_.empty()) RETURN_IF_ERROR(check_format());
  if (!cloud_path_.empty()) RETURN_IF_ERROR(output.announce_labeled_cloud(cloud_path_));
  RETURN_IF_ERROR(announce_picture("--picture", picture_path_, output));
  return announce_picture("--plain-picture", plain_picture_path_, output);
}

absl::Status SceneOutput::check_format() const {
  using codec::FileFormat;
  const auto format = format_of(cloud_path_);
  if (!format) {
    return absl::InvalidArgumentError(
        fmt::format("-o {}: the name must end in {}", cloud_path_, codec::writable_extensions()));
  }
  if (encoding_ == "binary_compressed" && format != FileFormat::kPcd) {
    return absl::InvalidArgumentError(fmt::format("--encoding binary_compressed is for PCD, not for {}", cloud_path_));
  }
  const bool is_binary = format == FileFormat::kLas || format == FileFormat::kNpy ||
                         format == FileFormat::kKittiLabel || format == FileFormat::kGlb;
  if (encoding_ == "ascii" && is_binary) {
    return absl::InvalidArgumentError(fmt::format("--encoding ascii: {} has no text form; .csv has", cloud_path_));
  }
  if (drop_unlabeled_ && codec::has_labels_only(*format)) {
    return absl::InvalidArgumentError(
        fmt::format("--drop-unlabeled: {} needs a label for each point of the input", cloud_path_));
  }
  return absl::OkStatus();
}

absl::StatusOr<codec::EncodedFile> SceneOutput::encode(const codec::LabeledCloud& scene,
                                                       std::span<const std::uint32_t> labels,
                                                       codec::FileFormat format) const {
  codec::LabeledCloud kept;
  if (drop_unlabeled_) kept = labeled_points(scene, labels);
  codec::FileContent content = drop_unlabeled_ ? codec::content_of(kept, kept.label) : codec::content_of(scene, labels);
  std::vector<std::uint32_t> colors;
  if (color_ == "segment") {
    colors = segment_colors(content.label);
    content.cloud.rgb = colors;
  }
  if (format == codec::FileFormat::kPcd) {
    return codec::EncodedFile{codec::encode_pcd(content, pcd_encoding(encoding_)), codec::losses_of(content, format)};
  }
  const auto encoding = encoding_ == "ascii" ? codec::FileEncoding::kText : codec::FileEncoding::kBinary;
  return codec::encode_file(content, format, encoding, codec::scene_name(cloud_path_));
}

codec::EncodedFile SceneOutput::encode_pcd(const codec::LabeledCloud& scene,
                                           std::span<const std::uint32_t> labels) const {
  return *encode(scene, labels, codec::FileFormat::kPcd);  // PCD holds the points of every cloud.
}

void append_warnings(const std::string& path, const std::vector<codec::Warning>& of_file,
                     std::vector<codec::Warning>& warnings) {
  for (const codec::Warning& warning : of_file) {
    warnings.push_back({warning.reason, fmt::format("{}: {}", path, warning.message)});
  }
}

absl::Status SceneOutput::add(StagedOutput& output, const codec::LabeledCloud& scene,
                              std::span<const std::uint32_t> labels, std::vector<codec::Warning>& warnings) const {
  if (!cloud_path_.empty()) {
    auto file = encode(scene, labels, *format_of(cloud_path_));
    if (!file.ok()) return with_prefix(cloud_path_, file.status());
    append_warnings(cloud_path_, file->warnings, warnings);
    output.add(cloud_path_, std::move(file->bytes));
  }
  ASSIGN_OR_RETURN(const picture::RenderOptions options, render_options(scene));
  if (!picture_path_.empty()) add_picture(output, picture_path_, scene.cloud, labels, options);
  if (!plain_picture_path_.empty()) add_picture(output, plain_picture_path_, scene.cloud, {}, options);
  return absl::OkStatus();
}

absl::StatusOr<picture::RenderOptions> SceneOutput::render_options(const codec::LabeledCloud& scene) const {
  picture::RenderOptions options;
  options.legend = legend_;
  if (view_from_.empty()) return options;
  ASSIGN_OR_RETURN(const Eigen::Vector3d position, parse_view_from(view_from_));
  const Eigen::Vector3d in_cloud = scene.placement.to_cloud(position / scene.placement.meters_per_unit());
  options.view_from = in_cloud.cast<float>();
  return options;
}

std::string SceneOutput::format_key() const {
  std::string key;
  if (encoding_ != "binary") key += " " + encoding_;
  if (color_ != "own") key += " colors of segments";
  if (drop_unlabeled_) key += " without unlabeled points";
  return key;
}

}  // namespace segserve::segctl
