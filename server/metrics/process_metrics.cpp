// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/process_metrics.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "server/build_info.hpp"
#include "server/metrics/metric_families.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

/// The numbers of /proc/self/stat from its third field on, which is not a number and counts as 0. Empty if it cannot be
/// read.
std::vector<double> read_stat() {
  std::ifstream file("/proc/self/stat");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t name_end = text.rfind(')');  // the name of the program, field 2, may hold anything
  if (name_end == std::string::npos || name_end + 3 >= text.size()) return {};
  std::istringstream rest(text.substr(name_end + 3));
  std::vector<double> numbers{0};
  std::copy(std::istream_iterator<double>(rest), {}, std::back_inserter(numbers));
  return numbers;
}

/// When the machine was started, seconds since 1970.
std::optional<double> boot_time() {
  std::ifstream file("/proc/stat");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("btime ")) return std::stod(line.substr(6));
  }
  return std::nullopt;
}

void add_stat(std::vector<prometheus::MetricFamily>& families) {
  // The places in read_stat: three less than the numbers of the fields in proc(5).
  constexpr std::size_t kUserTicks = 11, kSystemTicks = 12, kThreads = 17, kStart = 19, kVirtual = 20, kResident = 21;
  const std::vector<double> stat = read_stat();
  if (stat.size() <= kResident) return;
  const auto ticks_per_second = static_cast<double>(sysconf(_SC_CLK_TCK));
  families.push_back(counter("process_cpu_seconds_total", "Total user and system CPU time spent in seconds.",
                             (stat[kUserTicks] + stat[kSystemTicks]) / ticks_per_second));
  families.push_back(gauge("process_threads", "Number of OS threads in the process.", stat[kThreads]));
  families.push_back(gauge("process_virtual_memory_bytes", "Virtual memory size in bytes.", stat[kVirtual]));
  families.push_back(gauge("process_resident_memory_bytes", "Resident memory size in bytes.",
                           stat[kResident] * static_cast<double>(sysconf(_SC_PAGESIZE))));
  if (const auto boot = boot_time()) {
    families.push_back(gauge("process_start_time_seconds", "Start time of the process since unix epoch in seconds.",
                             *boot + stat[kStart] / ticks_per_second));
  }
}

void add_descriptors(std::vector<prometheus::MetricFamily>& families) {
  std::error_code error;
  double count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end;
       entry.increment(error)) {
    count += 1;
  }
  if (!error) families.push_back(gauge("process_open_fds", "Number of open file descriptors.", count));
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    families.push_back(
        gauge("process_max_fds", "Maximum number of open file descriptors.", static_cast<double>(limit.rlim_cur)));
  }
}

}  // namespace

std::vector<prometheus::MetricFamily> ProcessMetrics::Collect() const {
  std::vector<prometheus::MetricFamily> families;
  add_stat(families);
  add_descriptors(families);
  families.push_back(gauge("segserve_build_info", "Always 1. The labels tell which build of segserve this is.",
                           {{1, {{"version", kVersion}, {"revision", kRevision}, {"compiler", kCompiler}}}}));
  return families;
}

}  // namespace segserve::server
