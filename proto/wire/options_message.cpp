// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/options_message.hpp"

#include <array>
#include <bit>
#include <string_view>
#include <utility>

#include "fmt/format.h"

namespace segserve::wire {
namespace {

constexpr std::array kMethods = {
    std::pair{Method::kBorder, v1::METHOD_BORDER},
    std::pair{Method::kColor, v1::METHOD_COLOR},
    std::pair{Method::kGeometry, v1::METHOD_GEOMETRY},
    std::pair{Method::kLambda, v1::METHOD_LAMBDA},
    std::pair{Method::kLambdaConvex, v1::METHOD_LAMBDA_CONVEX},
    std::pair{Method::kEqualization, v1::METHOD_EQUALIZATION},
    std::pair{Method::kEqualizationConvex, v1::METHOD_EQUALIZATION_CONVEX},
    std::pair{Method::kFixedLambda, v1::METHOD_FIXED_LAMBDA},
};

constexpr std::array kPresets = {
    std::pair{Preset::kAuto, v1::PRESET_AUTO}, std::pair{Preset::kTabletop, v1::PRESET_TABLETOP},
    std::pair{Preset::kRoom, v1::PRESET_ROOM}, std::pair{Preset::kLidar, v1::PRESET_LIDAR},
    std::pair{Preset::kScan, v1::PRESET_SCAN},
};

/// The value of the API that stands beside `ours` in a table, or `unspecified`.
template <typename Table, typename Ours, typename InMessage>
InMessage to_message(const Table& table, Ours ours, InMessage unspecified) {
  for (const auto& [known, in_message] : table) {
    if (known == ours) return in_message;
  }
  return unspecified;
}

/// The value that stands beside one of the API in a table; nullopt if there is none.
template <typename Table, typename InMessage>
auto from_message(const Table& table, InMessage wanted) -> std::optional<typename Table::value_type::first_type> {
  for (const auto& [known, in_message] : table) {
    if (in_message == wanted) return known;
  }
  return std::nullopt;
}

/// The 64-bit hash FNV-1a. Numbers are added as their little-endian bytes.
class FnvHash {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) add_byte(static_cast<std::uint8_t>(byte));
    add_byte(0);
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value + 0.0)); }  // Adding 0 turns -0.0 into 0.0.
  void add(std::uint64_t value) {
    for (unsigned shift = 0; shift < 64; shift += 8) add_byte(static_cast<std::uint8_t>(value >> shift));
  }
  std::uint64_t value() const { return state_; }

 private:
  void add_byte(std::uint8_t byte) { state_ = (state_ ^ byte) * 0x100000001b3U; }

  std::uint64_t state_ = 0xcbf29ce484222325U;
};

/// The field of v1.SegmentOptions with the name of an option. It is a uint32 if the option is whole, else a double.
class NumberField {
 public:
  explicit NumberField(const OptionInfo& option)
      : field_(v1::SegmentOptions::descriptor()->FindFieldByName(std::string(option.name))), whole_(option.whole) {}

  std::optional<double> get(const v1::SegmentOptions& message) const {
    const google::protobuf::Reflection& reflection = *message.GetReflection();
    if (!reflection.HasField(message, field_)) return std::nullopt;
    return whole_ ? reflection.GetUInt32(message, field_) : reflection.GetDouble(message, field_);
  }
  void set(v1::SegmentOptions& message, double value) const {
    const google::protobuf::Reflection& reflection = *message.GetReflection();
    if (whole_) {
      reflection.SetUInt32(&message, field_, static_cast<std::uint32_t>(value));
    } else {
      reflection.SetDouble(&message, field_, value);
    }
  }

 private:
  const google::protobuf::FieldDescriptor* field_;
  bool whole_;
};

/// The fault with the path of its field in a request.
FieldViolation with_request_path(FieldViolation fault) {
  return {"options." + fault.field, std::move(fault.description)};
}

}  // namespace

v1::Method to_message(Method method) { return to_message(kMethods, method, v1::METHOD_UNSPECIFIED); }
std::optional<Method> from_message(v1::Method method) { return from_message(kMethods, method); }

v1::Preset to_message(Preset preset) { return to_message(kPresets, preset, v1::PRESET_UNSPECIFIED); }
std::optional<Preset> from_message(v1::Preset preset) { return from_message(kPresets, preset); }

v1::SegmentOptions to_message(const Options& options) {
  v1::SegmentOptions message;
  message.set_method(to_message(options.method));
  if (options.preset != Preset::kAuto) message.set_preset(to_message(options.preset));
  for (const OptionInfo& option : option_table()) {
    if (const std::optional<double> value = option.get(options)) NumberField(option).set(message, *value);
  }
  return message;
}

Options from_message(const v1::SegmentOptions& message, const Options& defaults, std::vector<FieldViolation>& faults) {
  Options options = defaults;
  if (message.method() != v1::METHOD_UNSPECIFIED) {
    if (const std::optional<Method> method = from_message(message.method())) {
      options.method = *method;
    } else {
      faults.push_back({"options.method", fmt::format("{} is not a method", static_cast<int>(message.method()))});
    }
  }
  if (message.preset() != v1::PRESET_UNSPECIFIED) {
    if (const std::optional<Preset> preset = from_message(message.preset())) {
      options.preset = *preset;
    } else {
      faults.push_back({"options.preset", fmt::format("{} is not a preset", static_cast<int>(message.preset()))});
    }
  }
  if (message.cut_case() != v1::SegmentOptions::CUT_NOT_SET) {
    options.threshold.reset();
    options.regions.reset();
  }
  for (const OptionInfo& option : option_table()) {
    if (const std::optional<double> value = NumberField(option).get(message)) option.set(options, *value);
  }
  for (FieldViolation& fault : segserve::violations(options)) faults.push_back(with_request_path(std::move(fault)));
  return options;
}

std::vector<FieldViolation> violations_in_view(const Options& options, const View& view) {
  std::vector<FieldViolation> faults = segserve::violations(options, view);
  for (FieldViolation& fault : faults) fault = with_request_path(std::move(fault));
  return faults;
}

std::string options_hash(const Options& options) {
  const Options effective = resolved(options);
  FnvHash hash;
  hash.add(name(effective.method));
  if (effective.preset != Preset::kAuto) hash.add(name(effective.preset));
  for (const OptionInfo& option : option_table()) {
    if (option.name == "threads" || (option.name == "lambda" && effective.method != Method::kFixedLambda)) continue;
    if (const std::optional<double> value = option.get(effective)) {
      hash.add(option.name);
      hash.add(*value);
    }
  }
  return fmt::format("{:016x}", hash.value());
}

}  // namespace segserve::wire
