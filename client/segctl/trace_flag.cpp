// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/trace_flag.hpp"

#include <cstdlib>

#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/traceparent.hpp"

namespace segserve::segctl {

void TraceFlag::add_to(CLI::App& app) {
  const char* from_environment = std::getenv("TRACEPARENT");
  if (from_environment != nullptr && wire::parse_traceparent(from_environment)) traceparent_ = from_environment;
  const auto resolve = [this](std::string& text) -> std::string {
    is_new_ = text == "new";
    if (is_new_) {
      text = to_text(
          wire::Traceparent{.trace_id = wire::new_trace_id(), .span_id = wire::new_span_id(), .is_sampled = true});
    }
    if (text.empty()) return "it is empty";
    return message_of(wire::check_traceparent(text));
  };
  option_ = app.add_option("--traceparent", traceparent_,
                           "W3C trace context for the logs and traces of the server, or new: begins a trace and tells "
                           "its name; also from TRACEPARENT")
                ->transform(CLI::Validator(resolve, ""))
                ->type_name("TEXT")
                ->group("Server");
}

void TraceFlag::announce() const {
  if (is_new_) fmt::print(stderr, "segctl: traceparent {}\n", traceparent_);
}

}  // namespace segserve::segctl
