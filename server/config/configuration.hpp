// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "server/config/config_file.hpp"
#include "server/config/environment.hpp"

namespace segserve::server {

/// The unit or type of an option's values: "SECONDS", "whole number".
std::string type_of(const CLI::Option& option);

/// The settings of a program: every configurable option of its command line can also be set by a variable of the
/// environment and by a key of a TOML file. The command line goes before the environment, and that before the file. The
/// names and checks all follow from the options.
///
///     Configuration configuration(app);            // adds --config
///     configuration.read(argc, argv, process_environment());
///     app.parse(argc, argv);                       // sees what the environment and the file say
///     if (!configuration.faults().empty()) ...
class Configuration {
 public:
  /// `app` must outlive this object, and gets all other options before `read`.
  explicit Configuration(CLI::App& app);
  Configuration(const Configuration&) = delete;
  Configuration& operator=(const Configuration&) = delete;

  /// Gives each option that the command line does not set its value from the environment or the file. The command line
  /// itself is left to CLI11.
  void read(int argc, const char* const* argv, const Environment& environment);

  /// Every fault of environment and file, each in a line that begins with its place.
  const std::vector<std::string>& faults() const { return faults_; }
  /// Variables of the environment that may be mistakes.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Where the value of an option comes from, for a message: "--queue", "SEGSERVE_QUEUE" or "FILE:3: queue".
  std::string place_of(std::string_view option) const;

  /// A line for each file that an option names but that cannot be read (options of the type FILE), or whose folder does
  /// not exist (PATH), with the option's place. After CLI11 has parsed the command line.
  std::vector<std::string> missing_files() const;

  /// All settings as TOML, each with its unit and where it comes from. Read as a file it gives the same settings. After
  /// CLI11 has parsed the command line without a fault.
  std::string to_toml() const;

 private:
  enum class Source { kDefault, kFile, kEnvironment, kCommandLine };
  struct Setting {
    const CLI::Option* option = nullptr;
    Source source = Source::kDefault;
    std::string place;                ///< of its value, as place_of returns it
    std::vector<std::string> values;  ///< as they were written; that of a switch is "true" or "false"
  };

  std::vector<std::string> names() const;
  void find_on_command_line(int argc, const char* const* argv);
  void read_environment(const Environment& environment);
  void read_file(const std::string& path);
  void read_entry(FileEntry entry, const std::string& path, std::vector<FileFault>& faults);
  /// Gives an option its values. Returns what is wrong with them; empty if nothing is.
  std::string take(CLI::Option& option, Setting setting);
  std::string describe(const Setting& setting) const;

  CLI::App& app_;
  std::string path_;                         // of the file; empty: none
  std::map<std::string, Setting> settings_;  // those that are not the default, by the name of their option
  std::vector<std::string> faults_, warnings_;
};

}  // namespace segserve::server
