// SPDX-License-Identifier: Apache-2.0
// Stands in for draco.cpp in a build without Draco.
#include "segserve/codec/draco.hpp"

namespace segserve::codec {
namespace {

absl::Status absent() { return absl::UnimplementedError("this program was built without Draco (SEGSERVE_WITH_DRACO)"); }

}  // namespace

bool draco_is_built() { return false; }

absl::StatusOr<DracoFile> encode_draco(const CloudView& /*cloud*/, double /*error_bound*/) { return absent(); }

absl::StatusOr<Cloud> decode_draco(std::string_view /*data*/, std::string_view /*finite*/, std::uint32_t /*width*/,
                                   std::uint32_t /*height*/, const View& /*view*/, const DecodeLimits& /*limits*/,
                                   const StopToken& /*stop*/) {
  return absent();
}

}  // namespace segserve::codec
