// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/unit_flag.hpp"

namespace segserve::segctl {

void UnitFlag::add_to(CLI::App& app, const std::string& group) {
  option_ = app.add_option("--unit", name_,
                           "unit of the coordinates in the file: m, cm, mm, in, ft or auto; default: as "
                           "the file says, for example by a name such as x_mm, or else m")
                ->check(CLI::IsMember({"m", "cm", "mm", "in", "ft", "auto"}))
                ->option_text("NAME")
                ->group(group);
}

}  // namespace segserve::segctl
