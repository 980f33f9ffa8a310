// Domain randomization: distributions of how robots differ from their profile, and when they are drawn anew.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::models {

/// One draw: how one robot differs from its profile. Plain data. The default is the profile itself; factors multiply
/// what it says.
struct Variation {
  // the body and its drive
  double mass = 1.0;                ///< factor; the moment of inertia grows with it
  double friction = 1.0;            ///< factor of wheels on the floor
  double motor_lag = 1.0;           ///< factor of the speed loop's time constant
  double motor_noise = 0.0;         ///< standard deviation of each motor's torque in each step, as a share of it
  double battery_charge = 1.0;      ///< at the start, 0 to 1
  double battery_resistance = 1.0;  ///< factor, hence of how far the voltage sags

  // sensors
  double lidar_noise = 1.0;      ///< factor of range noise and of the unit's bias
  double lidar_dropout = 1.0;    ///< factor of the probability that a point is invalid
  double imu_noise = 1.0;        ///< factor of noise and of biases
  double camera_noise = 1.0;     ///< factor of noise, of colours and of depth
  double odometry_slip = 1.0;    ///< factor of how far wheels and lateral rolling are from what odometry assumes
  double command_latency = 1.0;  ///< factor, rounded to whole steps
  double sensor_latency = 1.0;   ///< factor of the lidar's and the camera's latency, rounded to whole steps

  // what the camera sees, and from where
  double light = 1.0;         ///< factor of the brightness of lamps and sun
  double exposure = 1.0;      ///< factor of what the camera makes of it
  double color_jitter = 0.0;  ///< standard deviation of each colour channel's gain
  double texture = 0.0;       ///< 0: surfaces as the scene has them; else which others they are made of, a whole number
  double detail = 1.0;        ///< of textures, shadows, tints of walls, windows and skirting: 1 all of them, 0 none
  Pose2D camera_offset{};     ///< of the camera from its mount, in the base frame
  double camera_height = 0.0;  ///< [m] added to the mount's

  friend bool operator==(const Variation&, const Variation&) = default;
};
static_assert(std::is_trivially_copyable_v<Variation>);
static_assert(sizeof(Variation) % sizeof(double) == 0);

/// From what a number is drawn.
struct Distribution {
  /// Which distribution.
  enum class Kind : std::uint8_t { constant, uniform, log_uniform, normal, integer };
  Kind kind = Kind::constant;  ///< which distribution
  double a = 0.0;              ///< the value, the lower bound or the mean
  double b = 0.0;              ///< the upper bound (that of `integer` included) or the standard deviation
};

/// One number of a `Variation` that is drawn.
struct RandomizedKnob {
  std::size_t knob = 0;       ///< place in `knob_names()`
  Distribution distribution;  ///< from which it is drawn
};

/// What is drawn when. The default draws nothing.
///
/// `startup`: once for each environment, and kept for all its episodes; `reset`: for each episode; `interval`: again
/// and again during an episode. What is drawn later counts.
struct Randomization {
  std::string name = "none";             ///< that of its file
  std::string description;               ///< one line
  std::vector<RandomizedKnob> startup;   ///< drawn once for each environment
  std::vector<RandomizedKnob> reset;     ///< drawn for each episode
  std::vector<RandomizedKnob> interval;  ///< drawn again and again
  Duration shortest_interval{};          ///< how long until the next draw, uniform between these
  Duration longest_interval{};           ///< see `shortest_interval`
};

/// The names of all numbers that can be drawn: those of `Variation`, with `camera_x`, `camera_y` [m] and `camera_yaw`
/// [rad] for its camera's offset.
const std::vector<std::string>& knob_names();
/// The number at a place in `knob_names()`, to be changed.
double& knob(Variation& variation, std::size_t place);
/// The number at a place in `knob_names()`.
double knob(const Variation& variation, std::size_t place);

/// The largest factor of latencies that can be drawn.
inline constexpr int kMostLatency = 10;

/// Reads assets/randomization/NAME.yaml, or the file itself where `name` ends in .yaml. Throws ConfigError.
Randomization load_randomization(std::string_view name);
/// Reads text (YAML, hence also JSON); `name` stands for the file in messages.
Randomization parse_randomization(const std::string& text, const std::string& name);
/// The names of all that come with the library, and of those in added folders.
std::vector<std::string> randomization_names();

/// How robot number `robot` of an environment differs in an episode: a pure function of its arguments. `draw` counts
/// the intervals that have gone by since the episode began.
Variation draw_variation(const Randomization& randomization, std::uint64_t seed, std::uint32_t episode,
                         std::size_t robot, std::uint64_t draw = 0);
/// How long interval number `draw` lasts, a whole number of control periods; the same for all robots of a world. 0
/// where nothing is drawn at intervals.
Duration draw_interval(const Randomization& randomization, std::uint64_t seed, std::uint32_t episode,
                       std::uint64_t draw);

}  // namespace threewe::models
