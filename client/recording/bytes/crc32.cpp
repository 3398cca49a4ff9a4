// SPDX-License-Identifier: Apache-2.0
#include "client/recording/bytes/crc32.hpp"

#include <libdeflate.h>

namespace segserve::recording {

std::uint32_t crc32(std::uint32_t so_far, std::string_view bytes) {
  return libdeflate_crc32(so_far, bytes.data(), bytes.size());
}

}  // namespace segserve::recording
