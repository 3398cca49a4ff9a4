// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/codec_flags.hpp"

#include <algorithm>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/codec/quantised.hpp"

namespace segserve::segctl {
namespace {

constexpr double kMillimetersPerMeter = 1000;

std::string codec_names() {
  std::string names;
  for (const wire::CodecInfo& codec : wire::codecs()) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", codec.name);
  }
  return names;
}

bool has_error_bound(wire::Codec codec) { return codec == wire::Codec::kQuantised || codec == wire::Codec::kDraco; }

/// The codec that compresses what `codec` sends.
absl::StatusOr<wire::Codec> compressed(wire::Codec codec) {
  if (codec == wire::Codec::kPlanar || codec == wire::Codec::kPlanarZstd) return wire::Codec::kPlanarZstd;
  if (codec == wire::Codec::kStrided || codec == wire::Codec::kStridedZstd) return wire::Codec::kStridedZstd;
  return absl::InvalidArgumentError("--zstd needs --codec planar or strided");
}

}  // namespace

void CodecFlags::add_to(CLI::App& app, const std::string& note, const std::string& group) {
  error_bound_mm_ = wire::CodecOptions{}.error_bound * kMillimetersPerMeter;
  codec_option_ = app.add_option("--codec", codecs_, fmt::format("how clouds are sent: {}; {}", codec_names(), note))
                      ->type_name("NAME")
                      ->delimiter(',')
                      ->group(group);
  error_bound_option_ =
      app.add_option(
             "--error-bound", error_bound_mm_,
             fmt::format("how far quantised ({} to {}) and draco may move a coordinate, in millimeters",
                         codec::kMinErrorBound * kMillimetersPerMeter, codec::kMaxErrorBound * kMillimetersPerMeter))
          ->type_name("MM")
          ->capture_default_str()
          ->group(group);
  app.add_flag("--zstd", zstd_, "compress the answer, and clouds that planar or strided sends, without loss")
      ->group(group);
}

absl::StatusOr<wire::CodecOptions> CodecFlags::named(const std::string& codec) const {
  const auto found = wire::codec_from_name(codec);
  if (!found.ok()) return absl::InvalidArgumentError(fmt::format("--codec: {}", message_of(found.status())));
  wire::CodecOptions options;
  options.codec = *found;
  options.error_bound = error_bound_mm_ / kMillimetersPerMeter;
  if (!zstd_) return options;
  ASSIGN_OR_RETURN(options.codec, compressed(options.codec));
  return options;
}

absl::StatusOr<std::vector<wire::CodecOptions>> CodecFlags::list() const {
  const std::vector<std::string> defaults{std::string(wire::info(wire::CodecOptions{}.codec).name)};
  std::vector<wire::CodecOptions> list;
  for (const std::string& name : codec_option_->count() > 0 ? codecs_ : defaults) {
    ASSIGN_OR_RETURN(const wire::CodecOptions options, named(name));
    list.push_back(options);
  }
  const auto bounded = [](const wire::CodecOptions& options) { return has_error_bound(options.codec); };
  if (error_bound_option_->count() > 0 && std::ranges::none_of(list, bounded)) {
    return absl::InvalidArgumentError("--error-bound needs --codec quantised or draco");
  }
  return list;
}

absl::StatusOr<std::optional<wire::CodecOptions>> CodecFlags::options() const {
  if (codec_option_->count() == 0 && error_bound_option_->count() == 0 && !zstd_) return std::nullopt;
  ASSIGN_OR_RETURN(const auto codecs, list());
  if (codecs.size() > 1) return absl::InvalidArgumentError("--codec: one name, not several");
  return codecs.front();
}

wire::Compression answer_compression(const std::optional<wire::CodecOptions>& codec) {
  if (!codec) return wire::Compression::kNone;
  switch (codec->codec) {
    case wire::Codec::kPlanar:
    case wire::Codec::kStrided:
    case wire::Codec::kPcd:
      return wire::Compression::kNone;
    default:
      return wire::Compression::kZstd;
  }
}

}  // namespace segserve::segctl
