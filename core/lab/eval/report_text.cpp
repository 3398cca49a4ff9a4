// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/lab/eval/report.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

std::string number(const std::optional<double>& value, int digits, int width) {
  return value ? fmt::format("{:{}.{}f}", *value, width, digits) : fmt::format("{:>{}}", "-", width);
}

std::string row(std::string_view name, int name_width, const MetricValues& v) {
  std::string text = fmt::format("{:{}} {} {}", name, name_width, number(v[metric("supervoxels")], 0, 11),
                                 number(v[metric("segments")], 1, 8));
  for (const std::size_t m : {metric("one_to_one.wov"), metric("one_to_one.tp"), metric("paper_all.wov"),
                              metric("paper_objects.wov"), metric("paper_objects.tp"), metric("paper_objects.fp")}) {
    text += number(v[m], 4, m == metric("paper_all.wov") || m == metric("paper_objects.wov") ? 9 : 8);
  }
  return text + number(v[metric("ms")], 1, 9) + "\n";
}

std::string mean_line(std::string_view name, const MetricValues& v, std::initializer_list<std::size_t> metrics,
                      int digits = 4) {
  std::string text = fmt::format("{:<19}", name);
  for (const std::size_t m : metrics) {
    const std::string_view full = kMetrics[m].name;
    text += fmt::format("  {} {}", full.substr(full.find('.') + 1), number(v[m], digits, 0));
  }
  return text + "\n";
}

std::string own_text(const Report& report) {
  int width = 5;
  for (const SceneScores& scene : report.per_scene) width = std::max(width, static_cast<int>(scene.file.size()));
  std::string text = fmt::format("{:{}} {:>11} {:>8} {:>15} {:>8} {:>23} {:>9}\n", "", width, "", "", "one_to_one",
                                 "all", "objects", "");
  text += fmt::format("{:{}} supervoxels segments     WOv      tp      WOv      WOv      tp      fp       ms\n",
                      "scene", width);
  for (const SceneScores& scene : report.per_scene) text += row(scene.file, width, scene.values);
  const MetricValues v = mean(report.per_scene);
  text += row("mean", width, v);
  text += fmt::format("\n{}\n", headline(report));
  text += mean_line("one_to_one", v,
                    {metric("one_to_one.wov"), metric("one_to_one.tp"), metric("one_to_one.fp"),
                     metric("one_to_one.fn"), metric("one_to_one.f")});
  text += mean_line("paper, all regions", v,
                    {metric("paper_all.wov"), metric("paper_all.tp"), metric("paper_all.fp"), metric("paper_all.fn")});
  text += mean_line("paper, objects", v,
                    {metric("paper_objects.wov"), metric("paper_objects.tp"), metric("paper_objects.fp"),
                     metric("paper_objects.fn")});
  text += mean_line("instances (objects)", v,
                    {metric("instance.ap"), metric("instance.ap50"), metric("instance.ap75"), metric("instance.ar"),
                     metric("instance.ar50"), metric("instance.ar75")});
  text +=
      mean_line("panoptic, all", v, {metric("panoptic_all.pq"), metric("panoptic_all.sq"), metric("panoptic_all.rq")});
  text += mean_line("panoptic, objects", v,
                    {metric("panoptic_objects.pq"), metric("panoptic_objects.sq"), metric("panoptic_objects.rq")});
  text += mean_line("overlap, objects", v,
                    {metric("overlap_objects.precision"), metric("overlap_objects.recall"), metric("overlap_objects.f"),
                     metric("overlap_objects.objects_f75")});
  text += mean_line("objects per scene", v,
                    {metric("object_counts.objects"), metric("object_counts.over_segmented"),
                     metric("object_counts.under_segmented"), metric("object_counts.missed")},
                    2);
  text += mean_line("boundaries", v, {metric("boundary.precision"), metric("boundary.recall"), metric("boundary.f")});
  text +=
      mean_line("supervoxels", v,
                {metric("supervoxel_quality.achievable_accuracy"), metric("supervoxel_quality.undersegmentation_error"),
                 metric("supervoxel_quality.boundary_recall")});
  return text;
}

}  // namespace

std::string to_text(const Report& report, const Peer* peer) {
  std::string text = own_text(report);
  if (peer == nullptr) return text;
  text += fmt::format("\n{}\n", own_text(peer->report));
  if (peer->differences.empty())
    return text + "Fewer than two scenes have scores of both, so there is no comparison.\n";
  return text + to_text(peer->differences, report.method, peer->report.method);
}

std::string to_text(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b) {
  std::string text =
      fmt::format("A {}\nB {}\n\n{:<42} {:>9} {:>9} {:>9}  {:^21} {:>8} {:>9} {:>11}\n", a, b, "mean of the scenes",
                  "A", "B", "A - B", "95 % interval", "t", "p, A != B", "p, A better");
  for (const PairedDifference& d : differences) {
    const std::string better = d.p_better ? fmt::format("{:.2g}", *d.p_better) : "-";
    text += fmt::format("{:<42} {:>9.4f} {:>9.4f} {:>+9.4f}  [{:>+9.4f},{:>+9.4f}] {:>8.2f} {:>9.2g} {:>11}\n",
                        kMetrics[d.metric].name, d.mean_a, d.mean_b, d.difference, d.low, d.high, d.t, d.p_two_sided,
                        better);
  }
  return text +
         "\np, A better: paired t-test, one-sided, as the paper's; A is better than B at 0.01 where it is below "
         "0.01.\n";
}

}  // namespace segserve::eval
