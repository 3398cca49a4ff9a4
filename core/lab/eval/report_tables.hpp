// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/lab/eval/report.hpp"

namespace segserve::eval {

/// A table of text; the first column names the rows, and the others hold numbers. Nothing is escaped.
struct ReportTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< As many cells as columns.
};

/// The tables of a report, without empty ones: the means of all metrics, each scene with its main scores, and the
/// scenes that could not be scored. With a peer the means stand side by side, with their difference, its 95 % interval
/// and the p-value that `report` is better; each scene has the peer's main scores, too.
std::vector<ReportTable> tables_of(const Report& report, const Peer* peer);

}  // namespace segserve::eval
