// Error codes of Nav2 as outcomes of the delegation port, and explained.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "backend/delegation.hpp"

namespace threewe::ros2 {

/// Why a goal failed.
struct NavigationError {
  backend::ExternalNavigator::Outcome outcome{};
  std::string detail;  ///< "NO_VALID_PATH (208): there is no path to the goal", and what Nav2 says besides
};

/// Of a goal that Nav2 aborted. Codes are those of Jazzy to Lyrical: of its planner, its controller, its recoveries and
/// its behaviour trees. One that is not known is a fault with its number.
NavigationError explain(std::uint16_t code, std::string_view message);

}  // namespace threewe::ros2
