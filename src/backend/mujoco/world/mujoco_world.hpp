// MuJoCo as a backend: lockstep, deterministic, saved and restored.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "backend/mujoco/world/mujoco_port.hpp"
#include "backend/mujoco/world/physics.hpp"
#include "backend/mujoco/world/robot.hpp"
#include "threewe/backend/world.hpp"

namespace threewe::backend::mujoco {

/// A scene with one robot.
class MujocoWorld : public World {
 public:
  /// Throws ConfigError for an unknown scene or profile, what cannot be simulated, or a start inside an obstacle.
  explicit MujocoWorld(const WorldOptions& options);
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;

  std::size_t robot_count() const override { return 1; }
  RobotPort& robot(std::size_t index) override;
  Time now() const override { return now_; }
  /// Physics advances in steps of `kStep`; between two of them only the clock moves.
  void advance_to(Time t) override;
  void reset(const ResetOptions& options) override;
  void carry(std::size_t robot, const Pose2D& pose) override;
  /// Connections are not part of what is saved. A saved world fits any other made of the same options.
  std::vector<std::byte> save() const override;
  void restore(const std::vector<std::byte>& state) override;

 private:
  friend class MujocoPort;

  void begin(const ResetOptions& options);
  Pose2D free_pose(const Pose2D& pose, const char* name);

  std::shared_ptr<const scene::Scene> scene_;
  NoiseLevel noise_{};
  RobotModel robot_;
  Physics physics_;
  RobotState state_;
  Time now_{};
  MujocoPort port_;
};

}  // namespace threewe::backend::mujoco
