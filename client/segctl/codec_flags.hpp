// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/wire/codec.hpp"
#include "segserve/wire/outputs.hpp"

namespace segserve::segctl {

/// The flags --codec, --error-bound and --zstd. It must outlive the parsing of the command line.
class CodecFlags {
 public:
  /// `note` is a remark for the help of --codec.
  void add_to(CLI::App& app, const std::string& note, const std::string& group);

  /// The codec that the flags name; unset if no flag was given. INVALID_ARGUMENT for an unknown codec, and for flags
  /// that do not go together.
  absl::StatusOr<std::optional<wire::CodecOptions>> options() const;

  /// Like options(), but --codec may name several. The list is never empty.
  absl::StatusOr<std::vector<wire::CodecOptions>> list() const;

 private:
  absl::StatusOr<wire::CodecOptions> named(const std::string& codec) const;

  std::vector<std::string> codecs_;
  double error_bound_mm_ = 0;
  bool zstd_ = false;
  CLI::Option* codec_option_ = nullptr;
  CLI::Option* error_bound_option_ = nullptr;
};

/// The compression of the answer: a client that compresses the cloud wants a compressed answer, too.
wire::Compression answer_compression(const std::optional<wire::CodecOptions>& codec);

}  // namespace segserve::segctl
