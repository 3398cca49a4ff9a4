// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/lab/eval/evaluation.hpp"
#include "segserve/cloud.hpp"

/// Segments a cloud as pcl_peer::partition with its default settings. It has C's name, so that dlsym finds it.
extern "C" void segctl_lccp_partition(const segserve::CloudView& cloud,
                                      absl::StatusOr<segserve::eval::Partition>& result);
