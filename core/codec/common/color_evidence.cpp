// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/color_evidence.hpp"

namespace segserve::codec {

bool are_channels(const std::array<ChannelEvidence, 3>& channels, bool are_last) {
  constexpr double kFewestLevels = 16, kMostAlike = 30;
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  bool has_levels = false, varies = false;
  std::size_t whole = 0, constant = 0;
  for (const ChannelEvidence& channel : channels) {
    if (!channel.is_in_range()) return false;
    whole += channel.has_decimals() ? 0 : 1;
    constant += !channel.has_decimals() && channel.is_constant() ? 1 : 0;
    varies = varies || !channel.is_constant();
    has_levels = has_levels || channel.has_levels();
    if (channel.largest() > 0) smallest = std::min(smallest, channel.largest());
    largest = std::max(largest, channel.largest());
  }
  const bool has_decimals = whole < channels.size();
  if (has_decimals && (has_levels || (constant == 2 && varies) || (whole > 0 && largest > 1))) return false;
  if (!has_decimals && largest < kFewestLevels && (has_levels || !are_last)) return false;
  return largest == 0 || largest <= kMostAlike * smallest;
}

}  // namespace segserve::codec
