// Model predictive path integral control: thousands of noisy variations of a plan are rolled out and priced each tick,
// and their average, weighted by price, is the next plan (Williams et al. 2018, "Information-Theoretic Model Predictive
// Control: Theory and Applications to Autonomous Driving", IEEE T-RO 34(6)).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

/// Somebody who walks, or another robot, in `odom`.
struct MovingDisc {
  Vec2 position;        ///< [m]
  Vec2 velocity;        ///< [m/s]
  double radius = 0.3;  ///< [m]
};

/// What each critic's price weighs. All prices of a plan are added up; 1 m of the path that is left costs 3 at each of
/// 14 looks.
struct MppiWeights {
  double path_left = 3.0;          ///< [1/m] of the path that is left
  double path_beside = 2.0;        ///< [1/m^2] beside the path
  double goal_distance = 3.0;      ///< [1/m] to the end of the path, where it is within reach
  double goal_speed = 2.0;         ///< [s^2/m^2] of not resting there
  double obstacle_contact = 60.0;  ///< of an outline nearer than the margin
  double obstacle_depth = 1000.0;  ///< [1/m] and more, the deeper
  double obstacle_close = 0.1;     ///< of an outline at the margin, none `obstacle_reach` beyond it
  double obstacle_speed = 20.0;    ///< [s^2/m^2] and more, the faster its body and corners move there
  double heading_along = 0.5;      ///< of not facing along the path
  double heading_sideways = 20.0;  ///< [s^2/m^2] of driving sideways faster than `sideways_free`
  double heading_backward = 1.0;   ///< [s^2/m^2] of driving against the way it is to go
  double heading_turn = 3.0;       ///< [1/rad] of what is left of a turn on the spot
  double smooth_linear = 1.0;      ///< [s^2/m^2] of changes of velocity
  double smooth_angular = 0.1;     ///< [s^2/rad^2]
  double people_contact = 100.0;   ///< [s/m] of driving where an outline's disc meets one that moves
  double people_close = 1.0;       ///< [s/m] of driving beside it, none `people_reach` beyond it
};

/// The defaults are what robots drive with, and what is tested, benchmarked and verified. More samples, or more plans a
/// second, bring a robot nowhere sooner or more surely (docs/decisions/0014-model-predictive-control.md). What is near
/// slows it down, but only what is very near.
struct MppiSettings {
  int samples = 512;             ///< a multiple of 16 is rolled out: the next one
  double step = 0.05;            ///< [s] of a plan, which has 56
  int periods = 5;               ///< control periods from one plan to the next; it is followed in between
  double temperature = 0.05;     ///< samples that cost so much more count e times less
  double control_cost = 0.02;    ///< of steering away from the plan before, in temperatures
  double linear_noise = 0.15;    ///< [m/s] standard deviation
  double angular_noise = 0.5;    ///< [rad/s] standard deviation
  double sideways_free = 0.15;   ///< [m/s] a mecanum base slips least surely sideways: slowly it may
  double obstacle_reach = 0.05;  ///< [m]
  double people_reach = 0.25;    ///< [m]
  std::uint64_t seed = 0;        ///< of the noise
  MppiWeights weights{};
};

/// What the controller is to do.
struct MppiTask {
  std::span<const Vec2> path{};  ///< in `odom`, followed to rest at its end; empty: stay
  bool backwards = false;        ///< drive the path backwards
  double aside = 0.0;            ///< [rad] to face to the left of the path
  std::optional<double> turn{};  ///< [rad] left to turn on the spot, more than a full turn too; without a path
  bool keep_line = false;        ///< what stands on the path is not driven around
  double margin = 0.0;           ///< [m] to keep free around the outline
};

/// What it sees at one tick.
struct MppiObservation {
  Time now{};
  Pose2D odom_from_base;
  Velocity commanded;                    ///< what the robot was told to do in the period before
  std::span<const Vec2> obstacles;       ///< in `odom` [m], of the newest scan
  std::span<const MovingDisc> moving{};  ///< of which obstacles are no obstacles
};

/// The controller of one robot. It can be copied; copies go on alike, to the bit.
class Mppi {
 public:
  explicit Mppi(const RobotProfile& profile, const MppiSettings& settings = {});
  Mppi(const Mppi& other);
  Mppi& operator=(const Mppi& other);
  Mppi(Mppi&&) noexcept;
  Mppi& operator=(Mppi&&) noexcept;
  ~Mppi();

  /// The next command, within the operating limits and within reach of the one before. The plan goes on from period to
  /// period; where one is left out, it starts anew.
  Velocity step(const MppiObservation& seen, const MppiTask& task);

  /// The plan that was followed at `now`, with its samples; empty where none was. They are rolled out once more for
  /// whoever asks: nobody else pays for them, and nothing changes.
  std::optional<SampledPlan> plan(Time now) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe::nav
