// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/unit_flag.hpp"

namespace segserve::segctl {

void UnitFlag::add_to(CLI::App& app, const std::string& group) {
  option_ =
      app.add_option("--unit", name_,
                     "unit of the coordinates in the file; auto takes meters or millimeters, as the spacing of the "
                     "points makes plain")
          ->check(CLI::IsMember({"m", "cm", "mm", "in", "ft", "auto"}))
          ->type_name("NAME")
          ->capture_default_str()
          ->group(group);
}

}  // namespace segserve::segctl
