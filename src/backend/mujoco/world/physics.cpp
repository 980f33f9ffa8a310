#include "backend/mujoco/world/physics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "backend/mujoco/world/compile.hpp"
#include "core/exact.hpp"
#include "export/mjcf.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Quaternion;
using exports::Vec3;

constexpr mjtByte kLooking = 5;  // the group of geoms of the robot that looks, which its own rays pass

// Whose friction counts where two geoms touch: a tread's on the floor, that of what stands around on all but casters,
// which slide on anything.
constexpr int kTreadPriority = 2;
constexpr int kObstaclePriority = 3;
constexpr int kCasterPriority = 4;

double yaw(const Quaternion& q) {
  return exact::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

std::vector<exports::PlacedRobot> placed(const sim::Model& world) {
  std::vector<exports::PlacedRobot> robots;
  for (const sim::RobotModel& robot : world.robots) {
    robots.push_back({robot_name(robots.size()), exports::describe(robot.profile), {}});
  }
  return robots;
}

}  // namespace

std::string robot_name(std::size_t robot) { return fmt::format("robot_{}", robot); }

Transform placement(const double* qpos) { return {{qpos[0], qpos[1], qpos[2]}, {qpos[3], qpos[4], qpos[5], qpos[6]}}; }

Physics::Physics(std::shared_ptr<const sim::Model> world) : mj_(library()), world_(std::move(world)) {
  const ErrorsThrown errors;
  const std::vector<exports::PlacedRobot> robots = placed(*world_);
  model_ = {compile(mj_, exports::mjcf(*world_->scene, robots), world_->scene->people), Free{&mj_}};
  data_ = {mj_.mj_makeData(model_.get()), Free{&mj_}};
  substeps_ = static_cast<int>(std::lround(to_seconds(sim::kStep) / model_->opt.timestep));

  for (int geom = 0; geom < model_->ngeom; ++geom) {
    const char* name = mj_.mj_id2name(model_.get(), mjOBJ_GEOM, geom);
    floor_.push_back(name != nullptr && std::string_view(name).starts_with("ground"));
  }
  robot_of_.assign(floor_.size(), -1);
  for (const exports::PlacedRobot& robot : robots) robots_.push_back(find_robot(robot));
  for (const scene::Person& person : world_->scene->people) people_.push_back(find_person(person));
  passages_.resize(robots_.size());
  set_priorities();
  nominal_ = {mj_.mj_copyModel(nullptr, model_.get()), Free{&mj_}};
  for (std::size_t i = 0; i < robots_.size(); ++i) vary(i, {});
}

int Physics::id(mjtObj type, const std::string& name) const { return mj_.mj_name2id(model_.get(), type, name.c_str()); }

Physics::Robot Physics::find_robot(const exports::PlacedRobot& placed) {
  const exports::RobotDescription& description = placed.description;
  Robot robot;
  robot.base = id(mjOBJ_BODY, fmt::format("{}/{}", placed.name, description.base().name));
  robot.bodies = static_cast<int>(description.links.size());
  const int joint = model_->body_jntadr[robot.base];
  robot.qpos = model_->jnt_qposadr[joint];
  robot.dof = model_->jnt_dofadr[joint];
  robot.dofs = 6 + static_cast<int>(description.joints.size());
  const auto readings_of = [&](const char* name) {
    const int sensor = id(mjOBJ_SENSOR, fmt::format("{}/{}", placed.name, name));
    return sensor < 0 ? -1 : model_->sensor_adr[sensor];
  };
  robot.gyro = readings_of("gyro");
  robot.accelerometer = readings_of("accelerometer");
  for (const exports::Joint& wheel : description.joints) {
    if (wheel.kind == exports::Joint::Kind::wheel) robot.wheels.push_back(find_wheel(placed.name + "/" + wheel.child));
  }
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (model_->body_rootid[model_->geom_bodyid[geom]] != robot.base) continue;
    robot.geoms.push_back(geom);
    robot_of_[static_cast<std::size_t>(geom)] = static_cast<int>(robots_.size());
  }
  robot.drive = description.drive;
  robot.friction = description.profile.body.friction;
  robot.track.resize(static_cast<std::size_t>(substeps_) + 1);
  return robot;
}

Physics::Wheel Physics::find_wheel(const std::string& name) const {
  const int hinge = id(mjOBJ_JOINT, name);
  Wheel wheel{model_->jnt_qposadr[hinge], model_->jnt_dofadr[hinge], id(mjOBJ_ACTUATOR, name), {}};
  const int body = model_->jnt_bodyid[hinge];
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    const int of = model_->geom_bodyid[geom];
    const bool felt = model_->geom_contype[geom] != 0 || model_->geom_conaffinity[geom] != 0;
    if (felt && (of == body || model_->body_parentid[of] == body)) wheel.treads.push_back(geom);
  }
  return wheel;
}

Physics::Person Physics::find_person(const scene::Person& person) const {
  const auto mocap = [this](const std::string& name) { return model_->body_mocapid[id(mjOBJ_BODY, name)]; };
  const PersonBodies names = bodies_of(person);
  return {mocap(names.trunk), {mocap(names.legs[0]), mocap(names.legs[1])}};
}

void Physics::set_priorities() {
  for (std::size_t geom = 0; geom < floor_.size(); ++geom) {
    int& priority = model_->geom_priority[geom];
    if (robot_of_[geom] < 0 && !floor_[geom]) priority = kObstaclePriority;
    if (robot_of_[geom] >= 0 && priority > 0) priority = kCasterPriority;
  }
  for (const Robot& robot : robots_) {
    for (const Wheel& wheel : robot.wheels) {
      for (const int tread : wheel.treads) model_->geom_priority[tread] = kTreadPriority;
    }
  }
}

void Physics::set_pose(const Robot& robot, const Pose2D& pose) {
  const auto [sin, cos] = exact::sincos(0.5 * pose.theta);
  const std::array<double, 7> qpos{pose.x, pose.y, 0.0, cos, 0.0, 0.0, sin};
  std::ranges::copy(qpos, data_->qpos + robot.qpos);
}

void Physics::place(std::span<const Pose2D> poses, std::span<const sim::PersonState> people) {
  const ErrorsThrown errors;
  mj_.mj_resetData(model_.get(), data_.get());
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    set_pose(robots_[i], poses[i]);
    std::ranges::fill(robots_[i].track, base(i));
  }
  lead(people);
  mj_.mj_kinematics(model_.get(), data_.get());
}

void Physics::teleport(std::size_t robot, const Pose2D& pose) {
  Robot& carried = robots_[robot];
  set_pose(carried, pose);
  std::fill_n(data_->qvel + carried.dof, carried.dofs, 0.0);
  std::fill_n(data_->qacc_warmstart + carried.dof, carried.dofs, 0.0);
  std::ranges::fill(carried.track, base(robot));
}

// Mass and inertia scale together, and with them all that MuJoCo has worked out from them beforehand. The speed loop
// keeps its time constant whatever it moves.
void Physics::vary(std::size_t robot, const models::Variation& variation) {
  Robot& varied = robots_[robot];
  const double mass = variation.mass;
  for (int body = varied.base; body < varied.base + varied.bodies; ++body) {
    model_->body_mass[body] = mass * nominal_->body_mass[body];
    model_->body_subtreemass[body] = mass * nominal_->body_subtreemass[body];
    for (int i = 3 * body; i < 3 * body + 3; ++i) model_->body_inertia[i] = mass * nominal_->body_inertia[i];
    for (int i = 2 * body; i < 2 * body + 2; ++i) model_->body_invweight0[i] = nominal_->body_invweight0[i] / mass;
  }
  for (int dof = varied.dof; dof < varied.dof + varied.dofs; ++dof) {
    model_->dof_M0[dof] = mass * nominal_->dof_M0[dof];
    model_->dof_invweight0[dof] = nominal_->dof_invweight0[dof] / mass;
  }
  varied.gain = varied.drive.gain * mass / variation.motor_lag;
  varied.wheel_friction = varied.friction * variation.friction;
  set_friction(robot);
}

// What a tread has on the floor beneath its wheel.
void Physics::set_friction(std::size_t robot) {
  const Robot& moving = robots_[robot];
  const Pose2D at = pose(robot);
  for (std::size_t i = 0; i < moving.wheels.size(); ++i) {
    const double friction = moving.wheel_friction * world_->scene->friction_at(at * world_->robots[robot].wheels[i]);
    for (const int tread : moving.wheels[i].treads) model_->geom_friction[std::ptrdiff_t{3} * tread] = friction;
  }
}

void Physics::lead(std::span<const sim::PersonState> people) {
  for (std::size_t i = 0; i < people_.size(); ++i) {
    const scene::Person& person = world_->scene->people[i];
    const auto put = [this](int mocap, Vec2 at) {
      double* position = data_->mocap_pos + std::ptrdiff_t{3} * mocap;
      position[0] = at.x;
      position[1] = at.y;
    };
    put(people_[i].trunk, sim::place_on(person, people[i]).circle.center);
    const std::array<scene::Circle, 2> legs = sim::legs_of(person, people[i]);
    for (std::size_t leg = 0; leg < legs.size(); ++leg) put(people_[i].legs[leg], legs[leg].center);
  }
}

Transform Physics::base(std::size_t robot) const { return placement(data_->qpos + robots_[robot].qpos); }

Pose2D Physics::pose(std::size_t robot) const {
  const auto [position, rotation] = base(robot);
  return {position.x, position.y, yaw(rotation)};
}

Velocity Physics::velocity(std::size_t robot) const {
  const double* v = data_->qvel + robots_[robot].dof;
  const auto [sin, cos] = exact::sincos(pose(robot).theta);
  return {cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[5]};
}

WheelSpeeds Physics::wheel_speeds(std::size_t robot) const {
  WheelSpeeds speeds{};
  const std::vector<Wheel>& wheels = robots_[robot].wheels;
  for (std::size_t i = 0; i < wheels.size(); ++i) speeds[i] = data_->qvel[wheels[i].dof];
  return speeds;
}

std::array<double, 4> Physics::wheel_angles(std::size_t robot) const {
  std::array<double, 4> angles{};
  const std::vector<Wheel>& wheels = robots_[robot].wheels;
  for (std::size_t i = 0; i < wheels.size(); ++i) angles[i] = data_->qpos[wheels[i].qpos];
  return angles;
}

void Physics::look_for(std::size_t robot) {
  for (const int geom : robots_[looking_].geoms) model_->geom_group[geom] = nominal_->geom_group[geom];
  for (const int geom : robots_[robot].geoms) model_->geom_group[geom] = kLooking;
  looking_ = robot;
}

Physics::Hit Physics::cast(const Vec3& from, const Vec3& direction) const {
  std::array<mjtByte, mjNGROUP> groups{};
  groups.fill(1);
  groups[kLooking] = 0;
  const std::array<double, 3> point{from.x, from.y, from.z};
  const std::array<double, 3> along{direction.x, direction.y, direction.z};
  std::array<double, 3> normal{};
  std::array<int, 1> geom{};
  const double distance = mj_.mj_ray(model_.get(), data_.get(), point.data(), along.data(), groups.data(), true, -1,
                                     geom.data(), normal.data());
  return {distance, {normal[0], normal[1], normal[2]}};
}

std::vector<double> Physics::state() const {
  const ErrorsThrown errors;
  std::vector<double> state(static_cast<std::size_t>(mj_.mj_stateSize(model_.get(), mjSTATE_INTEGRATION)));
  mj_.mj_getState(model_.get(), data_.get(), state.data(), mjSTATE_INTEGRATION);
  return state;
}

void Physics::restore(std::span<const double> state) {
  const ErrorsThrown errors;
  if (state.size() != static_cast<std::size_t>(mj_.mj_stateSize(model_.get(), mjSTATE_INTEGRATION))) {
    throw ContractError("restore: these bytes are no saved world");
  }
  mj_.mj_resetData(model_.get(), data_.get());
  mj_.mj_setState(model_.get(), data_.get(), state.data(), mjSTATE_INTEGRATION);
}

}  // namespace threewe::backend::mujoco
