// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/prometheus_text.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "fmt/format.h"

namespace segserve::bench {
namespace {

constexpr std::string_view kSpace = " \t\r";

void skip_space(std::string_view& text) { text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size())); }

std::string_view take_until(std::string_view& text, std::string_view ends) {
  const std::size_t length = std::min(text.find_first_of(ends), text.size());
  const std::string_view word = text.substr(0, length);
  text.remove_prefix(length);
  return word;
}

bool take(std::string_view& text, char wanted) {
  skip_space(text);
  if (text.empty() || text.front() != wanted) return false;
  text.remove_prefix(1);
  return true;
}

/// The content of a string after its first quote, and that quote at its end.
std::optional<std::string> take_quoted(std::string_view& text) {
  std::string content;
  while (!text.empty()) {
    char c = text.front();
    text.remove_prefix(1);
    if (c == '"') return content;
    if (c == '\\') {
      if (text.empty()) return std::nullopt;
      c = text.front() == 'n' ? '\n' : text.front();
      text.remove_prefix(1);
    }
    content += c;
  }
  return std::nullopt;
}

/// Takes the labels between braces from the beginning of `text`, if there are any.
bool take_labels(std::string_view& text, std::map<std::string, std::string>& labels) {
  if (!take(text, '{')) return true;
  while (!take(text, '}')) {
    skip_space(text);
    const std::string name(take_until(text, "= \t"));
    if (name.empty() || !take(text, '=') || !take(text, '"')) return false;
    auto value = take_quoted(text);
    if (!value) return false;
    labels[name] = *std::move(value);
    take(text, ',');
  }
  return true;
}

std::optional<double> number_of(std::string_view text) {
  if (text == "+Inf") return std::numeric_limits<double>::infinity();
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

std::optional<MetricSample> parse_line(std::string_view line) {
  skip_space(line);
  if (line.empty() || line.front() == '#') return std::nullopt;
  MetricSample sample;
  sample.name = take_until(line, "{ \t");
  if (sample.name.empty() || !take_labels(line, sample.labels)) return std::nullopt;
  skip_space(line);
  const auto value = number_of(take_until(line, kSpace));  // a time stamp may follow
  if (!value) return std::nullopt;
  sample.value = *value;
  return sample;
}

}  // namespace

std::string MetricSample::text() const {
  std::string all;
  for (const auto& [label, content] : labels) {
    all += fmt::format("{}{}=\"{}\"", all.empty() ? "" : ",", label, content);
  }
  return all.empty() ? name : fmt::format("{}{{{}}}", name, all);
}

std::vector<MetricSample> parse_prometheus_text(std::string_view page) {
  std::vector<MetricSample> samples;
  while (!page.empty()) {
    const std::string_view line = take_until(page, "\n");
    if (!page.empty()) page.remove_prefix(1);
    if (auto sample = parse_line(line)) samples.push_back(*std::move(sample));
  }
  return samples;
}

}  // namespace segserve::bench
