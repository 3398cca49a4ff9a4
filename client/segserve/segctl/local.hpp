#pragma once

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"
#include "segserve/codec/labelled_cloud.hpp"
#include "segserve/pipeline/stop_token.hpp"

namespace segserve::segctl {

/// What the server would answer, computed in this process by the same core. Errors as `segment`.
absl::StatusOr<client::Result> segment_locally(const codec::LabelledCloud& scene, const Options& options,
                                               const StopToken& stop);

}  // namespace segserve::segctl
