// World whose robots have autonomy stacks, as a world of the backend contract: for what serves simulated robots.
#pragma once

#include <memory>
#include <vector>

#include "ros2/serve.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/robot/robot.hpp"

namespace threewe {

/// Velocities that a port is commanded pass the safety gate. They end a motion, but for those that are zero:
/// teleoperation sends these all the time.
class AutonomousWorld final : public backend::World {
 public:
  /// Of a simulated world.
  explicit AutonomousWorld(std::unique_ptr<backend::World> world);
  ~AutonomousWorld() override;

  /// Of each robot; they live as long as this.
  std::vector<ros2::ServedAutonomy*> autonomies();

  std::size_t robot_count() const override { return world_->robot_count(); }
  backend::RobotPort& robot(std::size_t index) override;
  const backend::TruthService* truth_service() const override { return world_->truth_service(); }
  Time now() const override { return world_->now(); }
  void advance_to(Time t) override;

 private:
  class Port;
  std::unique_ptr<threewe::World> world_;
  std::vector<std::unique_ptr<Port>> ports_;
};

}  // namespace threewe
