// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace segserve::codec {

/// An NPY file of version 1.0.
inline std::string npy_file(const std::string& type, const std::string& shape, const std::string& body,
                            bool fortran = false) {
  std::string header =
      "{'descr': " + type + ", 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }\n";
  const auto length = static_cast<std::uint16_t>(header.size());
  std::string file("\x93NUMPY\1\0", 8);
  file.append(reinterpret_cast<const char*>(&length), sizeof length);
  return file + header + body;
}

/// The bytes of values.
template <typename T>
std::string raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace segserve::codec
