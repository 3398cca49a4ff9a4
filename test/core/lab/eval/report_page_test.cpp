// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/report_page.hpp"

#include <gmock/gmock.h>

#include "core/lab/eval/report_tables.hpp"

namespace segserve::eval {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// Scenes with these values of paper_objects.wov, named by the files.
Report report_of(const std::string& method, const std::vector<std::pair<std::string, double>>& scenes) {
  Report report{.method = method, .threshold = {}, .folder = "osd", .degradation = {}, .learned = {}, .per_scene = {}};
  for (const auto& [file, wov] : scenes) {
    report.per_scene.push_back({file, {}});
    report.per_scene.back().values[metric("paper_objects.wov")] = wov;
    report.per_scene.back().values[metric("object_counts.objects")] = 3;
  }
  return report;
}

const std::vector<std::string>& row_of(const ReportTable& table, const std::string& name) {
  const auto row = std::ranges::find(table.rows, name, [](const auto& cells) { return cells.front(); });
  EXPECT_NE(row, table.rows.end()) << name;
  return *row;
}

TEST(TablesOf, HaveMeansAndScenes) {
  const auto tables = tables_of(report_of("border", {{"a.pcd", 0.5}, {"b.pcd", 1}}), nullptr);
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_THAT(row_of(tables[0], "paper_objects.wov"), ElementsAre("paper_objects.wov", "0.7500"));
  EXPECT_THAT(row_of(tables[0], "instance.ap"), ElementsAre("instance.ap", "-"));
  EXPECT_THAT(row_of(tables[0], "object_counts.objects"), ElementsAre("object_counts.objects", "3.00"));
  const auto& scene = row_of(tables[1], "a.pcd");
  EXPECT_THAT(scene, testing::AllOf(testing::Contains("0.5000"), testing::Contains("3")));
  for (const ReportTable& table : tables) {
    for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
  }
}

TEST(TablesOf, SetThePeerBeside) {
  const Report report = report_of("border", {{"a.pcd", 0.5}, {"b.pcd", 1}, {"c.pcd", 0.75}});
  Report other = report_of("pcl-lccp", {{"a.pcd", 0.25}, {"b.pcd", 0.5}});
  other.failed.push_back({"c.pcd", absl::InternalError("osd/c.pcd: PCL gave up")});
  const Peer peer = compare_with(report, other);
  const auto tables = tables_of(report, &peer);
  ASSERT_EQ(tables.size(), 3U);
  const auto& means = row_of(tables[0], "paper_objects.wov");
  ASSERT_EQ(means.size(), 6U);
  EXPECT_EQ(means[1], "0.7500");
  EXPECT_EQ(means[2], "0.3750");
  EXPECT_EQ(means[3], "+0.3750");  // of a and b, which both have
  EXPECT_EQ(means[4], "+0.2500 to +0.5000");
  EXPECT_EQ(row_of(tables[1], "a.pcd").back(), "0.2500");
  EXPECT_EQ(row_of(tables[1], "c.pcd").back(), "-");
  EXPECT_THAT(tables[2].rows, ElementsAre(ElementsAre("c.pcd", "pcl-lccp", "osd/c.pcd: PCL gave up")));
  for (const ReportTable& table : tables) {
    for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
  }
}

TEST(CompareWith, NeedsTwoScenesOfBoth) {
  const Report report = report_of("border", {{"a.pcd", 0.5}, {"b.pcd", 1}});
  EXPECT_TRUE(compare_with(report, report_of("x", {{"a.pcd", 1}})).differences.empty());
  const Peer peer = compare_with(report, report_of("x", {{"b.pcd", 1}, {"z.pcd", 1}, {"a.pcd", 1}}));
  ASSERT_FALSE(peer.differences.empty());
  EXPECT_EQ(peer.differences[0].scenes, 2U);
}

TEST(ToHtml, EscapesNamesAndHoldsThePictures) {
  Report report = report_of("border", {{"<script>&\"'.pcd", 0.5}});
  report.folder = "<b>osd</b>";
  report.failed.push_back({"<i>.pcd", absl::InvalidArgumentError("<i>.pcd: is <broken>")});
  const std::vector<Thumbnails> worst{{"<script>&\"'.pcd", "Man", "Ma"}};
  const std::string html = to_html(report, nullptr, worst);
  EXPECT_THAT(html, testing::StartsWith("<!DOCTYPE html>\n"));
  EXPECT_THAT(html, HasSubstr("<td>&lt;script&gt;&amp;&quot;&#39;.pcd</td>"));
  EXPECT_THAT(html, HasSubstr("<h3>&lt;script&gt;&amp;&quot;&#39;.pcd</h3>"));
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,TWFu\""));
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,TWE=\""));
  for (const char* raw : {"<script", "<b>", "<i>", "<broken>", "http"}) EXPECT_THAT(html, Not(HasSubstr(raw)));
}

TEST(ToMarkdown, EscapesNamesAndLinksThePictures) {
  const Report report = report_of("border", {{"a|b*[c](d)<e>\n`f.pcd", 0.5}});
  const std::vector<Thumbnails> worst{{report.per_scene[0].file, "Man", "Ma"}};
  const std::string text = to_markdown(report, nullptr, worst, "my report (1)_pictures");
  EXPECT_THAT(text, testing::StartsWith("# Scores of border\n\nborder on 1 scenes of osd\n"));
  EXPECT_THAT(text, HasSubstr("| a\\|b\\*\\[c\\](d)\\<e\\> \\`f.pcd | -"));
  EXPECT_THAT(text, HasSubstr("![truth](my%20report%20%281%29_pictures/truth-1.png) | "
                              "![segments](my%20report%20%281%29_pictures/segments-1.png) |\n"));
  EXPECT_THAT(text, HasSubstr("| paper\\_objects.wov | 0.5000 |\n"));
  EXPECT_THAT(to_markdown(report, nullptr, worst, ""), Not(HasSubstr(".png")));
  EXPECT_THAT(to_markdown(report, nullptr, {}, "x"), Not(HasSubstr("Worst")));
}

TEST(Report, JsonAndTextHaveThePeer) {
  const Report report = report_of("border", {{"a.pcd", 0.5}, {"b.pcd", 1}});
  const Peer peer = compare_with(report, report_of("pcl-lccp", {{"a.pcd", 0.25}, {"b.pcd", 0.5}}));
  const std::string json = to_json(report, &peer);
  EXPECT_THAT(json, HasSubstr(R"("peer":{"scenes":2,"method":"pcl-lccp",)"));
  EXPECT_THAT(json, HasSubstr(R"("differences":{"paper_objects.wov":{"scenes":2,"mean_a":0.75,"mean_b":0.375,)"));
  EXPECT_THAT(to_json(report), Not(HasSubstr("peer")));
  EXPECT_EQ(report_from_json(json)->per_scene.size(), 2U);
  const std::string text = to_text(report, &peer);
  EXPECT_THAT(text, HasSubstr("A border\nB pcl-lccp\n"));
  EXPECT_THAT(text, HasSubstr("pcl-lccp on 2 scenes of osd"));
  const Peer lone = compare_with(report, report_of("pcl-lccp", {{"a.pcd", 0.25}}));
  EXPECT_THAT(to_text(report, &lone), HasSubstr("Fewer than two scenes have scores of both"));
}

}  // namespace
}  // namespace segserve::eval
