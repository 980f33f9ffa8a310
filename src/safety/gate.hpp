// Safety gate, the last word on every command: limits, acceleration, watchdog, collision monitor, emergency stop.
// Model and plain State, so that a whole batch can run it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/safety/intervention.hpp"

namespace threewe::safety {

/// What never changes while a robot runs.
struct GateModel {
  Limits limits;
  Kinematics kinematics{};
  Footprint footprint;
  bool collision_monitor = true;    ///< and watchdog; off where nothing looks, and for `gate="limits"`
  Duration sensor_timeout = 500ms;  ///< no scan (or echo) for this long: stop
  double margin = 0.02;             ///< [m] kept free around the footprint
  Duration reaction = 120ms;        ///< from a command to its effect: command latency, motor lag, one period
};

/// The gate of a robot: its operating limits and its reaction time; a collision monitor where it has a lidar, or at
/// least ultrasonic sensors.
GateModel make_gate_model(const RobotProfile& profile);

/// The same for a robot that creeps through a gap: so slow that a touch would do no harm, 0.05 m/s at its corners, it
/// keeps no more free than is lost to the scatter of what it sees.
GateModel creep_mode(const GateModel& model);

/// The longest reaction that the gate can look ahead over.
inline constexpr Duration kMaxReaction = 320ms;

/// What changes. Plain data.
struct GateState {
  /// The commands of the periods before, newest first: those that the robot has yet to obey.
  std::array<Velocity, kMaxReaction / kControlPeriod> recent{};
  Time last_scan{};  ///< `received` of the newest scan; of the newest echo where there is no lidar
  bool scan_seen = false;
  bool estop = false;  ///< latched until released
  friend bool operator==(const GateState&, const GateState&) = default;

  /// The command of the period before.
  const Velocity& last() const { return recent.front(); }
};

/// One period. `obstacles` are what the lidar hits, or echoes [m], and `base` is where the robot is now, both in the
/// same frame. Throws nothing: a request that is not finite becomes a stop.
///
/// The speed of the body, |(vx, vy)|, grows by at most `linear_acceleration` and its vector changes by at most
/// `linear_braking`; the greater of the two where a profile brakes more gently than it speeds up.
/// A command passes the collision monitor when the robot, having obeyed it for one period, can still brake along its
/// arc and keep `margin` free. Where that is lost already (something moved, a scan was wrong), it passes if it comes no
/// nearer than braking at once would: a robot can always drive out of a tight place.
GateOutput gate(const GateModel& model, GateState& state, const Velocity& requested, std::span<const Vec2> obstacles,
                Time now, const Pose2D& base = {});

}  // namespace threewe::safety
