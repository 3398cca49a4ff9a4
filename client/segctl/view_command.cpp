// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/calls/local.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/output_kind.hpp"
#include "client/segctl/page_bundle.hpp"
#include "client/segctl/saved_result.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/unit_flag.hpp"
#include "client/segctl/view_flag.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/view_page/view_page.hpp"
#include "fmt/format.h"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

HelpText help() {
  return {
      .common = {"--output", "--cloud", "--compare", "--method", "--threshold", "--regions", "--view"},
      .examples = R"(segctl view scene.pcd -o scene.html
segctl view scene.segres --cloud scene.pcd -o scene.html
segctl view scene.pcd --compare lambda-convex -o methods.html
segctl view before.segres after.segres --cloud scene.pcd -o change.html)",
      .details =
          R"(The page is one file that needs no network. It shows the points in 3D, colored by segments, by their own colors,
supervoxels, normals, stability, and, if the file has labels, by these and by errors. A slider moves through the merge
tree. Clicks choose segments: Shift includes a point, Alt excludes one. The page can save a picture, and the labels as
PLY. Press ? in it for the keys.

A cloud is segmented in this process. A saved result needs its cloud. Two inputs are shown side by side. Points without
finite coordinates are left out.)",
      .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad input or usage."};
}

constexpr const char* kSegmentation = "Segmentation";

struct ViewArguments {
  std::vector<std::string> inputs;
  std::vector<std::string> clouds;
  std::string output;
  std::string compare;
  OptionFlags options;
  std::string view;
  UnitFlag unit;
  bool quiet = false;
  const CLI::App* command = nullptr;

  void add_to(CLI::App& app);
  /// INVALID_ARGUMENT for flags that have no effect on such inputs.
  absl::Status check_effects(bool has_results, bool has_clouds) const;
};

void ViewArguments::add_to(CLI::App& app) {
  command = &app;
  app.add_option("INPUT", inputs, "one or two: files of clouds, or what segctl segment --result saved")
      ->type_name("FILE")
      ->expected(1, 2)
      ->required();
  app.add_option("-o,--output", output, "write the page; - is standard output")
      ->type_name("FILE")
      ->required()
      ->group("Output");
  app.add_option("--cloud", clouds, "the cloud that was segmented for a saved result; twice if there are two")
      ->type_name("SCENE")
      ->allow_extra_args(false)
      ->group("Input");
  app.add_option("--compare", compare, "segment the cloud by this method, too, and show both side by side")
      ->type_name("METHOD")
      ->group(kSegmentation);
  options.add_to(app);
  app.add_option("--view", view, "where the sensor of a cloud is: camera, world, or world:X,Y,Z in meters")
      ->type_name("VIEW")
      ->group(kSegmentation);
  unit.add_to(app, kSegmentation);
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::Status ViewArguments::check_effects(bool has_results, bool has_clouds) const {
  if (!has_results && !clouds.empty()) {
    return absl::InvalidArgumentError("--cloud is for saved results: INPUT is a cloud itself");
  }
  if (has_clouds) return absl::OkStatus();
  for (const CLI::Option* option : command->get_options()) {
    if (option->count() == 0 || option->get_group() != kSegmentation) continue;
    return absl::InvalidArgumentError(fmt::format(
        "{} is for clouds that are segmented: a saved result has its segments already", option->get_name()));
  }
  return absl::OkStatus();
}

/// The last part of a path.
std::string short_name(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return path == "-" || name.empty() ? input_name(path) : name;
}

/// The clouds and results that the page shows. Deques keep their addresses when they grow.
struct Shown {
  std::deque<codec::LabeledCloud> clouds;
  std::vector<view_page::PageCloud> page_clouds;
  std::deque<client::Result> results;
  std::vector<view_page::PageResult> page_results;

  std::size_t add(codec::LabeledCloud cloud) {
    const codec::LabeledCloud& kept = clouds.emplace_back(std::move(cloud));
    page_clouds.push_back({.points = kept.cloud, .truth = kept.label, .placement = kept.placement});
    return page_clouds.size() - 1;
  }
  void add(std::string title, std::size_t cloud, client::Result result) {
    const client::Result& kept = results.emplace_back(std::move(result));
    page_results.push_back({.name = std::move(title),
                            .method = std::string(name(kept.method)),
                            .cloud = cloud,
                            .segmentation = &kept.segmentation,
                            .regions = kept.regions});
  }
};

/// The cloud of the saved result number `index`. Two results of one cloud share it.
absl::StatusOr<std::size_t> add_cloud_of(const ViewArguments& arguments, std::size_t index, const SavedResult& saved,
                                         Shown& shown) {
  const std::string& input = arguments.inputs[index];
  if (arguments.clouds.empty()) {
    return absl::InvalidArgumentError(
        fmt::format("{} is a saved result: it needs --cloud, the cloud that was segmented", input_name(input)));
  }
  const std::string& path = arguments.clouds[std::min(index, arguments.clouds.size() - 1)];
  std::vector<codec::Warning> warnings;
  ASSIGN_OR_RETURN(auto cloud, load_segmented_cloud(path, saved, input_name(input), warnings));
  for (const codec::Warning& warning : warnings) print_warning(warning.message);
  if (index == 1 && arguments.clouds.size() == 1 && !shown.clouds.empty()) {
    const Cloud& first = shown.clouds.front().cloud;
    if (client::fingerprint(first) == client::fingerprint(cloud.cloud) && first.view == cloud.cloud.view) return 0;
  }
  return shown.add(std::move(cloud));
}

absl::StatusOr<client::Result> segment(const codec::LabeledCloud& scene, const Options& options) {
  return client::segment_here(scene.cloud, scene.view_rule, codec::to_cloud(scene.placement, options), {}, StopToken());
}

/// Segments a cloud, by two methods if --compare asks for it.
absl::Status add_segmented(const ViewArguments& arguments, const std::string& input, codec::LabeledCloud scene,
                           Shown& shown) {
  ASSIGN_OR_RETURN(Options options, arguments.options.options());
  const std::size_t cloud = shown.add(std::move(scene));
  ASSIGN_OR_RETURN(auto result, segment(shown.clouds[cloud], options));
  shown.add(short_name(input), cloud, std::move(result));
  if (arguments.compare.empty()) return absl::OkStatus();
  const auto method = method_from_name(arguments.compare);
  if (!method) return absl::InvalidArgumentError(fmt::format("--compare: '{}' is not a method", arguments.compare));
  options.method = *method;
  ASSIGN_OR_RETURN(auto other, segment(shown.clouds[cloud], options));
  shown.add(short_name(input), cloud, std::move(other));
  return absl::OkStatus();
}

/// An input that was read.
struct Input {
  std::string path;
  std::string bytes;
  bool is_result() const { return is_saved_result(bytes); }
};

absl::Status add_input(const ViewArguments& arguments, const Input& input, std::size_t index, Shown& shown) {
  if (input.is_result()) {
    ASSIGN_OR_RETURN(SavedResult saved, decode_saved_result(input.bytes, input_name(input.path)));
    ASSIGN_OR_RETURN(const std::size_t cloud, add_cloud_of(arguments, index, saved, shown));
    shown.add(short_name(input.path), cloud, std::move(saved.result));
    return absl::OkStatus();
  }
  codec::ReadOptions read{.view = std::nullopt, .unit = arguments.unit.unit()};
  if (!arguments.view.empty()) {
    ASSIGN_OR_RETURN(read.view, parse_view(arguments.view));
  }
  auto scene = codec::decode_cloud(std::as_bytes(std::span(input.bytes)), {}, read);
  if (!scene.ok()) return with_prefix(input_name(input.path), scene.status());
  return add_segmented(arguments, input.path, *std::move(scene), shown);
}

/// Reads all inputs, and checks that no flag is without effect on them.
absl::StatusOr<std::vector<Input>> read_inputs(const ViewArguments& arguments) {
  std::vector<Input> inputs;
  for (const std::string& path : arguments.inputs) {
    ASSIGN_OR_RETURN(std::string bytes, read_input(path));
    inputs.push_back({path, std::move(bytes)});
  }
  const auto results = std::ranges::count_if(inputs, &Input::is_result);
  RETURN_IF_ERROR(arguments.check_effects(results > 0, results < std::ssize(inputs)));
  return inputs;
}

std::string summary(const std::string& output, const std::string& page, const Shown& shown) {
  std::string text;
  for (const view_page::PageResult& result : shown.page_results) {
    text += fmt::format("{}: {}, {} points, {} supervoxels, {} segments\n", result.name, result.method,
                        result.segmentation->supervoxels.size(), result.segmentation->tree.leaf_count(),
                        result.segmentation->segments);
  }
  return text + fmt::format("{}: {:.1f} MB; open it in a browser\n", output, static_cast<double>(page.size()) / 1e6);
}

absl::Status run(const ViewArguments& arguments) {
  ASSIGN_OR_RETURN(const std::string_view bundle, page_bundle());
  if (!arguments.compare.empty() && arguments.inputs.size() > 1) {
    return absl::InvalidArgumentError("--compare is for one cloud: two inputs are side by side already");
  }
  StagedOutput output;
  RETURN_IF_ERROR(output.protect(arguments.inputs, true));
  RETURN_IF_ERROR(output.announce(arguments.output));
  RETURN_IF_ERROR(check_output_name("-o", arguments.output, OutputKind::kPage));
  Shown shown;
  ASSIGN_OR_RETURN(const std::vector<Input> inputs, read_inputs(arguments));
  for (std::size_t i = 0; i < inputs.size(); ++i) RETURN_IF_ERROR(add_input(arguments, inputs[i], i, shown));
  ASSIGN_OR_RETURN(std::string page, view_page::make_page(bundle, short_name(arguments.inputs.front()) + " - segserve",
                                                          shown.page_clouds, shown.page_results));
  const bool tells = !arguments.quiet && !output.uses_stdout();
  const std::string text = tells ? summary(arguments.output, page, shown) : "";
  output.add(arguments.output, std::move(page));
  if (tells) output.add("-", text);
  return output.commit();
}

}  // namespace

void add_view_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "view", "Write a page that shows a segmented cloud in 3D, with its merge tree", help(), run);
}

}  // namespace segserve::segctl
