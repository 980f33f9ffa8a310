#include "autonomous_world.hpp"

#include <string>
#include <utility>

#include "threewe/core/errors.hpp"
#include "threewe/robot/warning.hpp"

namespace threewe {

class AutonomousWorld::Port final : public backend::RobotPort, public ros2::ServedAutonomy {
 public:
  explicit Port(Runtime& robot)
      : robot_(robot), observer_(robot.observe([this](const TickView& view) {
          samples_.insert(samples_.end(), view.samples.begin(), view.samples.end());
        })) {}
  ~Port() override { robot_.unobserve(observer_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  const backend::Features& features() const override { return robot_.features(); }
  const RobotProfile& profile() const override { return robot_.profile(); }
  void connect() override { robot_.connect(); }
  void disconnect() override { robot_.disconnect(); }
  std::vector<Sample> poll() override { return std::exchange(samples_, {}); }
  void command(const Velocity& velocity, Time valid_until) override {
    if (robot_.motion() && velocity == Velocity{}) return;
    if (robot_.motion()) robot_.stop();
    robot_.set_velocity(velocity, valid_until - robot_.world().now());
  }

  std::uint64_t map_version() const override { return robot_.map_version(); }
  map::OccupancyGrid map() const override { return robot_.map(); }
  Pose2D map_from_odom() const override {
    // of the odometry that is published: the wheels alone, where ours has the gyro's headings
    return robot_.pose().map_from_base() * inverse(robot_.odometry().pose);
  }
  std::vector<Vec2> path() const override { return {robot_.path().begin(), robot_.path().end()}; }
  void go_to(const std::string& frame, const Pose2D& pose) override {
    try {
      nav::MoveTo goal{.goal = pose.position()};
      goal.theta = pose.theta;
      goal = robot_.in_map(goal, frame);
      if (robot_.motion()) robot_.stop();
      (void)robot_.start(goal);
    } catch (const ContractError& error) {
      warn(std::string("goal_pose: ") + error.what());
    }
  }

 private:
  Runtime& robot_;
  std::uint64_t observer_;
  std::vector<Sample> samples_;  // since they were fetched
};

AutonomousWorld::AutonomousWorld(std::unique_ptr<backend::World> world)
    : world_(std::make_unique<threewe::World>(std::move(world))) {
  for (std::size_t i = 0; i < world_->robot_count(); ++i) ports_.push_back(std::make_unique<Port>(world_->robot(i)));
}

AutonomousWorld::~AutonomousWorld() = default;

backend::RobotPort& AutonomousWorld::robot(std::size_t index) { return *ports_.at(index); }

std::vector<ros2::ServedAutonomy*> AutonomousWorld::autonomies() {
  std::vector<ros2::ServedAutonomy*> all;
  for (const auto& port : ports_) all.push_back(port.get());
  return all;
}

void AutonomousWorld::advance_to(Time t) {
  while (world_->now() < t) world_->tick();
  (void)world_->take_finished();  // no one waits for them
}

}  // namespace threewe
