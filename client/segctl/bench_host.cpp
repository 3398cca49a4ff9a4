// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_host.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "client/load_test/process_cost.hpp"
#include "fmt/chrono.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

Json cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return nullptr;
}

std::vector<std::string> command_line() {
  std::vector<std::string> words;
  std::ifstream file("/proc/self/cmdline");
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

Json memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  if (pages <= 0) return nullptr;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

Json host_json() {
  utsname names{};
  const bool is_named = uname(&names) == 0;
  std::array<double, 1> load{};
  const bool has_load = getloadavg(load.data(), static_cast<int>(load.size())) == 1;
  return {{"name", is_named ? Json(names.nodename) : Json()},
          {"cpus", bench::usable_cpus()},
          {"cpu_model", cpu_model()},
          {"memory_bytes", memory_bytes()},
          {"kernel", is_named ? Json(fmt::format("{} {} {}", names.sysname, names.release, names.machine)) : Json()},
          {"load_before", has_load ? Json(load[0]) : Json()}};
}

Json client_build_json() {
  return {{"version", SEGSERVE_VERSION}, {"compiler", SEGSERVE_COMPILER}, {"build_type", SEGSERVE_BUILD_TYPE}};
}

std::vector<std::string> bench_words() {
  std::vector<std::string> words = command_line();
  words.erase(words.begin(), std::ranges::find(words, "bench"));
  if (!words.empty()) words.erase(words.begin());
  return words;
}

Json command_line_json() {
  Json words = Json::array();
  bool is_secret = false;
  for (const std::string& word : command_line()) {
    const bool names_secret = word.starts_with("--token-file") || word.starts_with("--tls-key");
    const bool has_value = word.find('=') != std::string::npos;
    if (!is_secret && !names_secret) words.push_back(word);
    is_secret = names_secret && !has_value;
  }
  return words;
}

std::string utc_time(double seconds_since_epoch) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds_since_epoch)));
}

}  // namespace segserve::segctl
