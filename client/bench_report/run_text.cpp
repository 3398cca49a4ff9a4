// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/run_text.hpp"

#include <algorithm>
#include <string_view>

#include "client/bench_report/printable.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::bench_report {
namespace {

using Json = nlohmann::ordered_json;

/// A member of an object, or null.
const Json& member(const Json& object, const char* name) {
  static const Json kNull;
  const auto found = object.find(name);
  return found == object.end() ? kNull : *found;
}

std::string number(const Json& value, int digits = 1) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

std::string shown(const Json& text) { return printable(text.get<std::string>()); }

std::string latency_text(const Json& run) {
  std::string text;
  const Json& beyond = member(run, "latency_beyond");
  const Json& too_few = member(run, "too_few_samples_for");
  for (const auto& [name, value] : run["latency_ms"].items()) {
    const bool is_beyond = std::ranges::find(beyond, Json(name)) != beyond.end();
    const bool has_few = std::ranges::find(too_few, Json(name)) != too_few.end();
    text += fmt::format("{}{}{} {}{}", text.empty() ? "" : ", ", has_few ? "(" : "", printable(std::string(name)),
                        is_beyond ? "infinite" : number(value), has_few ? ")" : "");
  }
  return text;
}

std::string rows_text(const Json& rows, const char* name, const char* rate) {
  std::string text;
  for (const Json& row : rows) {
    const Json& latency = member(row, "latency_ms");
    const bool has_latency = latency.is_object();
    text += fmt::format("  {:<24} {:>10} {:>10} {:>10} {:>8}\n", shown(row[name]), number(member(row, rate)),
                        has_latency ? number(member(latency, "p50")) : "-",
                        has_latency ? number(member(latency, "p99")) : "-", number(member(row, "failed"), 0));
  }
  return text;
}

constexpr std::string_view kRowHead = "frames/s     p50 ms     p99 ms   failed\n";

}  // namespace

std::string to_text(const Json& run) {
  const Json& offered = member(run, "offered_frames_per_s");
  std::string text = fmt::format("{} {} at {}{}: {} frames sent, {} results\n", number(run["clients"], 0),
                                 run["clients"] == 1 ? "client" : "clients", shown(run["server"]),
                                 offered.is_null() ? "" : ", " + number(offered) + " frames/s offered",
                                 number(run["frames"]["sent"], 0), number(run["frames"]["results"], 0));
  text += fmt::format("throughput    {} frames/s\nlatency ms    {}\n", number(member(run, "achieved_frames_per_s")),
                      latency_text(run));
  for (const auto& [reason, count] : member(run, "errors").items()) {
    text += fmt::format("error         {} times {}\n", number(count, 0), printable(std::string(reason)));
  }
  const Json& codecs = member(run, "codecs");
  const Json& points = member(run, "points");
  if (codecs.size() > 1)
    text += fmt::format("  {:<26} {}", "codec", kRowHead) + rows_text(codecs, "codec", "frames_per_s");
  if (points.size() > 1) {
    text += fmt::format("  {:<26} {}", "load", kRowHead) + rows_text(points, "label", "achieved_frames_per_s");
  }
  for (const Json& finding : member(run, "findings")) {
    text += fmt::format("{}: {}\n", shown(finding["code"]), shown(finding["text"]));
  }
  return text;
}

}  // namespace segserve::bench_report
