// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace segserve::server {

/// File descriptors of this process: one for each connection, and some twenty others.
struct FileDescriptors {
  std::uint64_t open = 0;
  std::uint64_t limit = 0;
};

FileDescriptors file_descriptors();

/// The number of connections that an entrance beside gRPC may have: `most`, or as many as a quarter of the limit holds
/// if each takes so many descriptors.
std::size_t connections_beside_grpc(std::size_t most, std::size_t descriptors_of_connection = 1);

/// The number of connections that gRPC may have: `most`, or as many as half of the limit holds.
std::size_t connections_of_grpc(std::size_t most, std::size_t descriptors_of_connection);

/// Raises the limit as far as the system allows it without rights.
void raise_file_descriptor_limit();

}  // namespace segserve::server
