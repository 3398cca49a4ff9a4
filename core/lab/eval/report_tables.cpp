// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/report_tables.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

struct Column {
  std::string_view title;
  std::size_t metric;
};

/// The scores of a scene in its table.
constexpr std::array kSceneColumns = {
    Column{"supervoxels", metric("supervoxels")},
    Column{"segments", metric("segments")},
    Column{"one_to_one WOv", metric("one_to_one.wov")},
    Column{"all WOv", metric("paper_all.wov")},
    Column{"objects WOv", metric("paper_objects.wov")},
    Column{"AP", metric("instance.ap")},
    Column{"PQ, objects", metric("panoptic_objects.pq")},
    Column{"overlap F", metric("overlap_objects.f")},
    Column{"boundary F", metric("boundary.f")},
    Column{"objects", metric("object_counts.objects")},
    Column{"over-segmented", metric("object_counts.over_segmented")},
    Column{"under-segmented", metric("object_counts.under_segmented")},
    Column{"missed", metric("object_counts.missed")},
    Column{"ms", metric("ms")},
};

/// The scores of the peer beside them.
constexpr std::array kPeerColumns = {
    Column{"one_to_one WOv", metric("one_to_one.wov")},
    Column{"objects WOv", metric("paper_objects.wov")},
};

/// Counts and times have fewer digits than shares.
int digits_of(std::size_t m) {
  const std::string_view name = kMetrics[m].name;
  const bool is_count = name == "supervoxels" || name == "segments" || name.starts_with("object_counts.");
  return is_count ? 2 : name == "ms" ? 1 : 4;
}

std::string cell(const std::optional<double>& value, std::size_t m) {
  return value ? fmt::format("{:.{}f}", *value, digits_of(m)) : "-";
}

/// A cell of one scene, in which counts are whole numbers.
std::string scene_cell(const MetricValues& values, std::size_t m) {
  const bool is_count = digits_of(m) == 2;
  return is_count && values[m] ? fmt::format("{:.0f}", *values[m]) : cell(values[m], m);
}

/// The difference from the peer, its interval and the p-value, as far as they are defined.
std::vector<std::string> difference_cells(const Peer& peer, std::size_t m) {
  const auto d = std::ranges::find(peer.differences, m, &PairedDifference::metric);
  if (d == peer.differences.end()) return {"-", "-", "-"};
  const int digits = digits_of(m);
  return {fmt::format("{:+.{}f}", d->difference, digits),
          fmt::format("{:+.{}f} to {:+.{}f}", d->low, digits, d->high, digits),
          d->p_better ? fmt::format("{:.2g}", *d->p_better) : "-"};
}

ReportTable table_of_means(const Report& report, const Peer* peer) {
  ReportTable table{"Means of the scenes", {"metric", report.method}, {}};
  if (peer != nullptr) {
    for (std::string title : {peer->report.method, std::string("difference"), std::string("95 % interval"),
                              fmt::format("p, {} better", report.method)}) {
      table.columns.push_back(std::move(title));
    }
  }
  const MetricValues own = mean(report.per_scene);
  const MetricValues others = peer == nullptr ? MetricValues{} : mean(peer->report.per_scene);
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    std::vector<std::string> row{std::string(kMetrics[m].name), cell(own[m], m)};
    if (peer != nullptr) {
      row.push_back(cell(others[m], m));
      for (std::string& text : difference_cells(*peer, m)) row.push_back(std::move(text));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportTable table_of_scenes(const Report& report, const Peer* peer) {
  ReportTable table{"Scenes", {"scene"}, {}};
  for (const Column& column : kSceneColumns) table.columns.emplace_back(column.title);
  if (peer != nullptr) {
    for (const Column& column : kPeerColumns) {
      table.columns.push_back(fmt::format("{}, {}", column.title, peer->report.method));
    }
  }
  for (const SceneScores& scene : report.per_scene) {
    std::vector<std::string> row{scene.file};
    for (const Column& column : kSceneColumns) row.push_back(scene_cell(scene.values, column.metric));
    if (peer != nullptr) {
      const auto& rows = peer->report.per_scene;
      const auto other = std::ranges::find(rows, scene.file, &SceneScores::file);
      for (const Column& column : kPeerColumns) {
        row.push_back(other == rows.end() ? "-" : scene_cell(other->values, column.metric));
      }
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_failures(const Report& report, ReportTable& table) {
  for (const SceneFailure& scene : report.failed) {
    table.rows.push_back({scene.file, report.method, message_of(scene.status)});
  }
}

}  // namespace

std::vector<ReportTable> tables_of(const Report& report, const Peer* peer) {
  std::vector<ReportTable> tables{table_of_means(report, peer), table_of_scenes(report, peer)};
  ReportTable failures{"Scenes that could not be scored", {"scene", "method", "error"}, {}};
  add_failures(report, failures);
  if (peer != nullptr) add_failures(peer->report, failures);
  if (!failures.rows.empty()) tables.push_back(std::move(failures));
  return tables;
}

}  // namespace segserve::eval
