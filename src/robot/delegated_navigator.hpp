// Navigator that lets another program on the robot drive, such as Nav2.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "backend/delegation.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/perception/percepts.hpp"

namespace threewe {

/// To positions and along paths, past the safety gate. `own` does the rest.
std::unique_ptr<nav::Navigator> make_delegated_navigator(std::string program, backend::ExternalNavigator& driver,
                                                         std::unique_ptr<nav::Navigator> own);
/// How the program is, by its name, of such a navigator; empty of others.
std::optional<perception::SensorHealth> program_health(const nav::Navigator& navigator);

}  // namespace threewe
