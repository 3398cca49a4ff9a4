// The kernels for every CPU of the architecture.
#define SEGSERVE_KERNELS plain_kernels
#include "segserve/supervoxel/kernels/table.hpp"
