// SPDX-License-Identifier: Apache-2.0
#include "credentials/token_file.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "absl/strings/ascii.h"
#include "fmt/format.h"

#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#include <toml++/impl/preprocessor.h>
// toml++ 3.3 assumes that the name of a table begins as names do before it checks that. So "[&" would abort a debug
// build, and have undefined behavior where clang compiles. Without the assumption the check finds the fault.
#undef TOML_ASSERT_ASSUME
#define TOML_ASSERT_ASSUME(expression) static_assert(true)
#include <toml++/toml.h>

namespace segserve::credentials {
namespace {

constexpr std::size_t kMostTokens = 10'000, kMostSubjects = 10'000, kMostFaults = 20;
constexpr std::size_t kMostNameBytes = 64, kMostSubjectBytes = 512;

/// Reads a file's tables, and notes every fault with its line.
class Reader {
 public:
  explicit Reader(std::string_view file) : file_(file) {}

  void read(const toml::table& root);
  absl::StatusOr<TokenFile> result() &&;

 private:
  template <typename... Values>
  void fault(const toml::node& where, fmt::format_string<Values...> format, Values&&... values) {
    const auto line = where.source().begin.line;
    const std::string text = fmt::format(format, std::forward<Values>(values)...);
    faults_.emplace(line, fmt::format("{}:{}: {}", file_, line, text));
  }

  const toml::table* table(const toml::node& node, std::string_view name);
  void refuse_others(const toml::table& table, std::span<const std::string_view> allowed);
  SubjectLimits read_limits(const toml::table& table);
  void read_rate(const toml::table& table, std::string_view key, std::optional<double>& rate);
  template <typename Integer>
  void read_integer(const toml::table& table, std::string_view key, Integer least, std::optional<Integer>& value);
  void read_subjects(const toml::table& subjects);
  void read_tokens(const toml::array& tokens);
  void read_token(const toml::table& table);
  std::optional<WallTime> read_time(const toml::node& node);

  const std::string file_;
  TokenFile content_;
  std::set<TokenHash> hashes_;
  std::multimap<std::uint32_t, std::string> faults_;  // by line
};

void Reader::read(const toml::table& root) {
  static constexpr std::array<std::string_view, 3> kTables{"default", "subject", "token"};
  refuse_others(root, kTables);
  if (const toml::node* node = root.get("default")) {
    if (const toml::table* limits = table(*node, "default")) content_.default_limits = read_limits(*limits);
  }
  if (const toml::node* node = root.get("subject")) {
    if (const toml::table* subjects = table(*node, "subject")) read_subjects(*subjects);
  }
  if (const toml::node* node = root.get("token")) {
    if (const toml::array* tokens = node->as_array()) {
      read_tokens(*tokens);
    } else {
      fault(*node, "a token begins with [[token]]");
    }
  }
}

const toml::table* Reader::table(const toml::node& node, std::string_view name) {
  if (!node.is_table()) fault(node, "'{}' is no table", name);
  return node.as_table();
}

void Reader::refuse_others(const toml::table& table, std::span<const std::string_view> allowed) {
  for (const auto& [key, node] : table) {
    if (std::ranges::find(allowed, key.str()) != allowed.end()) continue;
    fault(node, "there is no '{}'; there are {}", key.str().substr(0, kMostNameBytes), fmt::join(allowed, ", "));
  }
}

SubjectLimits Reader::read_limits(const toml::table& table) {
  static constexpr std::array<std::string_view, 4> kLimits{"frames_per_second", "points_per_second", "bytes_in_flight",
                                                           "highest_priority"};
  refuse_others(table, kLimits);
  SubjectLimits limits;
  read_rate(table, kLimits[0], limits.frames_per_second);
  read_rate(table, kLimits[1], limits.points_per_second);
  read_integer<std::uint64_t>(table, kLimits[2], 1, limits.bytes_in_flight);
  read_integer(table, kLimits[3], std::numeric_limits<std::int32_t>::min(), limits.highest_priority);
  return limits;
}

void Reader::read_rate(const toml::table& table, std::string_view key, std::optional<double>& rate) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  const std::optional<double> value = node->value<double>();
  if (!node->is_number() || !value || !(*value > 0)) {
    return fault(*node, "{}: it must be a number above 0", key);
  }
  rate = value;
}

template <typename Integer>
void Reader::read_integer(const toml::table& table, std::string_view key, Integer least,
                          std::optional<Integer>& value) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  const std::optional<std::int64_t> number = node->value_exact<std::int64_t>();
  if (!number || !std::in_range<Integer>(*number) || static_cast<Integer>(*number) < least) {
    return fault(*node, "{}: it must be a whole number of at least {}", key, least);
  }
  value = static_cast<Integer>(*number);
}

void Reader::read_subjects(const toml::table& subjects) {
  if (subjects.size() > kMostSubjects) return fault(subjects, "there are more than {} subjects", kMostSubjects);
  for (const auto& [key, node] : subjects) {
    const std::string name(key.str());
    if (name.empty() || name.size() > kMostSubjectBytes) {
      fault(node, "the name of a subject has 1 to {} bytes", kMostSubjectBytes);
    } else if (const toml::table* limits = table(node, name.substr(0, kMostNameBytes))) {
      content_.subject_limits.emplace(name, read_limits(*limits));
    }
  }
}

void Reader::read_tokens(const toml::array& tokens) {
  if (tokens.size() > kMostTokens) return fault(tokens, "there are more than {} tokens", kMostTokens);
  for (const toml::node& node : tokens) {
    if (const toml::table* each = table(node, "token")) read_token(*each);
  }
}

void Reader::read_token(const toml::table& table) {
  static constexpr std::array<std::string_view, 3> kKeys{"subject", "sha256", "not_after"};
  refuse_others(table, kKeys);
  TokenFile::Token token;
  const toml::node* const subject = table.get(kKeys[0]);
  const toml::node* const sha256 = table.get(kKeys[1]);
  if (subject == nullptr) {
    fault(table, "the token has no subject");
  } else if (token.subject = subject->value_exact<std::string>().value_or(""); !is_subject_name(token.subject)) {
    fault(*subject, "subject: a name has 1 to {} letters, digits, '.', '_', '-' or '@'", kMostNameBytes);
  }
  if (sha256 == nullptr) {
    fault(table, "the token has no sha256");
  } else if (const auto hash = hash_from_hex(sha256->value_exact<std::string>().value_or("")); !hash) {
    fault(*sha256, "sha256: it must be a text of 64 hexadecimal digits, as `segctl token` makes it");
  } else if (!hashes_.insert(token.hash = *hash).second) {
    fault(*sha256, "sha256: the file has this token already");
  }
  if (const toml::node* not_after = table.get(kKeys[2])) token.not_after = read_time(*not_after);
  content_.tokens.push_back(std::move(token));
}

std::optional<WallTime> Reader::read_time(const toml::node& node) {
  using std::chrono::day, std::chrono::month, std::chrono::year;
  const std::optional<toml::date_time> time = node.value_exact<toml::date_time>();
  constexpr int kFirstYear = 1970, kLastYear = 2200;  // the clock of the system ends in 2262
  if (!time || time->is_local() || time->date.year < kFirstYear || time->date.year > kLastYear) {
    fault(node, "not_after: it must be a time with its offset, such as 2027-01-01T00:00:00Z, from {} to {}", kFirstYear,
          kLastYear);
    return std::nullopt;
  }
  const std::chrono::sys_days date{year(time->date.year) / month(time->date.month) / day(time->date.day)};
  return date + std::chrono::hours(time->time.hour) + std::chrono::minutes(time->time.minute - time->offset->minutes) +
         std::chrono::seconds(time->time.second);
}

absl::StatusOr<TokenFile> Reader::result() && {
  if (faults_.empty()) return std::move(content_);
  std::vector<std::string> told;
  for (const auto& [line, text] : faults_) {
    if (told.size() < kMostFaults) told.push_back(text);
  }
  if (faults_.size() > told.size()) told.push_back(fmt::format("and {} more faults", faults_.size() - told.size()));
  return absl::InvalidArgumentError(fmt::format("{}", fmt::join(told, "; ")));
}

}  // namespace

const TokenFile::Token* TokenFile::find(const TokenHash& hash) const {
  const Token* found = nullptr;
  for (const Token& token : tokens) {
    if (equal_in_constant_time(token.hash, hash)) found = &token;
  }
  return found;
}

SubjectLimits TokenFile::limits_of(std::string_view subject) const {
  const auto own = subject_limits.find(subject);
  if (own == subject_limits.end()) return default_limits;
  SubjectLimits limits = own->second;
  const auto complete = [](auto& limit, const auto& default_limit) {
    if (!limit) limit = default_limit;
  };
  complete(limits.frames_per_second, default_limits.frames_per_second);
  complete(limits.points_per_second, default_limits.points_per_second);
  complete(limits.bytes_in_flight, default_limits.bytes_in_flight);
  complete(limits.highest_priority, default_limits.highest_priority);
  return limits;
}

bool is_subject_name(std::string_view name) {
  constexpr std::string_view kPunctuation = "._-@";
  return !name.empty() && name.size() <= kMostNameBytes && std::ranges::all_of(name, [&](char letter) {
    return absl::ascii_isalnum(static_cast<unsigned char>(letter)) ||
           kPunctuation.find(letter) != std::string_view::npos;
  });
}

absl::StatusOr<TokenFile> parse_token_file(std::string_view text, std::string_view name) {
  // toml++ 3.3 has undefined behavior at some letters beyond ASCII, such as U+FEF7 outside of quotes.
  const auto letter = std::ranges::find_if_not(text, absl::ascii_isascii);
  if (letter != text.end()) {
    return absl::InvalidArgumentError(fmt::format(
        "{}:{}: there is a letter beyond ASCII; in quotes it can be written as \\u and four hexadecimal digits", name,
        1 + std::count(text.begin(), letter, '\n')));
  }
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    const toml::parse_error& error = parsed.error();
    return absl::InvalidArgumentError(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
  Reader reader(name);
  reader.read(parsed.table());
  return std::move(reader).result();
}

}  // namespace segserve::credentials
