#include "segserve/wire/options.hpp"

#include <array>
#include <bit>
#include <string_view>
#include <utility>

#include "fmt/format.h"

namespace segserve::wire {
namespace {

constexpr std::array kMethods = {
    std::pair{Method::kColor, v1alpha1::METHOD_COLOR},
    std::pair{Method::kGeometry, v1alpha1::METHOD_GEOMETRY},
    std::pair{Method::kLambda, v1alpha1::METHOD_LAMBDA},
    std::pair{Method::kLambdaConvex, v1alpha1::METHOD_LAMBDA_CONVEX},
    std::pair{Method::kEqualization, v1alpha1::METHOD_EQUALIZATION},
    std::pair{Method::kEqualizationConvex, v1alpha1::METHOD_EQUALIZATION_CONVEX},
    std::pair{Method::kFixedLambda, v1alpha1::METHOD_FIXED_LAMBDA},
};

/// FNV-1a with 64 bits, fed with numbers as little-endian bytes.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) add_byte(static_cast<std::uint8_t>(byte));
    add_byte(0);
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value + 0.0)); }  // + 0.0: the zeros are equal
  void add(std::uint64_t value) {
    for (int shift = 0; shift < 64; shift += 8)
      add_byte(static_cast<std::uint8_t>(value >> static_cast<unsigned>(shift)));
  }
  std::uint64_t value() const { return state_; }

 private:
  void add_byte(std::uint8_t byte) { state_ = (state_ ^ byte) * 0x100000001b3U; }

  std::uint64_t state_ = 0xcbf29ce484222325U;
};

}  // namespace

v1alpha1::Method to_message(Method method) {
  for (const auto& [ours, theirs] : kMethods) {
    if (ours == method) return theirs;
  }
  return v1alpha1::METHOD_UNSPECIFIED;
}

std::optional<Method> from_message(v1alpha1::Method method) {
  for (const auto& [ours, theirs] : kMethods) {
    if (theirs == method) return ours;
  }
  return std::nullopt;
}

v1alpha1::SegmentOptions to_message(const Options& options) {
  v1alpha1::SegmentOptions message;
  message.set_method(to_message(options.method));
  message.set_voxel_resolution(options.voxel_resolution);
  message.set_seed_resolution(options.seed_resolution);
  message.set_color_weight(options.weights.color);
  message.set_spatial_weight(options.weights.spatial);
  message.set_normal_weight(options.weights.normal);
  message.set_lambda(options.lambda);
  if (options.threshold) message.set_threshold(*options.threshold);
  if (options.regions) message.set_regions(*options.regions);
  message.set_threads(options.threads);
  return message;
}

Options from_message(const v1alpha1::SegmentOptions& message, const Options& defaults,
                     std::vector<FieldViolation>& faults) {
  Options options = defaults;
  if (message.method() != v1alpha1::METHOD_UNSPECIFIED) {
    if (const std::optional<Method> method = from_message(message.method())) {
      options.method = *method;
    } else {
      faults.push_back({"options.method", fmt::format("{} is no method", static_cast<int>(message.method()))});
    }
  }
  if (message.has_voxel_resolution()) options.voxel_resolution = message.voxel_resolution();
  if (message.has_seed_resolution()) options.seed_resolution = message.seed_resolution();
  if (message.has_color_weight()) options.weights.color = message.color_weight();
  if (message.has_spatial_weight()) options.weights.spatial = message.spatial_weight();
  if (message.has_normal_weight()) options.weights.normal = message.normal_weight();
  if (message.has_lambda()) options.lambda = message.lambda();
  if (message.cut_case() != v1alpha1::SegmentOptions::CUT_NOT_SET) {
    options.threshold = message.has_threshold() ? std::optional(message.threshold()) : std::nullopt;
    options.regions = message.has_regions() ? std::optional(message.regions()) : std::nullopt;
  }
  if (message.has_threads()) options.threads = message.threads();

  for (FieldViolation& fault : violations(options)) {
    faults.push_back({"options." + fault.field, std::move(fault.description)});
  }
  return options;
}

std::string options_hash(const Options& options) {
  Hash hash;
  hash.add(name(options.method));
  hash.add(options.voxel_resolution);
  hash.add(options.seed_resolution);
  hash.add(options.weights.color);
  hash.add(options.weights.spatial);
  hash.add(options.weights.normal);
  hash.add(options.method == Method::kFixedLambda ? options.lambda : 0.0);
  if (options.regions) {
    hash.add("regions");
    hash.add(std::uint64_t{*options.regions});
  } else {
    hash.add("threshold");
    hash.add(options.threshold.value_or(default_threshold(options.method)));
  }
  return fmt::format("{:016x}", hash.value());
}

}  // namespace segserve::wire
