// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/codec_message.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/draco.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::wire {
namespace {

// Draco comes last, because `codecs` leaves it out if the build does not have it.
constexpr std::array kCodecs{
    CodecInfo{Codec::kPlanar, "planar", v1::PAYLOAD_KIND_PLANAR, true, "a plane per coordinate, not compressed"},
    CodecInfo{Codec::kPlanarZstd, "planar-zstd", v1::PAYLOAD_KIND_PLANAR, true, "as planar, compressed with zstd"},
    CodecInfo{Codec::kStrided, "strided", v1::PAYLOAD_KIND_STRIDED, true, "point by point, as PointCloud2"},
    CodecInfo{Codec::kStridedZstd, "strided-zstd", v1::PAYLOAD_KIND_STRIDED, true, "as strided, compressed with zstd"},
    CodecInfo{Codec::kQuantised, "quantised", v1::PAYLOAD_KIND_QUANTISED, false,
              "coordinates within an error bound, colors exactly"},
    CodecInfo{Codec::kPcd, "pcd", v1::PAYLOAD_KIND_PCD_FILE, true, "a PCD file, binary_compressed"},
    CodecInfo{Codec::kRgbd, "rgbd", v1::PAYLOAD_KIND_RGBD, false,
              "16-bit PNG depth and JPEG color; organized CAMERA clouds only"},
    CodecInfo{Codec::kDraco, "draco", v1::PAYLOAD_KIND_DRACO, false,
              "coordinates within an error bound, colors exactly"},
};

/// A kind of payload, the member of v1.Cloud that holds it, and the name of that member.
struct KindName {
  v1::PayloadKind kind;
  v1::Cloud::PayloadCase member;
  std::string_view name;
};
constexpr std::array kKinds{
    KindName{v1::PAYLOAD_KIND_PLANAR, v1::Cloud::kPlanar, "planar"},
    KindName{v1::PAYLOAD_KIND_PCD_FILE, v1::Cloud::kPcdFile, "pcd_file"},
    KindName{v1::PAYLOAD_KIND_STRIDED, v1::Cloud::kStrided, "strided"},
    KindName{v1::PAYLOAD_KIND_QUANTISED, v1::Cloud::kQuantised, "quantised"},
    KindName{v1::PAYLOAD_KIND_RGBD, v1::Cloud::kRgbd, "rgbd"},
    KindName{v1::PAYLOAD_KIND_DRACO, v1::Cloud::kDraco, "draco"},
};

bool is_accepted(v1::PayloadKind kind, const codec::DecodeLimits& limits) {
  return kind != v1::PAYLOAD_KIND_DRACO || (limits.draco && codec::draco_is_built());
}

}  // namespace

std::span<const CodecInfo> codecs() {
  return std::span(kCodecs).first(codec::draco_is_built() ? kCodecs.size() : kCodecs.size() - 1);
}

const CodecInfo& info(Codec codec) { return *std::ranges::find(kCodecs, codec, &CodecInfo::codec); }

absl::StatusOr<Codec> codec_from_name(std::string_view name) {
  std::vector<std::string_view> names;
  for (const CodecInfo& entry : codecs()) {
    if (entry.name == name) return entry.codec;
    names.push_back(entry.name);
  }
  return absl::InvalidArgumentError(fmt::format("there is no codec '{}'; there are {}", name, fmt::join(names, ", ")));
}

absl::StatusOr<v1::Cloud> to_message(const CloudView& cloud, const CodecOptions& options) {
  switch (options.codec) {
    case Codec::kPlanar:
      return to_planar_message(cloud, v1::COMPRESSION_NONE);
    case Codec::kPlanarZstd:
      return to_planar_message(cloud, v1::COMPRESSION_ZSTD);
    case Codec::kStrided:
      return to_strided_message(cloud, v1::COMPRESSION_NONE);
    case Codec::kStridedZstd:
      return to_strided_message(cloud, v1::COMPRESSION_ZSTD);
    case Codec::kQuantised:
      return to_quantised_message(cloud, options.error_bound);
    case Codec::kPcd:
      return to_pcd_message(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinaryCompressed), cloud.view);
    case Codec::kRgbd:
      return to_rgbd_message(cloud, options.jpeg_quality);
    case Codec::kDraco:
      return to_draco_message(cloud, options.error_bound);
  }
  return absl::InvalidArgumentError(
      fmt::format("there is no codec with the number {}", static_cast<int>(options.codec)));
}

std::string_view name(v1::PayloadKind kind) {
  const auto* found = std::ranges::find(kKinds, kind, &KindName::kind);
  return found == kKinds.end() ? "unknown" : found->name;
}

v1::PayloadKind kind_of(const v1::Cloud& message) {
  const auto* found = std::ranges::find(kKinds, message.payload_case(), &KindName::member);
  return found == kKinds.end() ? v1::PAYLOAD_KIND_UNSPECIFIED : found->kind;
}

std::vector<v1::PayloadKind> accepted_kinds(const codec::DecodeLimits& limits) {
  std::vector<v1::PayloadKind> accepted;
  for (const KindName& entry : kKinds) {
    if (is_accepted(entry.kind, limits)) accepted.push_back(entry.kind);
  }
  return accepted;
}

absl::Status check_kind(const v1::Cloud& message, const codec::DecodeLimits& limits) {
  const auto* found = std::ranges::find(kKinds, message.payload_case(), &KindName::member);
  if (found == kKinds.end() || is_accepted(found->kind, limits)) return absl::OkStatus();
  std::vector<std::string_view> names;
  for (const v1::PayloadKind kind : accepted_kinds(limits)) names.push_back(name(kind));
  return invalid_fields({{fmt::format("cloud.{}", found->name),
                          fmt::format("not enabled here; enabled are {}", fmt::join(names, ", "))}});
}

}  // namespace segserve::wire
