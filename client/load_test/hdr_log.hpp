// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "client/load_test/hdr_histogram.hpp"

namespace segserve::bench {

/// A log of histograms, one of each interval of a run, in the format 1.3 of HistogramLogWriter, which HdrHistogram's
/// tools and plotters read. Values are microseconds; the column Interval_Max is in milliseconds.
class HdrLog {
 public:
  /// When the run began, seconds since 1970.
  explicit HdrLog(double started);

  /// Adds an interval that began `at` seconds since 1970 and took so many seconds.
  void add(double at, double seconds, const HdrHistogram& histogram);
  const std::string& text() const { return text_; }

 private:
  double started_;
  std::string text_;
};

}  // namespace segserve::bench
