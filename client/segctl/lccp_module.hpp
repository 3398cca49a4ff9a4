// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/lab/eval/evaluation.hpp"
#include "core/pcl_adapter/peer/lccp_partition.hpp"
#include "segserve/cloud.hpp"

/// Calls pcl_peer::partition. It has C's name, so that dlsym finds it.
extern "C" void segctl_lccp_partition(const segserve::CloudView& cloud,
                                      const segserve::pcl_peer::PeerSettings& settings,
                                      absl::StatusOr<segserve::eval::Partition>& result);
