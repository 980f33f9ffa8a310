// The last word on every command: limits, acceleration, watchdog, collision monitor, latched emergency stop.
// Model and plain State, so that a whole batch can run it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// Why the gate changed a command.
enum class Intervention : std::uint8_t { none, limited, slowed_for_obstacle, stopped_for_obstacle, stale_sensors, estop };
std::string_view to_string(Intervention intervention);

/// What never changes while a robot runs.
struct GateModel {
  Limits limits;
  Kinematics kinematics{};
  Footprint footprint;
  bool collision_monitor = true;   ///< off for robots without a lidar and for `gate="limits"`
  Duration sensor_timeout = 500ms; ///< no scan for this long: stop
  double margin = 0.02;            ///< [m] kept free around the footprint
  Duration reaction = 120ms;       ///< from a command to the first effect: command latency, motor lag, one period
};

/// What changes. Plain data.
struct GateState {
  Velocity last;             ///< the command of the period before
  Time last_scan{};          ///< `received` of the newest scan
  bool scan_seen = false;
  bool estop = false;        ///< latched until released
  friend bool operator==(const GateState&, const GateState&) = default;
};

struct GateOutput {
  Velocity command;
  Intervention intervention = Intervention::none;
};

/// One period. `obstacles` are lidar hits in the *current* base frame [m]. Throws nothing: a request that is not finite
/// becomes a stop.
GateOutput gate(const GateModel& model, GateState& state, const Velocity& requested, std::span<const Vec2> obstacles,
                Time now);

}  // namespace threewe::safety
