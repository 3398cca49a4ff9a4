// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "client/bench_report/printable.hpp"
#include "client/bench_report/run_diff.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::bench_report {
namespace {

using Json = nlohmann::ordered_json;

std::string figure_text(double value) { return std::isinf(value) ? "infinite" : fmt::format("{:.2f}", value); }

/// "+15.3 %", "+0.20 points".
std::string change_text(double change, bool is_share) {
  if (std::isinf(change)) return change > 0 ? "infinite" : "-infinite";
  return is_share ? fmt::format("{:+.2f} points", change) : fmt::format("{:+.1f} %", 100 * change);
}

std::string interval_text(const DiffRow& row) {
  if (!row.low || !row.high) return "-";
  return fmt::format("{} to {}", change_text(*row.low, row.is_share), change_text(*row.high, row.is_share));
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json row_json(const DiffRow& row) {
  const bool is_infinite = !std::isfinite(row.a) || !std::isfinite(row.b) || !std::isfinite(row.change);
  return {{"figure", row.name},
          {"unit", row.unit},
          {"a", number(row.a)},
          {"b", number(row.b)},
          {row.is_share ? "change_points" : "change_percent", number(row.is_share ? row.change : 100 * row.change)},
          {"interval", row.low ? Json{number(row.is_share ? *row.low : 100 * *row.low),
                                      number(row.is_share ? *row.high : 100 * *row.high)}
                               : Json()},
          {"interval_from", row.low ? Json(row.method) : Json()},
          {"is_infinite", is_infinite},
          {"verdict", name(row.verdict)}};
}

}  // namespace

std::string worse_figures(const RunDiff& diff) {
  std::string text;
  for (const DiffRow& row : diff.rows) {
    if (row.verdict != DiffVerdict::kWorse) continue;
    text += fmt::format("{}{} by {}", text.empty() ? "" : ", ", row.name, change_text(row.change, row.is_share));
  }
  return text;
}

std::string to_text(const RunDiff& diff) {
  const std::string interval = fmt::format("{:g} % interval of it", 100 * diff.options.confidence);
  std::string text = fmt::format("{:<30} {:>10} {:>10} {:>14}  {:<32} {:<10} verdict\n", "figure", "first", "second",
                                 "change", interval, "from");
  for (const DiffRow& row : diff.rows) {
    text += fmt::format("{:<30} {:>10} {:>10} {:>14}  {:<32} {:<10} {}\n", fmt::format("{}, {}", row.name, row.unit),
                        figure_text(row.a), figure_text(row.b), change_text(row.change, row.is_share),
                        interval_text(row), row.method, name(row.verdict));
  }
  const bool is_unclear =
      std::ranges::any_of(diff.rows, [](const DiffRow& row) { return row.verdict == DiffVerdict::kUnclear; });
  if (is_unclear)
    text +=
        "unclear: the load tests are too short, or too uneven, to tell a change that is allowed from one that is not\n";
  for (const std::string& caveat : diff.caveats) text += printable(caveat) + "\n";
  return text;
}

Json to_json(const RunDiff& diff) {
  Json json{{"format", "segserve-bench-diff-1"},
            {"allow_percent", 100 * diff.options.allow},
            {"confidence_percent", 100 * diff.options.confidence},
            {"seed", diff.options.seed},
            {"verdict", worse_figures(diff).empty() ? "no worse" : "worse"},
            {"rows", Json::array()},
            {"caveats", diff.caveats}};
  for (const DiffRow& row : diff.rows) json["rows"].push_back(row_json(row));
  return json;
}

}  // namespace segserve::bench_report
