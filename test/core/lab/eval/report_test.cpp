// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/report.hpp"

#include <gmock/gmock.h>

namespace segserve::eval {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Report example() {
  Report report{
      .method = "lambda", .threshold = 0.18, .folder = "osd", .degradation = {}, .learned = {}, .per_scene = {}};
  for (const double wov : {0.5, 1.0}) {
    SceneScores scene{wov == 1 ? "b.pcd" : "a.pcd", {}};
    scene.values[metric("one_to_one.wov")] = wov;
    report.per_scene.push_back(scene);
  }
  report.per_scene[0].values[metric("supervoxel_quality.boundary_recall")] = 0.25;  // the other is no image
  return report;
}

TEST(Report, JsonHoldsMeansAndRows) {
  const std::string json = to_json(example());
  EXPECT_THAT(json, StartsWith(R"({"scenes":2,"method":"lambda","threshold":0.18,"data":"osd",)"));
  EXPECT_THAT(json, HasSubstr(R"("learnt":null)"));
  EXPECT_THAT(json, HasSubstr(R"("one_to_one":{"wov":0.75,"tp":null,)"));
  EXPECT_THAT(json, HasSubstr(R"("boundary_recall":0.25},"per_scene":[{"file":"a.pcd")"));
  EXPECT_EQ(json.find('\n'), json.size() - 1);
}

TEST(Report, JsonTellsWhatFailed) {
  Report report = example();
  EXPECT_THAT(to_json(report), HasSubstr(R"("failed":[])"));
  report.failed.push_back({"c.pcd", absl::InvalidArgumentError("osd/c.pcd: is broken")});
  EXPECT_THAT(to_json(report), HasSubstr(R"("failed":[{"file":"c.pcd","error":"osd/c.pcd: is broken"}])"));
}

TEST(Report, ReadsWhatItWrote) {
  const Report report = *report_from_json(to_json(example()));
  EXPECT_EQ(report.method, "lambda");
  ASSERT_EQ(report.per_scene.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(report.per_scene[i].file, example().per_scene[i].file);
    EXPECT_EQ(report.per_scene[i].values, example().per_scene[i].values);
  }
}

TEST(Report, TheCurveIsThereIfAskedFor) {
  Report report = example();
  report.learned = LearnedThreshold{.folder = "learn", .sweep = {}, .with_curve = false};
  EXPECT_THAT(to_json(report), testing::Not(HasSubstr("curve")));
  report.learned->with_curve = true;
  EXPECT_THAT(to_json(report), HasSubstr(R"("curve":[{"threshold":0.0,"one_to_one_tp":0.0},{"threshold":0.01)"));
}

TEST(Report, RefusesOtherFiles) {
  for (const char* text : {"", "{", R"({"method":"x","method":"y","per_scene":[]})"}) {
    EXPECT_THAT(std::string(report_from_json(text).status().message()),
                testing::StartsWith("not a result of segctl eval: it "))
        << text;
  }
  for (const char* text :
       {"[]", "3", R"({"method":"x"})", R"({"method":1,"per_scene":[]})", R"({"method":"x","per_scene":{}})"}) {
    EXPECT_EQ(report_from_json(text).status().message(),
              "not a result of segctl eval: no JSON object with method and per_scene")
        << text;
  }
  EXPECT_EQ(report_from_json(R"({"method":"x","per_scene":[3]})").status().message(), "per_scene[0] has no file");
  EXPECT_EQ(report_from_json(R"({"method":"x","per_scene":[{"file":"a"},{"file":"b","one_to_one":{"wov":"1"}}]})")
                .status()
                .message(),
            "per_scene[1]: one_to_one.wov is not a number");
  EXPECT_TRUE(report_from_json(R"({"method":"x","per_scene":[{"file":"a","one_to_one":7}]})").ok());
}

TEST(Report, TextNamesTheProtocols) {
  const std::string text = to_text(example());
  for (const char* part :
       {"a.pcd", "b.pcd", "mean", "one_to_one", "paper, all regions", "paper, objects",
        "lambda on 2 scenes of osd, threshold 0.18", "boundary_recall 0.2500", "panoptic, objects    pq -  sq -  rq -",
        "instances (objects)", "overlap, objects", "objects per scene", "boundaries"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

}  // namespace
}  // namespace segserve::eval
