#include "threewe/robot/simulation.hpp"

#include "threewe/core/errors.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe {

namespace {

const scene::TruthView& truth_of(World& world, std::size_t robot) {
  const RobotProfile& profile = world.robot(robot).profile();  // throws where there is none
  if (const backend::TruthService* service = world.truth_service()) return service->truth(robot);
  throw ContractError("robot '" + profile.name + "' is not simulated: on this backend the truth about it is unknown");
}

}  // namespace

Simulation::Simulation(World& world, std::size_t robot)
    : world_(&world), robot_(robot), truth_(&truth_of(world, robot)) {}

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
      options.poses.push_back(i == robot_ ? *pose : world_->truth_service()->truth(i).start_pose());
    }
  }
  world_->reset(options);
  world_->settle();
}

}  // namespace threewe
