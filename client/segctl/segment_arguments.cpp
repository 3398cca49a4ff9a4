#include "client/segctl/segment_arguments.hpp"

#include "client/segctl/view_flag.hpp"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;

constexpr const char* kFooter = R"(Examples:
  segctl segment scene.pcd -o labelled.pcd --picture segments.png
  segctl segment scene.ply --view world:0,0,1.5 --server robot:50051 --zstd --json -
  segctl segment scene.pcd --codec quantised --error-bound 0.5
  segctl segment --depth depth.png --rgb color.png --intrinsics 525,525,319.5,239.5 --picture segments.png
  segctl segment scene.pcd --local --method equalization --regions 12 -o - | other-program
  segctl segment scene.pcd --result scene.segres; segctl cut scene.segres --threshold 0.2
  segctl segment scene.pcd --range-max 1.5 --support-plane-distance 0.01 -o objects.pcd
  segctl segment scene.pcd --segments --json - | jq '.segment_statistics[0].box'
  segctl segment scans/ --out-dir labelled/    # goes on where it was stopped

Points that are not finite, that the crop box or the range leaves out, or that are removed with the
support plane get label 0; segments are numbered 1, 2, .. by descending size.
Without --view an organised PCD with the identity VIEWPOINT is seen by the camera, any other PCD
is WORLD with the sensor at VIEWPOINT, and a PLY is WORLD without a sensor. Images are CAMERA.

Lossy codecs move points by at most their error bound; labels still come back in the order of the input.
With --local and a codec the points are segmented as a server would see them.

With --out-dir a file that fails stops no other; errors are listed at the end, one a line.

Exit codes: 0 done; 1 failed (server unreachable, time over, disk full); 2 bad input or usage. Of many
files: 2 if all that failed were bad input, else 1.)";

}  // namespace

void SegmentArguments::add_to(CLI::App& app) {
  app.footer(kFooter);
  app.add_option(
      "SCENE", scenes,
      "PCD (ascii, binary, binary_compressed) or PLY file; - is standard input; with --out-dir many, or folders");
  rgbd.add_to(app);
  options.add_to(app);
  app.add_option("--view", view,
                 "where the sensor is: camera, world, or world:X,Y,Z with its position in metres; "
                 "default: what the file says")
      ->type_name("VIEW")
      ->group("Segmentation");
  server.add_to(app, kDefaultTimeout);
  app.add_flag("--local", local, "segment in this process, without a server")->group("Server");
  app.add_flag("--fallback-local", fallback_local, "segment in this process if no server is in reach")->group("Server");
  codec.add_to(app,
               "pcd sends a PCD file as it is; default: planar, and planar-zstd if that would be too large "
               "for one call",
               "Server");
  app.add_option("--request-id", request_id, "name of this call in the server's logs")
      ->type_name("TEXT")
      ->group("Server");
  scene_output.add_to(app, true);
  app.add_option("--result", result_path, "save the result with its merge tree, for segctl cut")
      ->type_name("FILE")
      ->group("Output");
  CLI::Option* out_dir_flag =
      app.add_option(
             "--out-dir", out_dir,
             "for many files: write DIR/NAME.pcd, labelled, and DIR/NAME.json of each, unless they are there and "
             "of the same options")
          ->type_name("DIR")
          ->group("Output");
  app.add_option("--parallel", parallel, "files at the same time; default 4, with --local one per CPU")
      ->check(CLI::Range(1, 256))
      ->needs(out_dir_flag)
      ->group("Output");
  app.add_option("--json", json_path,
                 "write the summary as one JSON object, with --out-dir one a file and line; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag(
         "--segments", segments,
         "tell points, centroid, oriented box, mean colour and mean normal of every segment, in --json, --out-dir "
         "and --result")
      ->group("Output");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::Status SegmentArguments::check_combination() const {
  const bool many = !out_dir.empty();
  if (many && (scene_output.wanted() || !result_path.empty() || !request_id.empty() || rgbd.given())) {
    return absl::InvalidArgumentError("--out-dir excludes -o, --picture, --result, --request-id and RGB-D images");
  }
  if (!many && scenes.size() > 1) return absl::InvalidArgumentError("more than one SCENE needs --out-dir");
  if (scenes.empty() && !rgbd.given()) {
    return absl::InvalidArgumentError("SCENE is required, or --depth and --intrinsics (see segctl segment --help)");
  }
  if (!scenes.empty() && rgbd.given()) {
    return absl::InvalidArgumentError("SCENE and RGB-D images exclude each other");
  }
  if (rgbd.given() && !view.empty()) {
    return absl::InvalidArgumentError("--view does not go with RGB-D images: they are seen from the camera");
  }
  if (segments && json_path.empty() && result_path.empty() && out_dir.empty()) {
    return absl::InvalidArgumentError("--segments needs --json, --result or --out-dir, which tell of them");
  }
  if (local && server.server_given()) {
    return absl::InvalidArgumentError("--local and --server exclude each other");
  }
  if (local && fallback_local) {
    return absl::InvalidArgumentError("--local and --fallback-local exclude each other: --local asks no server");
  }
  if (local && !request_id.empty()) {
    return absl::InvalidArgumentError("--request-id needs a server: not together with --local");
  }
  return absl::OkStatus();
}

absl::StatusOr<SegmentRequest> SegmentArguments::request() const {
  SegmentRequest request;
  const auto given_options = options.options();
  if (!given_options.ok()) return given_options.status();
  request.options = *given_options;
  if (!view.empty()) {
    const auto given_view = parse_view(view);
    if (!given_view.ok()) return given_view.status();
    request.view = *given_view;
  }
  const auto given_codec = codec.options();
  if (!given_codec.ok()) return given_codec.status();
  request.codec = *given_codec;
  request.segments = segments;
  return request;
}

}  // namespace segserve::segctl
