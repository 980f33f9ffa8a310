#include "benchmark/drive.hpp"

#include "robot/runtime_state.hpp"
#include "task/contact_count.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe::benchmark {
namespace {

const scene::TruthView& truth_of(const backend::TruthService* service) {
  if (service != nullptr) return service->truth(0);
  throw ContractError("the backend does not state where its robot truly is: its drives cannot be scored");
}

}  // namespace

int contacts(const Drive& drive, const scene::SceneTables& tables) {
  task::ContactCount count;
  for (const Pose2D& pose : drive.poses) count = advance(count, tables.clearance(pose));
  return count.contacts;
}

void TrueDrive::add(const Velocity& command) {
  drive_.commands.push_back(command);
  drive_.poses.push_back(truth().true_pose());
  drive_.length = truth().distance_driven();
  drive_.collision_speed = truth().max_collision_speed();
}

DriveLog::DriveLog(threewe::World& world) : world_(&world), truth_(&truth_of(world.truth_service())) {
  observer_ = world.robot(0).observe([this](const TickView& tick) {
    if (tick.now <= last_) drive_ = {};
    last_ = tick.now;
    add(tick.commanded.command);
  });
}

DriveLog::~DriveLog() { end(); }

void DriveLog::end() {
  if (!ended_) world_->robot(0).unobserve(observer_);
  ended_ = true;
}

Replay::Replay(const std::string& backend, const backend::WorldOptions& options, std::span<const Velocity> commands)
    : world_(backend::make_world(backend, options)) {
  backend::RobotPort& port = world_->robot(0);
  port.connect();
  for (const Velocity& command : commands) {
    port.command(command, world_->now() + kCommandLifetime);
    world_->advance_to(world_->now() + kControlPeriod);
    (void)port.poll();
    add(command);
  }
}

const scene::TruthView& Replay::truth() const { return truth_of(world_->truth_service()); }

}  // namespace threewe::benchmark
