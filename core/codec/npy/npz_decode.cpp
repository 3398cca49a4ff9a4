// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/zip_archive.hpp"
#include "core/codec/npy/npy.hpp"
#include "core/codec/npy/npy_array.hpp"
#include "core/codec/npy/npy_points.hpp"
#include "core/codec/npy/npy_table.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

bool is_position_name(std::string_view name) {
  const std::string lower = lower_case(name);
  return std::ranges::find(kPositionArrays, lower) != kPositionArrays.end() ||
         std::ranges::find(kAxes, lower) != kAxes.end();
}

/// A member that cannot be opened.
struct Unopened {
  std::string name;
  absl::Status status;
  bool is_damaged = false;  ///< its bytes are, so that it is unknown what it was
};

/// The arrays of an archive, and the bytes that they lie in.
struct Archive {
  std::deque<std::vector<std::byte>> bytes;
  std::vector<NpyArray> arrays;
  std::vector<Unopened> unopened;

  /// The array of this name, or else of this name in any case.
  const NpyArray* find(std::string_view name) const {
    auto found = std::ranges::find(arrays, name, &NpyArray::name);
    if (found == arrays.end()) {
      found = std::ranges::find(arrays, name, [](const NpyArray& array) { return lower_case(array.name()); });
    }
    return found == arrays.end() ? nullptr : &*found;
  }
  /// Whether arrays with positions are there by their names.
  bool has_position() const {
    const auto is_there = [this](std::string_view name) { return find(name) != nullptr; };
    return std::ranges::any_of(kPositionArrays, is_there) || std::ranges::all_of(kAxes, is_there);
  }
  std::string names() const {
    std::vector<std::string> all;
    all.reserve(arrays.size());
    for (const NpyArray& array : arrays) all.push_back(quoted(array.name()));
    return fmt::format("{}", fmt::join(all, ", "));
  }
};

/// Names the format of a zip archive of another program by its members. The text is empty if it is not known.
std::string_view maker_of(const std::vector<ZipMember>& members) {
  struct Kind {
    std::string_view end, name;
  };
  constexpr std::array<Kind, 6> kKinds{{{"/data.pkl", "a file of PyTorch, a zip archive"},
                                        {"xl/workbook.xml", "a file of Excel, a zip archive"},
                                        {".usdc", "USDZ, a zip archive"},
                                        {".usda", "USDZ, a zip archive"},
                                        {".kml", "KMZ, a zip archive"},
                                        {"/.zarray", "Zarr, a zip archive"}}};
  for (const Kind& kind : kKinds) {
    const auto is_of_kind = [&kind](const ZipMember& member) { return member.name.ends_with(kind.end); };
    if (std::ranges::any_of(members, is_of_kind)) return kind.name;
  }
  return {};
}

absl::Status no_arrays(const std::vector<ZipMember>& members) {
  constexpr std::size_t kMostNamed = 3;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(members.size(), kMostNamed); ++i) names.push_back(quoted(members[i].name));
  if (members.size() > kMostNamed) names.emplace_back("..");
  const std::string_view made_by = maker_of(members);
  return absl::InvalidArgumentError(fmt::format(
      "this is {} without an array of NumPy (.npy) in it; {}; it has {}", made_by.empty() ? "a zip archive" : made_by,
      made_by.empty() ? "unpack it first" : "save the points as PLY, CSV or NPY in the program that made it",
      names.empty() ? "no files" : fmt::format("{}", fmt::join(names, ", "))));
}

absl::StatusOr<Archive> open_archive(std::span<const std::byte> file, const DecodeLimits& limits, StopCheck& check,
                                     std::vector<Warning>& warnings) {
  constexpr std::string_view kExtension = ".npy";
  ASSIGN_OR_RETURN(const auto members, list_zip(file, limits));
  Archive archive;
  for (const ZipMember& member : members) {
    std::string_view name = member.name;
    if (!name.ends_with(kExtension)) {
      warnings.push_back({WarningReason::kAttributeNotKept,
                          fmt::format("{} in the archive is no array of NumPy, and not used", quoted(name))});
      continue;
    }
    name.remove_suffix(kExtension.size());
    auto bytes = read_zip_member(file, member, check);
    if (absl::IsInvalidArgument(bytes.status())) {
      archive.unopened.push_back({std::string(name), bytes.status(), true});
      continue;
    }
    RETURN_IF_ERROR(bytes.status());
    archive.bytes.push_back(*std::move(bytes));
    auto array = NpyArray::open(archive.bytes.back(), std::string(name), check);
    if (absl::IsInvalidArgument(array.status())) {
      archive.unopened.push_back({std::string(name), array.status()});
      continue;
    }
    RETURN_IF_ERROR(array.status());
    RETURN_IF_ERROR(array->put_channels_last(check));
    archive.arrays.push_back(*std::move(array));
  }
  if (archive.arrays.empty() && archive.unopened.empty()) return no_arrays(members);
  return archive;
}

/// Warns of the members that cannot be opened. An error if one of them may have the positions.
absl::Status pass_over_unopened(const Archive& archive, std::vector<Warning>& warnings) {
  for (const Unopened& member : archive.unopened) {
    const bool may_be_position =
        is_position_name(member.name) || archive.arrays.empty() || (archive.arrays.size() == 1 && member.is_damaged);
    if (may_be_position && !archive.has_position()) return member.status;
    warnings.push_back({WarningReason::kAttributeNotKept, fmt::format("{} in the archive is not kept: {}",
                                                                      quoted(member.name), message_of(member.status))});
  }
  return absl::OkStatus();
}

/// The only array that can have the positions by its shape and type; null if there is none, or another one.
const NpyArray* only_candidate(const Archive& archive) {
  constexpr std::uint64_t kFewestPoints = 16, kMostColumns = 64;
  const NpyArray* found = nullptr;
  for (const NpyArray& array : archive.arrays) {
    const NpyHeader& header = array.header();
    const NpyField& field = header.fields[0];
    const bool are_floats = field.kind == NpyKind::kHalf || (field.kind == NpyKind::kNumber && is_float(field.type));
    const bool has_shape = header.shape.size() >= 2 && header.shape.size() <= 3 && header.shape.back() >= 3 &&
                           header.shape.back() <= kMostColumns &&
                           header.elements() / header.shape.back() >= kFewestPoints;
    if (header.is_structured || !are_floats || !has_shape) continue;
    if (found != nullptr) return nullptr;
    found = &array;
  }
  return found;
}

/// Adds the positions of the points, and returns the names of the arrays that have them.
absl::StatusOr<std::set<std::string>> add_position(const Archive& archive, NpyTable& points,
                                                   std::vector<Warning>& warnings) {
  for (const std::string_view name : kPositionArrays) {
    const NpyArray* const array = archive.find(name);
    if (array == nullptr || array->header().is_structured) continue;
    RETURN_IF_ERROR(points.set_shape(*array, 1));
    RETURN_IF_ERROR(points.add_unnamed(*array));
    return std::set<std::string>{array->name()};
  }
  const std::array<const NpyArray*, 3> axes{archive.find("x"), archive.find("y"), archive.find("z")};
  if (std::ranges::count(axes, nullptr) == 3) {
    if (const NpyArray* const only = only_candidate(archive)) {
      warnings.push_back(
          {WarningReason::kOther, fmt::format("the array {} is taken as the points, because it is the only "
                                              "one with three floats or more for each",
                                              quoted(only->name()))});
      RETURN_IF_ERROR(points.set_shape(*only, 1));
      RETURN_IF_ERROR(points.add_unnamed(*only));
      return std::set<std::string>{only->name()};
    }
  }
  if (std::ranges::count(axes, nullptr) > 0) {
    return absl::InvalidArgumentError(
        fmt::format("NPZ archive: there must be an array 'points' or 'xyz', or arrays 'x', 'y' and 'z'; it has {}",
                    archive.names()));
  }
  RETURN_IF_ERROR(points.set_shape(*axes[0], 0));
  for (const NpyArray* const axis : axes) {
    if (!points.fits(*axis) || axis->header().elements() != points.points()) {
      return absl::InvalidArgumentError(
          fmt::format("NPZ archive: {} has another shape than 'x'", quoted(axis->name())));
    }
    points.add_named(*axis, axis->name());
  }
  return std::set<std::string>{axes[0]->name(), axes[1]->name(), axes[2]->name()};
}

void add_others(const Archive& archive, const std::set<std::string>& used, NpyTable& points,
                std::vector<Warning>& warnings) {
  constexpr std::uint64_t kMostNumbers = 4096;
  for (const NpyArray& array : archive.arrays) {
    if (used.contains(array.name())) continue;
    const bool is_wide = points.points() > 0 && array.header().elements() / points.points() > kMostNumbers;
    if (points.fits(array) && !is_wide) {
      points.add_named(array, array.name());
    } else {
      warnings.push_back({WarningReason::kAttributeNotKept,
                          fmt::format("the array {} of shape {} is not kept, because it has no value for each point",
                                      quoted(array.name()), shape_text(array.header()))});
    }
  }
}

}  // namespace

bool is_npz(std::string_view file) { return file.starts_with("PK\3\4"sv) || file.starts_with("PK\5\6"sv); }

absl::StatusOr<LabeledCloud> decode_npz(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("NPZ archive: ", bytes.size(), limits));
  StopCheck check(stop);
  std::vector<Warning> warnings;
  ASSIGN_OR_RETURN(const Archive archive, open_archive(bytes, limits, check, warnings));
  RETURN_IF_ERROR(pass_over_unopened(archive, warnings));
  if (archive.arrays.size() == 1) return read_array(archive.arrays[0], warnings, limits, options, stop);
  NpyTable points(limits, check, warnings);
  ASSIGN_OR_RETURN(const auto used, add_position(archive, points, warnings));
  add_others(archive, used, points, warnings);
  RETURN_IF_ERROR(check.status());
  return read_table(points, warnings, options, stop);
}

}  // namespace segserve::codec
