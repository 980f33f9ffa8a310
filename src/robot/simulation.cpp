#include "threewe/robot/simulation.hpp"

#include "threewe/core/errors.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe {

const scene::TruthView& Simulation::truth() const { return *world_->robot(robot_).truth(); }

SemanticImage Simulation::look() const {
  const RobotProfile& profile = world_->robot(robot_).profile();
  if (!profile.camera) throw HardwareError("robot '" + profile.name + "' has no sensor 'camera'");
  return look(profile.camera->intrinsics(), true_pose() * profile.camera->base_from_camera,
              profile.camera->mount_height, false);
}

void Simulation::reset(std::optional<std::uint64_t> seed, const std::optional<Pose2D>& pose, std::uint32_t episode) {
  backend::ResetOptions options;
  options.seed = seed.value_or(world_->seed());
  options.episode = episode;
  if (pose) {
    if (!is_finite(*pose)) throw ContractError("pose must be finite");
    for (std::size_t i = 0; i < world_->robot_count(); ++i) {
      options.poses.push_back(i == robot_ ? *pose : world_->robot(i).truth()->start_pose());
    }
  }
  world_->reset(options);
  world_->settle();
}

}  // namespace threewe
