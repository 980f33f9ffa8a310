// Approach prediction: what comes nearer, bearing by bearing, at where it will be when the robot has stopped.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "safety/gate.hpp"
#include "safety/params.hpp"
#include "safety/unseen.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// What never changes while a robot runs.
struct ApproachModel {
  Params::Approach params;
  std::size_t youngest = 0;      ///< scans before the newest that is not too young to compare with, if none is lost
  std::size_t oldest = 0;        ///< the same of one that is not too old
  std::vector<Vec2> directions;  ///< of the beams, in the lidar's frame
  double range_min = 0.0;        ///< [m] of the lidar
  double body_from_lidar = 0.0;  ///< [m] from the lidar to where the margin ends, at most
  double until_next = 0.0;       ///< [s] from a scan until the next one has been seen
  double body = 0.0;             ///< [m] nothing is predicted nearer to the base
  double reaction = 0.0;         ///< [s]
  double linear = 0.0;           ///< [m/s] operating limit
  double acceleration = 0.0;     ///< [m/s^2]
  double braking = 0.0;          ///< [m/s^2]
};
ApproachModel make_approach_model(const RobotProfile& profile, const GateModel& gate);

/// Something that comes nearer, whatever it is: where a beam met it, and how fast it came.
struct Approaching {
  Vec2 position;       ///< [m] in `odom`
  double speed = 0.0;  ///< [m/s] towards the lidar
  friend bool operator==(const Approaching&, const Approaching&) = default;
};

/// What approaches by the newest scan. Plain data.
///
/// A hit came nearer where two earlier scans, a third of a second ago and less, looked farther along its bearing and
/// next to it. So a third of a second is enough, where to know a person takes a second, and nothing needs to be known
/// of what it is.
class Approach {
 public:
  static constexpr std::size_t kMost = 48;  ///< hits; of more, the nearest

  /// Nothing has been seen yet.
  void forget();
  /// The newest scan and those before it, once it was added to them; `last` is the newest command.
  void update(const ApproachModel& model, const Sight& sight, const Velocity& last);
  std::span<const Approaching> approaching() const { return approaching_; }
  /// Appends where these will be when the robot, which is at `robot` and was commanded `last`, has come to a stop: two
  /// robots that meet would each stop short of where the other was.
  void append_predicted(const ApproachModel& model, const Velocity& last, Vec2 robot, Time now,
                        std::vector<Vec2>& points) const;

 private:
  void put(const Approaching& hit, Vec2 lidar);

  std::optional<Time> seen_;
  std::vector<Approaching> approaching_;  // room is taken when something first approaches: it seldom does
};

}  // namespace threewe::safety
