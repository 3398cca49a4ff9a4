// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/comparable.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::bench_report {
namespace {

using Json = nlohmann::ordered_json;
using Flags = std::map<std::string, std::string>;

/// Flags that change where to, how long or what for it is measured, but not what.
constexpr std::array<std::string_view, 22> kOtherFlags{
    "--server",     "--tls",      "--tls-ca",       "--tls-cert",       "--tls-key", "--tls-server-name",
    "--token-file", "--duration", "--warm-up",      "--objective",      "--json",    "--html",
    "--csv",        "--hdr",      "--hdr-log",      "--metrics-listen", "--metrics", "--verify",
    "--timeout",    "--seed",     "--until-stable", "--server-metrics"};

/// Members that must be alike, with their names for people.
constexpr std::array<std::pair<const char*, const char*>, 8> kMembers{{{"loop", "loop"},
                                                                       {"arrivals", "arrivals"},
                                                                       {"speed", "speed of the replay"},
                                                                       {"clients", "clients"},
                                                                       {"in_flight", "frames in flight"},
                                                                       {"codec", "codec"},
                                                                       {"encoded_beforehand", "encoded beforehand"},
                                                                       {"offered_frames_per_s", "offered frames/s"}}};

Json member(const Json& object, const char* name) {
  if (!object.is_object()) return {};
  const auto found = object.find(name);
  return found == object.end() ? Json() : *found;
}

std::string shown(const Json& value) {
  if (value.is_null()) return "none";
  if (value.is_string()) return fmt::format("'{}'", value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  return value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : value.dump(-1, ' ', true);
}

/// Whether numbers differ by less than `share` of the larger one.
bool are_near(double a, double b, double share) {
  return std::abs(a - b) <= share * std::max(std::abs(a), std::abs(b));
}

bool are_alike(const Json& a, const Json& b) {
  // An offered rate is measured with some error if frames come at random times.
  if (a.is_number() && b.is_number()) return are_near(a.get<double>(), b.get<double>(), 1e-3);
  return a == b;
}

/// A schedule of several levels.
Json labels(const Json& run) {
  Json list = Json::array();
  for (const Json& point : member(run, "points")) list.push_back(point["label"]);
  return list;
}

/// The mean points of a frame with a result.
std::optional<double> points_of_frame(const Json& run) {
  const Json points = member(run, "mpoints_per_s"), frames = member(run, "frames_per_s");
  const bool is_known = points.is_number() && frames.is_number() && frames.get<double>() > 0;
  return is_known ? std::optional(1e6 * points.get<double>() / frames.get<double>()) : std::nullopt;
}

/// The flags of a command line with their values: {"--clients", "4"}.
Flags flags_of(const Json& run) {
  Flags flags;
  std::string* values = nullptr;
  for (const Json& part : member(run, "command")) {
    const std::string word = part.get<std::string>();
    if (word.starts_with("--")) {
      const std::size_t equals = word.find('=');
      values = &flags[word.substr(0, equals)];
      if (equals != std::string::npos) values->append(" ").append(word, equals + 1);
    } else if (values != nullptr) {
      values->append(" ").append(word);
    }
  }
  for (const std::string_view other : kOtherFlags) flags.erase(std::string(other));
  return flags;
}

std::string shown(const Flags& flags, const std::string& name) {
  const auto found = flags.find(name);
  if (found == flags.end()) return "not given";
  return found->second.empty() ? "given" : found->second.substr(1);
}

void compare_flags(const Json& a, const Json& b, std::vector<std::string>& reasons) {
  if (member(a, "command").is_null() || member(b, "command").is_null()) return;
  const Flags flags_a = flags_of(a), flags_b = flags_of(b);
  std::set<std::string> names;
  for (const Flags* flags : {&flags_a, &flags_b}) {
    for (const auto& [name, value] : *flags) names.insert(name);
  }
  // These are told by what became of them.
  for (const char* name :
       {"--clients", "--in-flight", "--codec", "--rate", "--arrivals", "--speed", "--encoded-beforehand"}) {
    names.erase(name);
  }
  for (const std::string& name : names) {
    const std::string value_a = shown(flags_a, name), value_b = shown(flags_b, name);
    if (value_a != value_b) reasons.push_back(fmt::format("{}: {} and {}", name, value_a, value_b));
  }
}

}  // namespace

std::vector<std::string> reasons_not_to_compare(const Json& a, const Json& b) {
  std::vector<std::string> reasons;
  const bool is_search = !member(a, "search").is_null() && !member(b, "search").is_null();
  for (const auto& [name, text] : kMembers) {
    if (is_search && std::string_view(name) == "offered_frames_per_s") continue;  // It is what both looked for.
    const Json value_a = member(a, name), value_b = member(b, name);
    if (!are_alike(value_a, value_b)) {
      reasons.push_back(fmt::format("{}: {} and {}", text, shown(value_a), shown(value_b)));
    }
  }
  if (const Json of_a = labels(a), of_b = labels(b); of_a != of_b && !is_search) {
    reasons.push_back(fmt::format("schedule: {} and {}", shown(of_a), shown(of_b)));
  }
  const auto points_a = points_of_frame(a), points_b = points_of_frame(b);
  if (points_a && points_b && !are_near(*points_a, *points_b, 0.02)) {
    reasons.push_back(fmt::format("points a frame: {:.0f} and {:.0f}", *points_a, *points_b));
  }
  const Json faults_a = member(a, "faults"), faults_b = member(b, "faults");
  if (faults_a.is_null() != faults_b.is_null()) {
    reasons.push_back(fmt::format("faults mixed in: {} and {}", shown(faults_a), shown(faults_b)));
  }
  const Json search_a = member(member(a, "search"), "objective"), search_b = member(member(b, "search"), "objective");
  if (search_a != search_b) reasons.push_back(fmt::format("search: {} and {}", shown(search_a), shown(search_b)));
  compare_flags(a, b, reasons);
  if (member(a, "frames")["results"].get<double>() == 0) reasons.emplace_back("the first load test has no result");
  return reasons;
}

std::vector<std::string> caveats(const Json& a, const Json& b) {
  std::vector<std::string> texts;
  for (const auto& [name, what] : {std::pair{"name", "machine"}, {"cpu_model", "CPU"}, {"cpus", "number of CPUs"}}) {
    const Json value_a = member(member(a, "host"), name), value_b = member(member(b, "host"), name);
    if (value_a != value_b) {
      texts.push_back(fmt::format("the {} is another one: {} and {}", what, shown(value_a), shown(value_b)));
    }
  }
  for (const auto& [run, which] : {std::pair{&a, "first"}, {&b, "second"}}) {
    for (const Json& finding : member(*run, "findings")) {
      texts.push_back(fmt::format("the {} load test says: {}", which, finding["text"].get<std::string>()));
    }
  }
  return texts;
}

}  // namespace segserve::bench_report
