#include "backend/mujoco/world/engine.hpp"

#include <algorithm>
#include <utility>

#include "backend/mujoco/world/senses.hpp"
#include "core/exact.hpp"
#include "hardware/limits.hpp"
#include "models/battery.hpp"
#include "models/drive.hpp"

namespace threewe::backend::mujoco {
namespace {

// What the motors are to do: the firmware takes the command that was sent a latency ago, within the hardware limits.
Drive begin_step(const sim::RobotModel& robot, const Velocity& sent, sim::RobotState& state) {
  state.commands[(state.steps + state.command_latency) % sim::kMaxLatencySteps] = sent;
  const Velocity& command = state.commands[state.steps % sim::kMaxLatencySteps];
  const RobotProfile& profile = robot.profile;
  return {wheel_speeds(profile.body.wheels, within_limits(profile.hardware_limits, command)),
          profile.battery ? models::supply_ratio(*profile.battery, state.battery) : 1.0,
          models::motor_shares(state.traction, state.key(Stream::motor), state.steps)};
}

void drain_battery(const sim::RobotModel& robot, const Pose2D& pose, const Velocity& velocity, sim::RobotState& state) {
  // momentum keeps its direction while the body turns beneath it
  const auto [sin, cos] = exact::sincos(state.pose.theta - pose.theta);
  const Velocity carried{cos * state.velocity.vx - sin * state.velocity.vy,
                         sin * state.velocity.vx + cos * state.velocity.vy, state.velocity.omega};
  const Velocity rolling = body_velocity(robot.profile.body.wheels, state.wheel_speeds);
  const double power = models::drive_power(robot.drive, state.traction, carried, velocity, rolling);
  BatterySpec battery = *robot.profile.battery;
  battery.resistance = state.battery_resistance;
  models::drain_battery(battery, power, to_seconds(sim::kStep), state.battery);
}

void arrive(const sim::RobotModel& robot, std::size_t index, const Physics& physics, const Passage& passage,
            sim::RobotState& state) {
  const Pose2D pose = physics.pose(index);
  const Velocity velocity = physics.velocity(index);
  state.wheel_speeds = physics.wheel_speeds(index);
  state.wheel_angles = physics.wheel_angles(index);
  if (robot.profile.battery) drain_battery(robot, pose, velocity, state);
  state.pose = pose;
  state.velocity = velocity;
  state.max_collision_speed = std::max(state.max_collision_speed, passage.approach_speed);
  state.distance_driven += passage.distance_driven;
  ++state.steps;
}

}  // namespace

MujocoEngine::MujocoEngine(std::shared_ptr<const sim::Model> model)
    : model_(std::move(model)), physics_(model_), drawer_(std::make_shared<Drawer>(model_, physics_.model())) {
  for (const sim::RobotModel& robot : model_->robots) {
    beams_.push_back(robot.profile.lidar ? beams_of(*robot.profile.lidar) : std::vector<exports::Vec3>());
  }
  drives_.resize(model_->robots.size());
}

void MujocoEngine::place(std::span<const sim::RobotState> robots, std::span<const sim::PersonState> people) {
  std::vector<Pose2D> poses;
  for (const sim::RobotState& robot : robots) poses.push_back(robot.pose);
  physics_.place(poses, people);
  for (std::size_t i = 0; i < robots.size(); ++i) vary(i, robots[i]);
}

void MujocoEngine::step(std::span<sim::RobotState> robots, std::span<const Velocity> commands,
                        std::span<sim::PersonState> people) {
  sim::walk(*model_, robots, people);
  physics_.lead(people);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    drives_[i] = begin_step(model_->robots[i], commands[i], robots[i]);
  }
  const std::span<const Passage> passages = physics_.step(drives_);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    arrive(model_->robots[i], i, physics_, passages[i], robots[i]);
    sense(model_->robots[i], beams_[i], i, passages[i], physics_, robots[i]);
  }
}

void MujocoEngine::restore(std::span<const double> state, std::span<const sim::RobotState> robots) {
  physics_.restore(state);
  for (std::size_t i = 0; i < robots.size(); ++i) vary(i, robots[i]);
}

Picture MujocoEngine::picture(simulated::WorldCapture capture) const {
  return Picture([drawer = drawer_, taken = std::move(capture)] { return drawer->picture(taken); });
}

SemanticImage MujocoEngine::look(const simulated::WorldCapture& capture, const CameraIntrinsics& camera,
                                 const sim::CameraPose& view, bool with_itself) const {
  return drawer_->look(capture, camera, view, with_itself);
}

}  // namespace threewe::backend::mujoco
