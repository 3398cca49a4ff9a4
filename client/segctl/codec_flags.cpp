#include "client/segctl/codec_flags.hpp"

#include <algorithm>

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
  codec_option_ = app.add_option("--codec", codecs_, fmt::format("how clouds are sent: {}; {}", codec_names(), note))
                      ->type_name("NAME")
                      ->delimiter(',')
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

absl::StatusOr<wire::CodecOptions> CodecFlags::named(const std::string& codec) const {
  const auto found = wire::codec_from_name(codec);
  if (!found.ok()) return absl::InvalidArgumentError(fmt::format("--codec: {}", std::string(found.status().message())));
  wire::CodecOptions options;
  options.codec = *found;
  options.error_bound = error_bound_mm_ / kMillimetres;
  if (!zstd_) return options;
  const auto with_zstd = compressed(options.codec);
  if (!with_zstd.ok()) return with_zstd.status();
  options.codec = *with_zstd;
  return options;
}

absl::StatusOr<std::vector<wire::CodecOptions>> CodecFlags::list() const {
  const std::vector<std::string> usual{std::string(wire::info(wire::CodecOptions{}.codec).name)};
  std::vector<wire::CodecOptions> list;
  for (const std::string& name : codec_option_->count() > 0 ? codecs_ : usual) {
    const auto options = named(name);
    if (!options.ok()) return options.status();
    list.push_back(*options);
  }
  const auto bounded = [](const wire::CodecOptions& options) { return has_error_bound(options.codec); };
  if (error_bound_option_->count() > 0 && std::ranges::none_of(list, bounded)) {
    return absl::InvalidArgumentError("--error-bound needs --codec quantised or draco");
  }
  return list;
}

absl::StatusOr<std::optional<wire::CodecOptions>> CodecFlags::options() const {
  if (codec_option_->count() == 0 && error_bound_option_->count() == 0 && !zstd_) return std::nullopt;
  const auto options = list();
  if (!options.ok()) return options.status();
  if (options->size() > 1) return absl::InvalidArgumentError("--codec: one name, not several");
  return options->front();
}

v1::Compression answer_compression(const std::optional<wire::CodecOptions>& codec) {
  if (!codec) return v1::COMPRESSION_NONE;
  switch (codec->codec) {
    case wire::Codec::kPlanar:
    case wire::Codec::kStrided:
    case wire::Codec::kPcd:
      return v1::COMPRESSION_NONE;
    default:
      return v1::COMPRESSION_ZSTD;
  }
}

}  // namespace segserve::segctl
