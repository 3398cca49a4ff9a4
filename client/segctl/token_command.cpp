// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/segctl/command.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/regular_file.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "credentials/new_token.hpp"
#include "credentials/subject_limits.hpp"
#include "credentials/token_file.hpp"
#include "credentials/token_hash.hpp"
#include "fmt/chrono.h"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

HelpText help() {
  return {.common = {"--output", "--tokens", "--days", "--frames-per-second"},
          .examples = R"(segctl token robot-7 --output robot-7.token --tokens tokens.toml
segctl token robot-7 --tokens tokens.toml --days 90 --frames-per-second 30 > robot-7.token
segctl token robot-7)",
          .details =
              "The token is a secret of the client. The server's file holds its hash alone, from which nobody can "
              "make the token. A subject may have several tokens: to renew one, make another for the same subject, "
              "give it to the client, and take the old one out of the file. The server reads its file anew when it "
              "changes.",
          .exit_codes = "0 success; 1 a file cannot be written; 2 bad usage, or a file that has faults."};
}

struct TokenArguments {
  std::string subject, output, tokens;
  std::optional<double> days;
  credentials::SubjectLimits limits;

  void add_to(CLI::App& app) {
    app.add_option("SUBJECT", subject, "who gets the token: the name that the server's limits and logs have")
        ->required();
    app.add_option("-o,--output", output,
                   "write the token to this new file, which only its owner may read (default: standard output)")
        ->type_name("FILE")
        ->group("Output");
    app.add_option("--tokens", tokens,
                   "add the hash, and the limits, to this file of the server (default: standard output)")
        ->type_name("FILE")
        ->group("Output");
    app.add_option("--days", days, "let the token expire after so many days")->type_name("NUMBER")->group("Token");
    app.add_option("--frames-per-second", limits.frames_per_second, "most frames a second of the subject")
        ->type_name("NUMBER")
        ->group("Limits");
    app.add_option("--points-per-second", limits.points_per_second, "most points a second of the subject")
        ->type_name("NUMBER")
        ->group("Limits");
    app.add_option("--bytes-in-flight", limits.bytes_in_flight,
                   "most bytes of payload that the subject may have under way, e.g. 64MiB")
        ->transform(CLI::AsSizeValue(false))
        ->type_name("BYTES")
        ->group("Limits");
    app.add_option("--highest-priority", limits.highest_priority, "priorities of frames are lowered to this")
        ->type_name("NUMBER")
        ->group("Limits");
  }

  bool has_limits() const { return limits != credentials::SubjectLimits{}; }
};

/// Makes the token's entry for the server's file, as TOML.
absl::StatusOr<std::string> entry(const TokenArguments& arguments, std::string_view token) {
  constexpr double kMostDays = 36500;
  std::string text;
  const auto add = [&text](std::string_view key, const auto& value) {
    if (value) fmt::format_to(std::back_inserter(text), "{} = {}\n", key, *value);
  };
  if (arguments.has_limits()) {
    text += fmt::format("[subject.\"{}\"]\n", arguments.subject);
    add("frames_per_second", arguments.limits.frames_per_second);
    add("points_per_second", arguments.limits.points_per_second);
    add("bytes_in_flight", arguments.limits.bytes_in_flight);
    add("highest_priority", arguments.limits.highest_priority);
    text += "\n";
  }
  text += fmt::format("[[token]]\nsubject = \"{}\"\nsha256 = \"{}\"\n", arguments.subject,
                      credentials::to_hex(credentials::hash_of(token)));
  if (arguments.days) {
    if (!(*arguments.days > 0 && *arguments.days <= kMostDays)) {
      return absl::InvalidArgumentError(
          fmt::format("days: {} is not above 0, or above {}", *arguments.days, kMostDays));
    }
    const auto seconds = std::chrono::seconds(static_cast<std::int64_t>(std::ceil(*arguments.days * 86400)));
    const std::time_t end = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now() + seconds);
    text += fmt::format("not_after = {:%Y-%m-%dT%H:%M:%SZ}\n", fmt::gmtime(end));
  }
  return text;
}

/// Returns the file's new content, with the entry. INVALID_ARGUMENT if it would have faults.
absl::StatusOr<std::string> with_entry(const TokenArguments& arguments, const std::string& entry) {
  std::string before;
  if (std::filesystem::exists(arguments.tokens)) {
    ASSIGN_OR_RETURN(before, read_regular_file(arguments.tokens, credentials::kMostTokenFileBytes));
    ASSIGN_OR_RETURN(const credentials::TokenFile file, credentials::parse_token_file(before, arguments.tokens));
    if (arguments.has_limits() && file.subject_limits.contains(arguments.subject)) {
      return absl::InvalidArgumentError(
          fmt::format("{} has limits of {} already; change them there", arguments.tokens, arguments.subject));
    }
  }
  std::string added = (before.empty() ? "" : before.ends_with('\n') ? "\n" : "\n\n") + entry;
  RETURN_IF_ERROR(credentials::parse_token_file(before + added, arguments.tokens).status());
  return added;
}

/// Writes the text in one step to a file that is opened with these flags.
absl::Status write(const std::string& path, std::string_view text, int flags, mode_t mode) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, mode);
  bool written = file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (file >= 0) written = close(file) == 0 && written;
  if (written) return absl::OkStatus();
  if (file < 0 && error == EEXIST) return absl::InvalidArgumentError(fmt::format("{} exists already", path));
  return absl::UnavailableError(fmt::format("cannot write {}: {}", path, std::strerror(error)));
}

absl::Status run(const TokenArguments& arguments) {
  if (!credentials::is_subject_name(arguments.subject)) {
    return absl::InvalidArgumentError("the name of a subject has 1 to 64 letters, digits, '.', '_', '-' or '@'");
  }
  ASSIGN_OR_RETURN(const std::string token, credentials::new_token());
  ASSIGN_OR_RETURN(std::string entry_text, entry(arguments, token));
  const bool to_file = !arguments.tokens.empty();
  if (to_file) {
    ASSIGN_OR_RETURN(entry_text, with_entry(arguments, entry_text));
  } else {  // it may have faults even so, e.g. limits that are negative
    RETURN_IF_ERROR(credentials::parse_token_file(entry_text, "the entry").status());
  }
  if (!arguments.output.empty()) RETURN_IF_ERROR(write(arguments.output, token + "\n", O_EXCL, 0600));
  if (to_file) {
    const absl::Status written = write(arguments.tokens, entry_text, O_APPEND, 0644);
    if (!written.ok() && !arguments.output.empty()) std::filesystem::remove(arguments.output);
    RETURN_IF_ERROR(written);
  }
  std::string printed = arguments.output.empty() ? token + "\n" : "";
  if (!to_file) printed += (printed.empty() ? "" : "\n") + entry_text;
  StagedOutput output;
  if (!printed.empty()) output.add("-", std::move(printed));
  return output.commit();
}

}  // namespace

void add_token_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "token", "Make a bearer token for a client, and its line for the server", help(), run);
}

}  // namespace segserve::segctl
