// Safety gate, the last word on every command: limits, acceleration, watchdog, collision monitor, emergency stop.
// Model and plain State, so that a whole batch can run it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "safety/params.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/safety/intervention.hpp"

namespace threewe::safety {

/// What never changes while a robot runs.
struct GateModel {
  Limits limits;
  Kinematics kinematics{};
  WheelGeometry wheels;
  double wheel_speed = 0.0;  ///< [m/s] at which a wheel rolls at most; 0: as fast as it takes
  Footprint footprint;
  bool collision_monitor = true;        ///< and watchdog; off where nothing looks, and for `gate="limits"`
  Duration sensor_timeout = 500ms;      ///< no scan (or echo) for this long: stop
  double margin = 0.02;                 ///< [m] kept free around the footprint
  double sweep_step = 0.005;            ///< [m] the longest way of any corner between two poses that are checked
  Params::Creep creep;                  ///< of creep mode
  std::optional<Vec2> base_from_lidar;  ///< [m] empty where no lidar measures narrow passages
  double noise = 0.0;                   ///< [m] standard deviation of its ranges
  double bias = 0.0;                    ///< [m] the largest constant error of its ranges
  Duration reaction = 120ms;            ///< from a command to its effect: command latency, motor lag, one period
};

/// The gate of a robot: its operating limits and its reaction time; a collision monitor where it has a lidar, or at
/// least ultrasonic sensors.
GateModel make_gate_model(const RobotProfile& profile);

/// The longest reaction that the gate can look ahead over.
inline constexpr Duration kMaxReaction = 320ms;

/// The commands of the periods before, among them those that the robot has yet to obey. A ring: most periods read none
/// but the newest.
class RecentCommands {
 public:
  static constexpr std::size_t kSize = kMaxReaction / kControlPeriod;

  void push(const Velocity& command) {
    newest_ = (newest_ + kSize - 1) % kSize;
    commands_[newest_] = command;
  }
  /// The command so many periods before the newest.
  const Velocity& operator[](std::size_t before) const { return commands_[(newest_ + before) % kSize]; }
  friend bool operator==(const RecentCommands& a, const RecentCommands& b) {
    for (std::size_t i = 0; i < kSize; ++i) {
      if (a[i] != b[i]) return false;
    }
    return true;
  }

 private:
  std::size_t newest_ = 0;
  std::array<Velocity, kSize> commands_{};
};

/// What changes. Plain data.
struct GateState {
  Time last_scan{};  ///< `received` of the newest scan; of the newest echo where there is no lidar
  bool scan_seen = false;
  bool crept = false;  ///< the margin of creep mode was allowed: so creep mode goes on until the margin is free
  bool estop = false;  ///< latched until released
  RecentCommands recent{};
  friend bool operator==(const GateState&, const GateState&) = default;

  /// The command of the period before.
  const Velocity& last() const { return recent[0]; }
};

/// What is asked of the gate.
struct Request {
  Velocity velocity;
  /// Slowly, and nearer to the sides of a narrow passage than else. Whichever part asks, the gate measures the passage
  /// itself, and keeps the whole margin of what it does not pass, and until the robot is as slow as that.
  bool creep_mode = false;
};

/// Points in a frame that stands still [m], such as `odom`.
struct Surroundings {
  std::span<const Vec2> hits;     ///< what the lidar hits; sonar returns and bumps where there is none
  std::span<const Vec2> assumed;  ///< where something may be, or is expected to be
};

/// One period. `odom_from_base` is where the robot is now, in the frame of its surroundings. Throws nothing: a request
/// that is not finite becomes a stop.
///
/// The speed of the body, |(vx, vy)|, grows by at most `linear_acceleration` and its vector changes by at most
/// `linear_braking`; the greater of the two where a profile brakes more gently than it speeds up.
/// A command passes the collision monitor when the robot, having obeyed it for one period, can still brake along its
/// arc and keep `margin` free. Where that is lost already (something moved, a scan was wrong), it passes if it comes no
/// nearer than braking at once would: a robot can always drive out of a tight place.
GateOutput gate(const GateModel& model, GateState& state, const Request& request, const Surroundings& surroundings,
                Time now, const Pose2D& odom_from_base = {});

}  // namespace threewe::safety
