// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// The CPU time and the memory that this process takes.
namespace segserve::bench {

/// CPU time so far, seconds.
double cpu_seconds();
/// Memory that is resident now, bytes; 0 if the system does not tell.
std::uint64_t resident_bytes();
/// The number of CPUs that this process may use.
unsigned usable_cpus();

}  // namespace segserve::bench
