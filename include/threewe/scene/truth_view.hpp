// Ground truth of one robot in a simulated world. Robots never see it; tests, metrics and rewards do.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "threewe/core/camera.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::scene {

class Scene;

/// Where a person of the scene is, and which way they walk or wait to walk.
struct PersonPose {
  std::string name;     ///< as in the scene
  Pose2D pose;          ///< in the scene's frame
  double radius = 0.0;  ///< [m] of the circle that they fill on the floor
  friend bool operator==(const PersonPose&, const PersonPose&) = default;
};

/// Ground truth of one robot in a simulated world. All poses are in the scene's frame.
class TruthView {
 public:
  virtual ~TruthView() = default;

  /// The scene it drives in.
  virtual const Scene& scene() const = 0;
  /// Where the robot truly is.
  virtual Pose2D true_pose() const = 0;
  /// How fast it truly moves, in the body frame.
  virtual Velocity true_velocity() const = 0;
  /// Where the robot stood at the last reset: the origin of its `map` frame, unless it was given a map.
  virtual Pose2D start_pose() const = 0;
  /// The fastest approach [m/s] of the robot's own motion into an obstacle at contact since the last reset.
  virtual double max_collision_speed() const = 0;
  /// Distance [m] driven since the last reset.
  virtual double distance_driven() const = 0;
  /// The people of the scene, in its order.
  virtual std::vector<PersonPose> people() const = 0;
  /// A pose where the footprint and 5 cm around it are free: a pure function of the seed.
  virtual Pose2D sample_free_pose(std::uint64_t seed) const = 0;
  /// What a level camera at a pose and a height [m] above the floor would truly show now, with or without the robot
  /// itself.
  virtual SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                             bool with_itself) const = 0;
  /// Range [m] of a perfect beam that leaves `pose` along its heading, `height` [m] above the floor, to the scene's
  /// walls and furniture: people and robots are left out. Infinity where there is nothing.
  virtual double range(const Pose2D& pose, double height) const = 0;
  /// Length [m] of the shortest path for the robot's footprint; infinity where there is none.
  virtual double geodesic(Vec2 a, Vec2 b) const = 0;
};

}  // namespace threewe::scene
