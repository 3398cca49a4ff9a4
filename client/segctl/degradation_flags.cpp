#include "client/segctl/degradation_flags.hpp"

namespace segserve::segctl {

void DegradationFlags::add_to(CLI::App& app) {
  const auto number = [&](const char* flag, auto& value, const char* help) {
    app.add_option(flag, value, help)->capture_default_str()->group("Degradation, in this order");
  };
  number("--scale", degradation_.scale, "all coordinates times this, up to 1000");
  number("--noise-mm", degradation_.noise_mm,
         "standard deviation of depth noise at 1 m in millimetres; it grows with the square of the depth");
  number("--keep", degradation_.keep, "share of the points that stay, up to 1");
  app.add_flag("--no-color", no_color_, "without colour")->group("Degradation, in this order");
  number("--seed", degradation_.seed, "everything random follows from it");
}

eval::Degradation DegradationFlags::degradation() const {
  eval::Degradation degradation = degradation_;
  degradation.color = !no_color_;
  return degradation;
}

}  // namespace segserve::segctl
