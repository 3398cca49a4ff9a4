// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "segserve/options.hpp"
#include "segserve/v1/options.pb.h"

namespace segserve::wire {

v1::Method to_message(Method method);
std::optional<Method> from_message(v1::Method method);  ///< nullopt for UNSPECIFIED and unknown ones

/// What is set in the options; the rest is left to the server's defaults.
v1::SegmentOptions to_message(const Options& options);

/// The options of a request: `defaults` where it says nothing. A cut in the message replaces the cut of
/// the defaults. Appends one entry per wrong option to `faults`, by its path ("options.lambda").
Options from_message(const v1::SegmentOptions& message, const Options& defaults, std::vector<FieldViolation>& faults);

/// What is wrong with valid options for a cloud in this view, by paths as above.
std::vector<FieldViolation> violations_in_view(const Options& options, const View& view);

/// 16 hexadecimal digits (FNV-1a) over all options that decide results, the method's defaults included: not the
/// number of threads.
std::string options_hash(const Options& options);

}  // namespace segserve::wire
