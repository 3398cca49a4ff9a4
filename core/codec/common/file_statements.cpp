// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/file_statements.hpp"

#include "core/codec/common/text_parsing.hpp"
#include "core/codec/view/view_choice.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kUnitStatement = "segserve unit ";

/// The unit that a comment states, or nullopt for another comment.
std::optional<LengthUnit> stated_unit(std::string_view comment) {
  if (!comment.starts_with(kUnitStatement)) return std::nullopt;
  const auto words = split_words(comment.substr(kUnitStatement.size()));
  const auto unit = words.size() == 1 ? length_unit_from_name(words[0]) : std::nullopt;
  return unit == LengthUnit::kAuto ? std::nullopt : unit;
}

}  // namespace

bool FileStatements::take(std::string_view comment) {
  if (const auto stated = stated_view(comment)) {
    view = stated;
    return true;
  }
  const auto stated = stated_unit(comment);
  if (stated) unit = stated;
  return stated.has_value();
}

std::string unit_statement(LengthUnit unit) { return std::string(kUnitStatement).append(name(unit)); }

std::vector<std::string> statements_of(const FileContent& content) {
  std::vector<std::string> statements{view_statement(content.cloud.view)};
  if (content.unit != LengthUnit::kMeter) statements.push_back(unit_statement(content.unit));
  return statements;
}

}  // namespace segserve::codec
