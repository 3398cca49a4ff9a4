#pragma once

#include <memory>

#include "segserve/cloud/cloud.hpp"
#include "segserve/options/options.hpp"

namespace segserve::bench {

/// PCL's SupervoxelClustering (VCCS) with the same parameters on the same cloud.
class PclVccs {
 public:
  PclVccs(const CloudView& cloud, const Options& options);
  ~PclVccs();
  /// From points to supervoxels; returns their number.
  std::size_t run() const;

 private:
  struct Input;
  std::unique_ptr<Input> input_;
};

}  // namespace segserve::bench
