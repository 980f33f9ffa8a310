// How a step of MuJoCo's physics goes, and what is noted of it.
#include <algorithm>

#include <fmt/format.h>

#include "backend/mujoco/world/physics.hpp"
#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {

std::span<const Passage> Physics::step(std::span<const Drive> drives) {
  const ErrorsThrown errors;
  std::ranges::fill(passages_, Passage{});
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].track.front() = base(i);
    if (!world_->scene->patches.empty()) set_friction(i);
  }
  for (int substep = 0; substep < substeps_; ++substep) {
    mj_.mj_step1(model_.get(), data_.get());
    note_contacts();
    for (std::size_t i = 0; i < robots_.size(); ++i) set_motors(robots_[i], drives[i]);
    mj_.mj_step2(model_.get(), data_.get());
    require_sane();
    for (std::size_t i = 0; i < robots_.size(); ++i) note_motion(i, static_cast<std::size_t>(substep));
  }
  return passages_;
}

// The line of `models::drive_motors`: torque falls from stall to nothing at the no-load speed, both in proportion to
// the supply, and the driver's current limit caps all of it. MuJoCo adds the joint's damping to the force that is
// limited here, so that is taken out of the limits.
void Physics::set_motors(const Robot& robot, const Drive& drive) {
  const auto& [unused, stall_torque, motor_damping] = robot.drive;
  for (std::size_t i = 0; i < robot.wheels.size(); ++i) {
    const Wheel& wheel = robot.wheels[i];
    const double share = drive.shares[i];
    const double damping = motor_damping * data_->qvel[wheel.dof];
    const auto limited = [&](double torque) {
      return share * std::clamp(torque, -stall_torque, stall_torque) + damping;
    };
    const double forwards = limited(drive.supply * stall_torque - damping);
    const double backwards = limited(-drive.supply * stall_torque - damping);
    double* range = model_->actuator_forcerange + std::ptrdiff_t{2} * wheel.actuator;
    range[0] = std::min(backwards, forwards);
    range[1] = std::max(backwards, forwards);
    model_->actuator_gainprm[std::ptrdiff_t{mjNGAIN} * wheel.actuator] = share * robot.gain;
    model_->actuator_biasprm[std::ptrdiff_t{mjNBIAS} * wheel.actuator + 2] = motor_damping - share * robot.gain;
    data_->ctrl[wheel.actuator] = drive.setpoints[i];
  }
}

// As contacts are first found: their forces slow robots down in the rest of the step. A robot answers for what its own
// motion adds, and no more than all of it.
void Physics::note_contacts() {
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    std::array<double, 2> own{};  // [m/s] with which each side comes
    bool floor = false;
    for (std::size_t side = 0; side < 2; ++side) {
      const auto geom = static_cast<std::size_t>(contact.geom[side]);
      floor = floor || floor_[geom];
      if (robot_of_[geom] < 0) continue;
      const auto [vx, vy] = velocity_at(robots_[static_cast<std::size_t>(robot_of_[geom])], contact.pos);
      const double along = vx * contact.frame[0] + vy * contact.frame[1];
      own[side] = side == 0 ? along : -along;
    }
    if (floor) continue;
    const double closing = std::max(own[0] + own[1], 0.0);
    for (std::size_t side = 0; side < 2; ++side) {
      const int robot = robot_of_[static_cast<std::size_t>(contact.geom[side])];
      if (robot < 0) continue;
      double& fastest = passages_[static_cast<std::size_t>(robot)].approach_speed;
      fastest = std::max(fastest, std::clamp(own[side], 0.0, closing));
    }
  }
}

// Of a robot where it touches something, along the floor.
Vec2 Physics::velocity_at(const Robot& robot, const double* point) const {
  const double* position = data_->qpos + robot.qpos;
  const double* linear = data_->qvel + robot.dof;
  const double omega = data_->qvel[robot.dof + 5];
  return {linear[0] - omega * (point[1] - position[1]), linear[1] + omega * (point[0] - position[0])};
}

void Physics::note_motion(std::size_t robot, std::size_t substep) {
  Robot& moved = robots_[robot];
  Passage& passage = passages_[robot];
  const double share = 1.0 / substeps_;
  const Transform& before = moved.track[substep];
  const Transform& after = moved.track[substep + 1] = base(robot);
  passage.distance_driven += exact::hypot(after.position.x - before.position.x, after.position.y - before.position.y);
  if (moved.gyro >= 0) passage.yaw_rate += share * data_->sensordata[moved.gyro + 2];
  if (moved.accelerometer >= 0) {
    const double* force = data_->sensordata + moved.accelerometer;
    passage.acceleration = passage.acceleration + share * Vec2{force[0], force[1]};
  }
}

void Physics::require_sane() const {
  for (int kind = 0; kind < mjNWARNING; ++kind) {
    const mjWarningStat& warning = data_->warning[kind];
    if (warning.number == 0) continue;
    throw ContractError(fmt::format("MuJoCo's physics came apart {} s after the start: {}", data_->time,
                                    mj_.mju_warningText(kind, static_cast<std::size_t>(warning.lastinfo))));
  }
}

}  // namespace threewe::backend::mujoco
