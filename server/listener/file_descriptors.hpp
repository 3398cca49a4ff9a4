// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve::server {

/// File descriptors of this process: one for each connection, and some twenty others.
struct FileDescriptors {
  std::uint64_t open = 0;
  std::uint64_t limit = 0;
};

FileDescriptors file_descriptors();

/// Raises the limit as far as the system allows it without rights.
void raise_file_descriptor_limit();

}  // namespace segserve::server
