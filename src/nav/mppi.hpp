// Model predictive path integral control: thousands of noisy variations of a plan are rolled out and priced each tick,
// and their average, weighted by price, is the next plan (Williams et al. 2018, "Information-Theoretic Model Predictive
// Control: Theory and Applications to Autonomous Driving", IEEE T-RO 34(6)).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "nav/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

/// A person who walks, or another robot, in `odom`.
struct MovingDisc {
  Vec2 position;        ///< [m]
  Vec2 velocity;        ///< [m/s]
  double radius = 0.3;  ///< [m]
};

/// What the controller is to do.
struct MppiTask {
  std::span<const Vec2> path{};  ///< in `odom`, followed to rest at its end; empty: stay
  bool backwards = false;        ///< drive the path backwards
  double aside = 0.0;            ///< [rad] to face to the left of the path
  std::optional<double> turn{};  ///< [rad] left to turn on the spot, more than a full turn too; without a path
  double margin = 0.0;           ///< [m] to keep free around the outline
};

/// What it sees at one tick.
struct MppiObservation {
  Time now{};
  Pose2D odom_from_base;
  Velocity commanded;                    ///< the command of the period before
  std::span<const Vec2> obstacles;       ///< in `odom` [m], of the newest scan
  std::span<const MovingDisc> moving{};  ///< of which obstacles are no obstacles
};

/// The controller of one robot. What is near slows it down, but only what is very near. It can be copied; copies go on
/// alike, to the bit.
class Mppi {
 public:
  /// `seed`: of the noise.
  Mppi(const RobotProfile& profile, const Params& params, std::uint64_t seed = 0);
  Mppi(const Mppi& other);
  Mppi& operator=(const Mppi& other);
  Mppi(Mppi&&) noexcept;
  Mppi& operator=(Mppi&&) noexcept;
  ~Mppi();

  /// The next command, within the operating limits and within reach of the one before. The plan goes on from period to
  /// period; where one is left out, it starts anew.
  Velocity step(const MppiObservation& seen, const MppiTask& task);

  /// The plan that was followed at `now`, with its samples; empty where none was. They are rolled out once more for
  /// the caller that asks: others do not pay for them, and nothing changes.
  std::optional<SampledPlan> plan(Time now) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe::nav
