// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "core/codec/las/reference_system.hpp"

// Coordinate reference systems as text: OGC 01-009 ("WKT 1", PROJCS) and ISO 19162 ("WKT 2", PROJCRS).
namespace segserve::codec {

/// Reads the first horizontal system of a text, which may be part of a compound one. Its unit is that of the system or
/// of its axes, the last one if there are several. Heights have that of a vertical system, or of the third axis. A text
/// without such a system tells nothing. nullopt if brackets or quotation marks do not match, or nest deeper than any
/// system does.
std::optional<ReferenceSystem> parse_well_known_text(std::string_view text);

}  // namespace segserve::codec
