// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace segserve::codec {

/// A value that Python writes in the headers of its array files.
struct PythonLiteral {
  enum class Kind : std::uint8_t { kText, kCount, kTruth, kNone, kSequence, kDict };
  Kind kind = Kind::kNone;
  std::string text;
  std::uint64_t count = 0;           ///< a number of kCount, or 1 for True
  std::vector<PythonLiteral> items;  ///< of a list or tuple; or the values of a dict
  std::vector<std::string> keys;     ///< of a dict

  /// The value of a key; null if it is not there.
  const PythonLiteral* find(std::string_view key) const;
};

/// Parses a literal that is the whole text, but for spaces: strings without escapes, whole numbers from 0 on, True,
/// False, None, tuples, lists, and dicts with keys of text. nullopt for anything else, and for deep nesting.
std::optional<PythonLiteral> parse_python_literal(std::string_view text);

}  // namespace segserve::codec
