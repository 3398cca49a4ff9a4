// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"

namespace segserve {

/// Finds the member that an object of JSON has twice. nlohmann's parser takes the last one, so that a line that
/// somebody copied and forgot to change would go unnoticed. It is told each event of the parser.
template <typename Json>
class RepeatedMember {
 public:
  void on_event(typename Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_.emplace_back();
    if (event == Json::parse_event_t::object_end) open_.pop_back();
    if (event != Json::parse_event_t::key || name_) return;
    const auto& name = parsed.template get_ref<const std::string&>();
    if (!open_.back().insert(name).second) name_ = name;
  }
  /// The first one's name.
  const std::optional<std::string>& name() const { return name_; }

 private:
  std::vector<std::set<std::string>> open_;  ///< the names in the objects that have begun and not ended
  std::optional<std::string> name_;
};

/// Parses JSON of at most so many levels. INVALID_ARGUMENT says where a text is no JSON, or which member an object has
/// twice: "it is no JSON: parse error at line 2, column 5: ..".
template <typename Json>
absl::StatusOr<Json> parse_strict_json(std::string_view text, int most_levels = std::numeric_limits<int>::max()) {
  RepeatedMember<Json> repeated;
  bool is_deep = false;
  const auto on_event = [&](int depth, typename Json::parse_event_t event, const Json& parsed) {
    is_deep = is_deep || depth > most_levels;
    if (!is_deep) repeated.on_event(event, parsed);
    return !is_deep;
  };
  try {
    Json json = Json::parse(text, on_event);
    if (is_deep) return absl::InvalidArgumentError("it has more than " + std::to_string(most_levels) + " levels");
    if (repeated.name()) {
      const std::string name = Json(*repeated.name()).dump(-1, ' ', false, Json::error_handler_t::replace);
      return absl::InvalidArgumentError("it has an object with the member " + name + " twice");
    }
    return json;
  } catch (const typename Json::exception& error) {
    std::string_view why = error.what();  // "[json.exception.parse_error.101] parse error at .."
    if (const std::size_t end = why.find("] "); end != std::string_view::npos) why.remove_prefix(end + 2);
    return absl::InvalidArgumentError("it is no JSON: " + std::string(why));
  }
}

}  // namespace segserve
