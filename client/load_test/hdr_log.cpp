// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/hdr_log.hpp"

#include <algorithm>
#include <ctime>

#include "client/load_test/hdr_encoding.hpp"
#include "fmt/chrono.h"
#include "fmt/format.h"

namespace segserve::bench {

HdrLog::HdrLog(double started)
    : started_(started),
      text_(fmt::format("#[Latencies of segctl bench in microseconds; failed frames are not among them]\n"
                        "#[Histogram log format version 1.3]\n"
                        "#[StartTime: {0:.3f} (seconds since epoch), {1:%Y-%m-%dT%H:%M:%SZ}]\n"
                        "#[BaseTime: {0:.3f} (seconds since epoch)]\n"
                        "\"StartTimestamp\",\"Interval_Length\",\"Interval_Max\",\"Interval_Compressed_Histogram\"\n",
                        started, fmt::gmtime(static_cast<std::time_t>(started)))) {}

void HdrLog::add(double at, double seconds, const HdrHistogram& histogram) {
  text_ += fmt::format("{:.3f},{:.3f},{:.3f},{}\n", std::max(0.0, at - started_), seconds,
                       static_cast<double>(histogram.max()) / 1000, to_hdr_base64(histogram));
}

}  // namespace segserve::bench
