#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "proto/wire/codec_message.hpp"

namespace segserve::segctl {

/// The flags --codec, --error-bound and --zstd. Must outlive the parsing of the command line.
class CodecFlags {
 public:
  /// `note` is a remark for the help of --codec.
  void add_to(CLI::App& app, const std::string& note, const std::string& group);

  /// What the flags ask for; unset if none of them is given. INVALID_ARGUMENT for an unknown codec, or flags that do
  /// not fit each other.
  absl::StatusOr<std::optional<wire::CodecOptions>> options() const;

  /// As options(), but --codec may name several; not empty.
  absl::StatusOr<std::vector<wire::CodecOptions>> list() const;

 private:
  absl::StatusOr<wire::CodecOptions> named(const std::string& codec) const;

  std::vector<std::string> codecs_;
  double error_bound_mm_ = 0;
  bool zstd_ = false;
  CLI::Option* codec_option_ = nullptr;
  CLI::Option* error_bound_option_ = nullptr;
};

/// Of the answer: who saves bytes on the way there does so on the way back.
v1::Compression answer_compression(const std::optional<wire::CodecOptions>& codec);

}  // namespace segserve::segctl
