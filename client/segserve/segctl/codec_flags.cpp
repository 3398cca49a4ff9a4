#include "segserve/segctl/codec_flags.hpp"

#include "fmt/format.h"
#include "segserve/codec/quantised.hpp"

namespace segserve::segctl {
namespace {

constexpr double kMillimetres = 1000;  // in a metre

std::string codec_names() {
  std::string names;
  for (const wire::CodecInfo& codec : wire::codecs())
    names += fmt::format("{}{}", names.empty() ? "" : ", ", codec.name);
  return names;
}

bool has_error_bound(wire::Codec codec) { return codec == wire::Codec::kQuantised || codec == wire::Codec::kDraco; }

absl::StatusOr<wire::Codec> compressed(wire::Codec codec) {
  if (codec == wire::Codec::kPlanar || codec == wire::Codec::kPlanarZstd) return wire::Codec::kPlanarZstd;
  if (codec == wire::Codec::kStrided || codec == wire::Codec::kStridedZstd) return wire::Codec::kStridedZstd;
  return absl::InvalidArgumentError("--zstd needs --codec planar or strided");
}

}  // namespace

void CodecFlags::add_to(CLI::App& app, const std::string& note, const std::string& group) {
  error_bound_mm_ = wire::CodecOptions{}.error_bound * kMillimetres;
  codec_option_ = app.add_option("--codec", codec_, fmt::format("how clouds are sent: {}; {}", codec_names(), note))
                      ->type_name("NAME")
                      ->group(group);
  error_bound_option_ =
      app.add_option("--error-bound", error_bound_mm_,
                     fmt::format("how far the codecs quantised ({} to {}) and draco may move a coordinate, millimetres",
                                 codec::kMinErrorBound * kMillimetres, codec::kMaxErrorBound * kMillimetres))
          ->type_name("MM")
          ->capture_default_str()
          ->group(group);
  app.add_flag("--zstd", zstd_, "compress the answer, and planar and strided clouds, without loss")->group(group);
}

absl::StatusOr<std::optional<wire::CodecOptions>> CodecFlags::options() const {
  const bool has_codec = codec_option_->count() > 0;
  const bool has_bound = error_bound_option_->count() > 0;
  if (!has_codec && !has_bound && !zstd_) return std::nullopt;
  wire::CodecOptions options;
  if (has_codec) {
    const auto codec = wire::codec_from_name(codec_);
    if (!codec.ok())
      return absl::InvalidArgumentError(fmt::format("--codec: {}", std::string(codec.status().message())));
    options.codec = *codec;
  }
  if (zstd_) {
    const auto codec = compressed(options.codec);
    if (!codec.ok()) return codec.status();
    options.codec = *codec;
  }
  if (has_bound && !has_error_bound(options.codec)) {
    return absl::InvalidArgumentError("--error-bound needs --codec quantised or draco");
  }
  options.error_bound = error_bound_mm_ / kMillimetres;
  return options;
}

v1alpha1::Compression answer_compression(const std::optional<wire::CodecOptions>& codec) {
  if (!codec) return v1alpha1::COMPRESSION_NONE;
  switch (codec->codec) {
    case wire::Codec::kPlanar:
    case wire::Codec::kStrided:
    case wire::Codec::kPcd:
      return v1alpha1::COMPRESSION_NONE;
    default:
      return v1alpha1::COMPRESSION_ZSTD;
  }
}

}  // namespace segserve::segctl
