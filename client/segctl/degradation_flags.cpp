// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/degradation_flags.hpp"

#include <string>

#include "command_line/not_negative.hpp"

namespace segserve::segctl {

void DegradationFlags::add_to(CLI::App& app) {
  const std::string group = "Degradation of the scenes, in this order";
  const auto number = [&](const char* flag, auto& value, const char* help) {
    return app.add_option(flag, value, help)->capture_default_str()->group(group);
  };
  number("--scale", degradation_.scale, "multiply all coordinates by this factor, at most 1000");
  number("--noise-mm", degradation_.noise_mm,
         "standard deviation of depth noise at 1 m in millimeters; it grows with the square of the depth");
  number("--keep", degradation_.keep, "share of the points that stay, at most 1");
  app.add_flag("--no-color", no_color_, "remove the color")->group(group);
  number("--seed", degradation_.seed, "seed of everything that is random")->check(not_negative());
}

eval::Degradation DegradationFlags::degradation() const {
  eval::Degradation degradation = degradation_;
  degradation.color = !no_color_;
  return degradation;
}

}  // namespace segserve::segctl
