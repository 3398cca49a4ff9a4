// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/python_literal.hpp"

#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

constexpr int kDeepest = 8;

/// Parses from the front of a text. Functions return false after a fault.
class Parser {
 public:
  explicit Parser(std::string_view text) : rest_(text) {}

  bool value(PythonLiteral& out, int depth) {
    skip_spaces();
    if (rest_.empty() || depth > kDeepest) return false;
    const char first = rest_.front();
    if (first == '\'' || first == '"') return text(out);
    if (first == '(' || first == '[') return sequence(out, depth);
    if (first == '{') return dict(out, depth);
    return word(out);
  }
  bool at_end() {
    skip_spaces();
    return rest_.empty();
  }

 private:
  void skip_spaces() {
    const std::size_t begin = rest_.find_first_not_of(" \n\t\r");
    rest_.remove_prefix(begin == std::string_view::npos ? rest_.size() : begin);
  }
  bool take(char c) {
    skip_spaces();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  bool text(PythonLiteral& out) {
    const std::size_t end = rest_.find(rest_.front(), 1);
    if (end == std::string_view::npos) return false;
    out.kind = PythonLiteral::Kind::kText;
    out.text = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return out.text.find('\\') == std::string::npos;
  }

  bool word(PythonLiteral& out) {
    const std::size_t end = rest_.find_first_of(" \n\t\r,:()[]{}'\"");
    std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(text.size());
    if (text == "True" || text == "False") {
      out.kind = PythonLiteral::Kind::kTruth;
      out.count = text == "True" ? 1 : 0;
      return true;
    }
    if (text == "None") return true;
    if (text.ends_with('L')) text.remove_suffix(1);  // a long integer of Python 2
    const auto count = parse_count(text);
    if (!count) return false;
    out.kind = PythonLiteral::Kind::kCount;
    out.count = *count;
    return true;
  }

  bool sequence(PythonLiteral& out, int depth) {
    const char end = rest_.front() == '(' ? ')' : ']';
    rest_.remove_prefix(1);
    out.kind = PythonLiteral::Kind::kSequence;
    while (!take(end)) {
      if (!value(out.items.emplace_back(), depth + 1)) return false;
      if (!take(',')) return take(end);
    }
    return true;
  }

  bool dict(PythonLiteral& out, int depth) {
    rest_.remove_prefix(1);
    out.kind = PythonLiteral::Kind::kDict;
    while (!take('}')) {
      PythonLiteral key;
      if (!value(key, depth + 1) || key.kind != PythonLiteral::Kind::kText || !take(':')) return false;
      out.keys.push_back(std::move(key.text));
      if (!value(out.items.emplace_back(), depth + 1)) return false;
      if (!take(',')) return take('}');
    }
    return true;
  }

  std::string_view rest_;
};

}  // namespace

const PythonLiteral* PythonLiteral::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == key) return &items[i];
  }
  return nullptr;
}

std::optional<PythonLiteral> parse_python_literal(std::string_view text) {
  Parser parser(text);
  PythonLiteral out;
  if (!parser.value(out, 0) || !parser.at_end()) return std::nullopt;
  return out;
}

}  // namespace segserve::codec
