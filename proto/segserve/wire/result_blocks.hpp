#pragma once
#include <string>
#include <vector>

#include "segserve/v1alpha1/result.pb.h"
namespace segserve::wire {
std::vector<std::string*> result_blocks(v1alpha1::SegmentationResult& message);
std::vector<std::uint64_t> result_block_sizes(const v1alpha1::SegmentationResult& message);
}
