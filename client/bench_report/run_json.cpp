// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/run_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/str_join.h"
#include "core/base/status_macros.hpp"
#include "core/base/strict_json.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::bench_report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxBytes = std::size_t{64} << 20U;
constexpr int kMaxDepth = 16;
constexpr std::size_t kFaultsTold = 8;

enum class Kind {
  kNumber,
  kCount,  ///< a number that is not negative
  kText,
  kFlag,
  kObject,
  kTexts,    ///< a list of texts
  kCounts,   ///< a list of counts
  kNumbers,  ///< an object of numbers, of which any may be null
  kTallies,  ///< an object of counts
  kBuckets,  ///< a list of pairs of counts, of which the first ascend
};

struct Field {
  std::string_view name;
  Kind kind;
  bool is_required = false;  ///< Others may be null or missing.
};

constexpr std::array<Field, 22> kRun{{{"format", Kind::kText, true},
                                      {"server", Kind::kText, true},
                                      {"clients", Kind::kCount, true},
                                      {"frames", Kind::kTallies, true},
                                      {"latency_ms", Kind::kNumbers, true},
                                      {"loop", Kind::kText},
                                      {"codec", Kind::kText},
                                      {"started", Kind::kText},
                                      {"arrivals", Kind::kText},
                                      {"command", Kind::kTexts},
                                      {"offered_frames_per_s", Kind::kCount},
                                      {"achieved_frames_per_s", Kind::kCount},
                                      {"since_sent_ms", Kind::kNumbers},
                                      {"stages_ms", Kind::kNumbers},
                                      {"latency_beyond", Kind::kTexts},
                                      {"too_few_samples_for", Kind::kTexts},
                                      {"errors", Kind::kTallies},
                                      {"faults", Kind::kTallies},
                                      {"results_of_client", Kind::kCounts},
                                      {"results_of_server", Kind::kTallies},
                                      {"client_cpu_ms_per_frame", Kind::kCount},
                                      {"window", Kind::kNumbers}}};
constexpr std::array<Field, 2> kFrames{{{"sent", Kind::kCount, true}, {"results", Kind::kCount, true}}};
constexpr std::array<Field, 4> kHost{
    {{"name", Kind::kText}, {"cpus", Kind::kCount}, {"cpu_model", Kind::kText}, {"kernel", Kind::kText}}};
constexpr std::array<Field, 3> kBuild{
    {{"version", Kind::kText}, {"compiler", Kind::kText}, {"build_type", Kind::kText}}};
constexpr std::array<Field, 4> kSearch{{{"objective", Kind::kText, true},
                                        {"capacity_frames_per_s", Kind::kCount},
                                        {"low", Kind::kCount},
                                        {"high", Kind::kCount}}};
constexpr std::array<Field, 4> kMetrics{{{"queue_wait_ms", Kind::kNumbers},
                                         {"rejected", Kind::kTallies},
                                         {"cpu_ms_per_frame", Kind::kCount},
                                         {"memory_bytes_max", Kind::kCount}}};
constexpr std::array<Field, 2> kHistogram{{{"failed", Kind::kCount}, {"buckets", Kind::kBuckets, true}}};
constexpr std::array<Field, 12> kSecond{{{"t", Kind::kNumber, true},
                                         {"seconds", Kind::kCount},
                                         {"offered", Kind::kCount},
                                         {"sent", Kind::kCount},
                                         {"results", Kind::kCount, true},
                                         {"failed", Kind::kCount},
                                         {"late", Kind::kCount},
                                         {"p50_ms", Kind::kNumber},
                                         {"p90_ms", Kind::kNumber},
                                         {"p99_ms", Kind::kNumber},
                                         {"max_ms", Kind::kNumber},
                                         {"client_busy_cpus", Kind::kCount}}};
constexpr std::array<Field, 6> kCodec{{{"codec", Kind::kText, true},
                                       {"results", Kind::kCount, true},
                                       {"frames_per_s", Kind::kCount},
                                       {"latency_ms", Kind::kNumbers},
                                       {"latency_beyond", Kind::kTexts},
                                       {"stages_ms", Kind::kNumbers}}};
constexpr std::array<Field, 8> kPoint{{{"label", Kind::kText, true},
                                       {"codec", Kind::kText},
                                       {"clients", Kind::kCount},
                                       {"offered_frames_per_s", Kind::kCount},
                                       {"achieved_frames_per_s", Kind::kCount},
                                       {"latency_ms", Kind::kNumbers},
                                       {"failed", Kind::kCount},
                                       {"verdict", Kind::kText}}};
constexpr std::array<Field, 2> kFinding{{{"code", Kind::kText, true}, {"text", Kind::kText, true}}};
constexpr std::array<Field, 3> kObjective{
    {{"objective", Kind::kText, true}, {"value", Kind::kNumber}, {"met", Kind::kFlag, true}}};

bool is_number(const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); }
bool is_count(const Json& value) { return is_number(value) && value.get<double>() >= 0; }
bool is_text(const Json& value) { return value.is_string(); }

bool all(const Json& values, bool (*is_good)(const Json&)) { return std::ranges::all_of(values, is_good); }

bool are_buckets(const Json& list) {
  const Json* before = nullptr;
  for (const Json& bucket : list) {
    if (!bucket.is_array() || bucket.size() != 2 || !all(bucket, is_count)) return false;
    if (before != nullptr && before->get<double>() >= bucket[0].get<double>()) return false;
    before = &bucket[0];
  }
  return true;
}

/// Says what is wrong with a value of this kind, or returns nothing.
std::optional<const char*> fault_of(const Json& value, Kind kind) {
  const auto unless = [](bool is_good, const char* fault) { return is_good ? std::nullopt : std::optional(fault); };
  switch (kind) {
    case Kind::kNumber:
      return unless(is_number(value), "is no number");
    case Kind::kCount:
      return unless(is_count(value), "is no number of at least 0");
    case Kind::kText:
      return unless(is_text(value), "is no text");
    case Kind::kFlag:
      return unless(value.is_boolean(), "is neither true nor false");
    case Kind::kObject:
      return unless(value.is_object(), "is no object");
    case Kind::kTexts:
      return unless(value.is_array() && all(value, is_text), "is no list of texts");
    case Kind::kCounts:
      return unless(value.is_array() && all(value, is_count), "is no list of numbers of at least 0");
    case Kind::kNumbers:
      return unless(value.is_object() && all(value, [](const Json& v) { return v.is_null() || is_number(v); }),
                    "is no object of numbers");
    case Kind::kTallies:
      return unless(value.is_object() && all(value, is_count), "is no object of numbers of at least 0");
    case Kind::kBuckets:
      return unless(value.is_array() && are_buckets(value), "is no list of pairs of numbers with ascending values");
  }
  return "is of no known kind";
}

/// Finds everything in a run that is not as reports expect it.
class Checker {
 public:
  void check_object(const std::string& place, const Json& object, std::span<const Field> fields) {
    if (!object.is_object()) return add(place, "is no object");
    for (const Field& field : fields) {
      const auto found = object.find(std::string(field.name));
      const std::string at = fmt::format("{}{}{}", place, place.empty() ? "" : ".", field.name);
      const bool is_missing = found == object.end() || found->is_null();
      if (is_missing && field.is_required) add(at, "is missing");
      if (is_missing) continue;
      if (const auto fault = fault_of(*found, field.kind)) add(at, *fault);
    }
  }

  /// Checks a member of `run`, which may be missing or null.
  void check_member(const Json& run, const char* name, std::span<const Field> fields) {
    const auto found = run.find(name);
    if (found != run.end() && !found->is_null()) check_object(name, *found, fields);
  }

  void check_list(const Json& run, const char* name, std::span<const Field> fields) {
    const auto found = run.find(name);
    if (found == run.end() || found->is_null()) return;
    if (!found->is_array()) return add(name, "is no list");
    for (std::size_t i = 0; i < found->size(); ++i) check_object(fmt::format("{}[{}]", name, i), (*found)[i], fields);
  }

  void check_times(const Json& run) {
    if (!faults_.empty() || !run.contains("timeline") || run["timeline"].is_null()) return;
    const auto descends = [](const Json& a, const Json& b) { return a["t"].get<double>() >= b["t"].get<double>(); };
    if (std::ranges::adjacent_find(run["timeline"], descends) != run["timeline"].end()) {
      add("timeline", "has times that do not ascend");
    }
  }

  absl::Status status() const {
    if (faults_.empty()) return absl::OkStatus();
    const std::size_t told = std::min(faults_.size(), kFaultsTold);
    std::string text = absl::StrJoin(faults_.begin(), faults_.begin() + static_cast<std::ptrdiff_t>(told), "; ");
    if (told < faults_.size()) text += fmt::format("; and {} more", faults_.size() - told);
    return absl::InvalidArgumentError(text);
  }

 private:
  void add(const std::string& place, const char* fault) { faults_.push_back(fmt::format("{} {}", place, fault)); }

  std::vector<std::string> faults_;
};

}  // namespace

absl::Status check_run(const Json& run) {
  const auto format = run.is_object() ? run.find("format") : run.end();
  if (!run.is_object() || format == run.end() || !format->is_string()) {
    return absl::InvalidArgumentError(
        fmt::format("it is not what segctl bench --json writes: it has no \"format\": \"{}\"", kRunFormat));
  }
  if (format->get<std::string>() != kRunFormat) {
    return absl::InvalidArgumentError(
        fmt::format("its format is '{}', and this segctl reads '{}'", format->get<std::string>(), kRunFormat));
  }
  Checker checker;
  checker.check_object("", run, kRun);
  checker.check_member(run, "frames", kFrames);
  checker.check_member(run, "host", kHost);
  checker.check_member(run, "client_build", kBuild);
  checker.check_member(run, "server_info", {});
  checker.check_member(run, "search", kSearch);
  checker.check_member(run, "server_metrics", kMetrics);
  checker.check_member(run, "latency_histogram", kHistogram);
  checker.check_member(run, "since_sent_histogram", kHistogram);
  checker.check_list(run, "timeline", kSecond);
  checker.check_list(run, "codecs", kCodec);
  checker.check_list(run, "points", kPoint);
  checker.check_list(run, "findings", kFinding);
  checker.check_list(run, "objectives", kObjective);
  checker.check_times(run);
  return checker.status();
}

absl::StatusOr<Json> parse_run(std::string_view bytes) {
  if (bytes.size() > kMaxBytes) {
    return absl::InvalidArgumentError(fmt::format("it has {} bytes; at most {} are read", bytes.size(), kMaxBytes));
  }
  ASSIGN_OR_RETURN(Json run, parse_strict_json<Json>(bytes, kMaxDepth));
  RETURN_IF_ERROR(check_run(run));
  return run;
}

}  // namespace segserve::bench_report
