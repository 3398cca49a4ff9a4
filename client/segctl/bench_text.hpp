// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "client/segctl/bench_summary.hpp"

namespace segserve::segctl {

/// A few lines for people.
std::string to_text(const BenchSummary& summary);

}  // namespace segserve::segctl
