// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "nlohmann/json.hpp"

namespace segserve::view_page {

/// The arrays of a page. Each is a text, the base64 of a gzip. In it are the differences of each value to the one
/// before, modulo 2^bits: first the lowest bytes of all, then the second ones, and so on. client/page/src/page_data.js
/// reads it.
class PageArrays {
 public:
  /// Adds an array and returns its description for the page: its type, number of values, and the id of its text.
  /// Floats are stored by their bits.
  nlohmann::ordered_json add(std::span<const std::uint8_t> values);
  nlohmann::ordered_json add(std::span<const std::uint16_t> values);
  nlohmann::ordered_json add(std::span<const std::uint32_t> values);
  nlohmann::ordered_json add(std::span<const float> values);
  /// Adds an array of type "f64", whose gzip has the values as they are.
  nlohmann::ordered_json add(std::span<const double> values);

  /// Pairs of id and text.
  std::vector<std::pair<std::string, std::string>> texts() && { return std::move(texts_); }

 private:
  template <std::unsigned_integral T>
  nlohmann::ordered_json add_planes(const char* type, std::span<const T> values);
  nlohmann::ordered_json add_bytes(const char* type, std::size_t count, const std::string& bytes);

  std::vector<std::pair<std::string, std::string>> texts_;
};

}  // namespace segserve::view_page
