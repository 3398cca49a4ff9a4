// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "segserve/options.hpp"
#include "segserve/v1/options.pb.h"

namespace segserve::wire {

/// The message of a method.
v1::Method to_message(Method method);

/// The method of a message; nullopt if it is unspecified or unknown.
std::optional<Method> from_message(v1::Method method);

/// The message of a preset.
v1::Preset to_message(Preset preset);

/// The preset of a message; nullopt if it is unspecified or unknown.
std::optional<Preset> from_message(v1::Preset preset);

/// The message of the options. An option that is unset stays unset, so that the server's default applies.
v1::SegmentOptions to_message(const Options& options);

/// The options of a message. A field that is unset takes its value from `defaults`. A threshold or number of regions in
/// the message replaces both of those of `defaults`. Appends every wrong option to `faults`, with paths such as
/// "options.lambda".
Options from_message(const v1::SegmentOptions& message, const Options& defaults, std::vector<FieldViolation>& faults);

/// The faults that valid options have for a cloud in this view, with paths such as "options.range_max".
std::vector<FieldViolation> violations_in_view(const Options& options, const View& view);

/// A hash of all options that decide results, as 16 hexadecimal digits (64-bit FNV-1a). Options that are unset count
/// with the method's defaults. The number of threads has no influence.
std::string options_hash(const Options& options);

}  // namespace segserve::wire
