// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "core/tracking/rigid_check.hpp"
#include "core/tracking/state_limits.hpp"
#include "fmt/format.h"
#include "segserve/tracking.hpp"

// The bytes of a state, little endian: "SGTS", the version, flags, the fields of the state, the tracks, and a checksum.
// docs/tracking.md has them one by one.
namespace segserve {
namespace {

constexpr std::string_view kMagic = "SGTS";
constexpr std::uint8_t kVersion = 1;
enum Flag : std::uint8_t { kHasTime = 1, kHasPose = 2, kHasPlane = 4, kAllFlags = 7 };
constexpr std::size_t kChecksumBytes = 8;
using tracking::kFarthest;

/// FNV-1a with 64 bits (Fowler, Noll, Vo). It finds damage, and is no proof of who made the bytes.
std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001B3U;
  return hash;
}

template <typename Value>
using Bits =
    std::conditional_t<sizeof(Value) == 8, std::uint64_t,
                       std::conditional_t<sizeof(Value) == 4, std::uint32_t,
                                          std::conditional_t<sizeof(Value) == 2, std::uint16_t, std::uint8_t>>>;

class Writer {
 public:
  template <typename Value>
  requires std::is_arithmetic_v<Value>
  void put(Value value) {
    const auto bits = std::bit_cast<Bits<Value>>(value);
    for (unsigned shift = 0; shift < 8 * sizeof(Value); shift += 8) bytes_ += static_cast<char>(bits >> shift & 0xFFU);
  }
  template <typename Value, std::size_t kCount>
  void put(const std::array<Value, kCount>& values) {
    for (const Value value : values) put(value);
  }
  void put(std::string_view text) { bytes_ += text; }
  std::string finish() {
    put(checksum(bytes_));
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

/// Reads values one by one. What is not there reads as 0.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename Value>
  requires std::is_arithmetic_v<Value>
  void get(Value& value) {
    Bits<Value> bits = 0;
    is_complete_ = is_complete_ && bytes_.size() >= sizeof(Value);
    for (std::size_t i = 0; is_complete_ && i < sizeof(Value); ++i) {
      bits = static_cast<Bits<Value>>(bits | Bits<Value>{static_cast<std::uint8_t>(bytes_[i])} << (8 * i));
    }
    bytes_.remove_prefix(is_complete_ ? sizeof(Value) : bytes_.size());
    value = std::bit_cast<Value>(bits);
  }
  template <typename Value, std::size_t kCount>
  void get(std::array<Value, kCount>& values) {
    for (Value& value : values) get(value);
  }
  template <typename Value>
  Value get() {
    Value value{};
    get(value);
    return value;
  }
  bool is_complete() const { return is_complete_; }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  bool is_complete_ = true;
};

void put(const RigidTransform& pose, Writer& out) {
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) out.put(pose.rotation(row, column));
  }
  for (Eigen::Index row = 0; row < 3; ++row) out.put(pose.translation[row]);
}

RigidTransform get_pose(Reader& in) {
  RigidTransform pose;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) in.get(pose.rotation(row, column));
  }
  for (Eigen::Index row = 0; row < 3; ++row) in.get(pose.translation[row]);
  return pose;
}

void put(const TrackState::Track& track, Writer& out) {
  out.put(track.id), out.put(track.age), out.put(track.lost), out.put(track.trust);
  out.put(track.center), out.put(track.axes), out.put(track.half_extents), out.put(track.velocity);
  out.put(track.area), out.put(track.step), out.put(track.rgb);
  out.put(static_cast<std::uint8_t>(track.signatures.size()));
  for (const TrackState::Signature& signature : track.signatures) out.put(signature.place), out.put(signature.rgb);
}

template <std::floating_point Number, std::size_t kCount>
bool are_numbers(const std::array<Number, kCount>& values, double most = kFarthest) {
  return std::ranges::all_of(values, [most](Number v) { return std::fabs(v) <= most; });
}

absl::Status wrong(std::string_view what) { return absl::InvalidArgumentError(fmt::format("track state: {}", what)); }

absl::Status check_track(const TrackState::Track& track, std::uint64_t next_id, std::uint64_t id_before) {
  const auto fault = [&](std::string_view what) { return wrong(fmt::format("track {} {}", track.id, what)); };
  if (track.id <= id_before || track.id >= next_id) return fault("is not above the track before and below the next id");
  const bool are_places = are_numbers(track.center) && are_numbers(track.axes, tracking::kLongestAxis) &&
                          are_numbers(track.half_extents) && are_numbers(track.velocity);
  if (!are_places) return fault("has a number that is not finite or too large");
  const bool are_sizes = track.area > 0 && track.area <= kFarthest && track.step > 0 && track.step <= kFarthest &&
                         std::ranges::all_of(track.half_extents, [](float v) { return v >= 0; });
  if (!are_sizes) return fault("has a size that is not positive or too large");
  return absl::OkStatus();
}

/// Reads a track, but stops before signatures that cannot be there.
absl::StatusOr<TrackState::Track> get_track(Reader& in) {
  TrackState::Track track;
  in.get(track.id), in.get(track.age), in.get(track.lost), in.get(track.trust);
  in.get(track.center), in.get(track.axes), in.get(track.half_extents), in.get(track.velocity);
  in.get(track.area), in.get(track.step), in.get(track.rgb);
  const auto count = in.get<std::uint8_t>();
  if (count > TrackState::kMostSignatures) {
    return wrong(
        fmt::format("track {} has {} signatures, of {} at most", track.id, count, TrackState::kMostSignatures));
  }
  track.signatures.resize(count);
  for (TrackState::Signature& signature : track.signatures) in.get(signature.place), in.get(signature.rgb);
  return track;
}

absl::Status check_head(const TrackState& state) {
  if (state.next_id == 0) return wrong("the next id is 0");
  if (state.time && !(std::fabs(*state.time) <= tracking::kLatest)) return wrong("the time is not finite or too large");
  if (state.pose && !tracking::is_rigid(*state.pose)) return wrong("the pose is no rigid motion");
  if (state.plane && !(are_numbers(state.plane->normal, 2) && std::fabs(state.plane->offset) <= kFarthest)) {
    return wrong("the plane has a number that is not finite or too large");
  }
  return absl::OkStatus();
}

}  // namespace

std::string TrackState::bytes() const {
  Writer out;
  out.put(kMagic);
  out.put(kVersion);
  out.put(static_cast<std::uint8_t>((time ? kHasTime : 0) | (pose ? kHasPose : 0) | (plane ? kHasPlane : 0)));
  out.put(next_id);
  if (time) out.put(*time);
  if (pose) put(*pose, out);
  if (plane) out.put(plane->normal), out.put(plane->offset);
  out.put(static_cast<std::uint16_t>(tracks.size()));
  for (const Track& track : tracks) put(track, out);
  return out.finish();
}

absl::StatusOr<TrackState> TrackState::parse(std::string_view bytes) {
  TrackState state;
  if (bytes.empty()) return state;
  if (bytes.size() > kMostBytes) return wrong(fmt::format("{} bytes, of {} at most", bytes.size(), kMostBytes));
  if (!bytes.starts_with(kMagic) || bytes.size() < kMagic.size() + 2 + kChecksumBytes) {
    return wrong("these bytes are none");
  }
  Reader in(bytes.substr(kMagic.size(), bytes.size() - kMagic.size() - kChecksumBytes));
  const auto version = in.get<std::uint8_t>();
  if (version != kVersion) return wrong(fmt::format("version {} is not known, only {}", version, kVersion));
  const std::string_view body = bytes.substr(0, bytes.size() - kChecksumBytes);
  if (Reader(bytes.substr(body.size())).get<std::uint64_t>() != checksum(body)) return wrong("the checksum is wrong");
  const auto flags = in.get<std::uint8_t>();
  if (flags > kAllFlags) return wrong(fmt::format("flags {} are not known", flags));
  in.get(state.next_id);
  if ((flags & kHasTime) != 0) state.time = in.get<double>();
  if ((flags & kHasPose) != 0) state.pose = get_pose(in);
  if ((flags & kHasPlane) != 0) {
    Plane plane;
    in.get(plane.normal), in.get(plane.offset);
    state.plane = plane;
  }
  if (const absl::Status status = check_head(state); !status.ok()) return status;
  const auto count = in.get<std::uint16_t>();
  if (count > kMostTracks) return wrong(fmt::format("{} tracks, of {} at most", count, kMostTracks));
  for (std::uint64_t id = 0; state.tracks.size() < count && in.is_complete(); id = state.tracks.back().id) {
    absl::StatusOr<Track> track = get_track(in);
    if (!track.ok()) return track.status();
    if (!in.is_complete()) break;
    if (const absl::Status status = check_track(*track, state.next_id, id); !status.ok()) return status;
    state.tracks.push_back(*std::move(track));
  }
  if (!in.is_complete()) return wrong("it ends too early");
  if (in.left() > 0) return wrong(fmt::format("{} bytes follow its end", in.left()));
  return state;
}

}  // namespace segserve
