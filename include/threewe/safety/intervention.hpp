// Interventions of the safety gate: what it let through of a command, and why it changed it.
#pragma once

#include <cstdint>
#include <string_view>

#include "threewe/core/pose.hpp"

namespace threewe::safety {

/// Why the gate changed a command.
enum class Intervention : std::uint8_t {
  none,
  limited,
  slowed_for_obstacle,
  stopped_for_obstacle,
  stale_sensors,
  estop
};
/// Its name, such as "slowed_for_obstacle".
std::string_view to_string(Intervention intervention);

/// What the gate lets through.
struct GateOutput {
  Velocity command;                                ///< that may be sent to the port
  Intervention intervention = Intervention::none;  ///< why it differs from the request
  friend bool operator==(const GateOutput&, const GateOutput&) = default;
};

}  // namespace threewe::safety
