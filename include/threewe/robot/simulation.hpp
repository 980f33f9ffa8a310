// Ground truth and reset of one robot in a simulated world: for tests, metrics and training.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "threewe/robot/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe {

/// One robot of a simulated world. All poses are in the scene's frame.
class Simulation {
 public:
  /// Of the robot at that place in a world, which must outlive it. Throws ContractError where it is not simulated.
  Simulation(World& world, std::size_t robot);

  /// The scene it drives in.
  const scene::Scene& scene() const { return truth().scene(); }
  /// Where the robot truly is, in the scene's frame.
  Pose2D true_pose() const { return truth().true_pose(); }
  /// In the body frame.
  Velocity true_velocity() const { return truth().true_velocity(); }
  /// Where the robot stood at the last reset: the origin of its `map` frame, unless it was given a map.
  Pose2D start_pose() const { return truth().start_pose(); }
  /// Where the robot's `map` frame lies in the scene. A given map without an initial pose, of which that is not known,
  /// is taken for one of the scene, origin and all.
  Pose2D scene_from_map() const { return world_->scene_from_map(robot_).value_or(Pose2D{}); }
  /// The fastest approach [m/s] of the robot's own motion into an obstacle since the last reset.
  double max_collision_speed() const { return truth().max_collision_speed(); }
  /// Distance [m] driven since the last reset.
  double distance_driven() const { return truth().distance_driven(); }
  /// The people of the scene, where they are and which way they walk.
  std::vector<scene::PersonPose> people() const { return truth().people(); }
  /// A pose where the robot fits with 5 cm to spare: a pure function of the seed.
  Pose2D sample_free_pose(std::uint64_t seed) const { return truth().sample_free_pose(seed); }
  /// What the robot's camera would truly show now: no noise, no limit to depth, and what each pixel shows. Throws
  /// HardwareError for a robot without a camera.
  SemanticImage look() const;
  /// The same from another camera, at a pose and a height [m] above the floor, that sees the robot too unless it is to
  /// look past it.
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height, bool with_itself = true) const {
    return truth().look(camera, pose, height, with_itself);
  }
  /// Length [m] of the shortest path for the robot's footprint; infinity where there is none.
  double geodesic(Vec2 a, Vec2 b) const { return truth().geodesic(a, b); }

  /// Begins anew at time 0 and waits until every sensor has delivered. Noise is drawn from `seed`, the world's own
  /// without it. The robot starts at `pose`, others where they started before; at the scene's own start poses without
  /// it; people who would begin there begin farther on. Throws ConfigError when that is inside an obstacle.
  /// All noise is that of an `episode` of the seed.
  void reset(std::optional<std::uint64_t> seed = std::nullopt, const std::optional<Pose2D>& pose = std::nullopt,
             std::uint32_t episode = 0);
  /// Teleports the robot to `pose` without its noticing, as a kidnapped robot. Throws ConfigError when something
  /// stands there.
  void teleport(const Pose2D& pose) { world_->teleport(robot_, pose); }
  /// The state of the whole world, see `World::save`.
  std::shared_ptr<const World::Snapshot> save() const { return world_->save(); }
  /// Goes back to a state of this world.
  void restore(const std::shared_ptr<const World::Snapshot>& snapshot) { world_->restore(snapshot); }

  /// All that the simulator knows about the robot.
  const scene::TruthView& truth() const { return *truth_; }
  /// The world that it is in.
  const World& world() const { return *world_; }

 private:
  World* world_;
  std::size_t robot_;
  const scene::TruthView* truth_;
};

}  // namespace threewe
