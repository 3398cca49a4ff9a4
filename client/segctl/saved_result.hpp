// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/client/cloud_fingerprint.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::segctl {

/// A file that segctl segment --result wrote.
struct SavedResult {
  client::Result result;
  std::optional<client::CloudFingerprint> cloud;  ///< Unset in files of version 2.
};

/// Whether these are the bytes of a saved result, and not of a cloud.
bool is_saved_result(std::string_view bytes);

/// Decodes such a file. `name` is that of the input in messages.
absl::StatusOr<SavedResult> decode_saved_result(std::string_view bytes, const std::string& name);

/// Reads the file `path`, or standard input if the path is "-".
absl::StatusOr<SavedResult> load_saved_result(const std::string& path);

/// Reads the cloud that was segmented, as it was read then, with everything that is in its file. INVALID_ARGUMENT if it
/// is plain that the result is of another cloud; adds a warning if this is not known. `result_name` is the name of the
/// result in messages.
absl::StatusOr<codec::LabeledCloud> load_segmented_cloud(const std::string& path, const SavedResult& saved,
                                                         const std::string& result_name,
                                                         std::vector<codec::Warning>& warnings);

}  // namespace segserve::segctl
