#include "backend/mujoco/world/physics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/export/mjcf.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Quaternion;
using exports::Vec3;

constexpr const char* kRobot = "robot";
constexpr mjtByte kOwnGroup = 5;  // of the robot's geoms, which its own rays pass

double yaw(const Quaternion& q) {
  return exact::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

}  // namespace

Physics::Physics(const scene::Scene& scene, const RobotProfile& profile) : mj_(library()) {
  const exports::PlacedRobot robot{kRobot, exports::describe(profile), {}};
  stall_torque_ = robot.description.drive.stall_torque;
  motor_damping_ = robot.description.drive.damping;

  compile(exports::mjcf(scene, {&robot, 1}));
  find_parts();
  for (const exports::Joint& joint : robot.description.joints) {
    if (joint.kind != exports::Joint::Kind::wheel) continue;
    const std::string name = fmt::format("{}/{}", kRobot, joint.child);
    const int hinge = id(mjOBJ_JOINT, name);
    wheels_.push_back({model_->jnt_qposadr[hinge], model_->jnt_dofadr[hinge], id(mjOBJ_ACTUATOR, name)});
  }

  substeps_ = static_cast<int>(std::lround(to_seconds(kStep) / model_->opt.timestep));
  track_.resize(static_cast<std::size_t>(substeps_) + 1);
  place({});
}

void Physics::compile(const std::string& xml) {
  const auto fail = [](const char* what) { throw ConfigError(fmt::format("MuJoCo refuses the model: {}", what)); };
  std::array<char, 1000> error{};
  mjSpec* spec = mj_.mj_parseXMLString(xml.c_str(), nullptr, error.data(), error.size());
  if (spec == nullptr) fail(error.data());
  const auto discard = [this](mjSpec* read) { mj_.mj_deleteSpec(read); };
  const std::unique_ptr<mjSpec, decltype(discard)> owner(spec, discard);
  delete_rangefinders(spec);
  model_ = {mj_.mj_compile(spec, nullptr), Free{&mj_}};
  if (!model_) fail(mj_.mjs_getError(spec));
  // what has come apart is told to the user, not silently put back to the start
  model_->opt.disableflags |= mjDSBL_AUTORESET;
  data_ = {mj_.mj_makeData(model_.get()), Free{&mj_}};
}

// They would look in each of MuJoCo's steps, where our ultrasonic sensors cast rays when they ping.
void Physics::delete_rangefinders(mjSpec* spec) const {
  std::vector<mjsElement*> rangefinders;
  for (mjsElement* sensor = mj_.mjs_firstElement(spec, mjOBJ_SENSOR); sensor != nullptr;
       sensor = mj_.mjs_nextElement(spec, sensor)) {
    if (mj_.mjs_asSensor(sensor)->type == mjSENS_RANGEFINDER) rangefinders.push_back(sensor);
  }
  for (mjsElement* rangefinder : rangefinders) mj_.mjs_delete(spec, rangefinder);
}

int Physics::id(mjtObj type, const std::string& name) const { return mj_.mj_name2id(model_.get(), type, name.c_str()); }

void Physics::find_parts() {
  const int base = id(mjOBJ_BODY, fmt::format("{}/base_link", kRobot));
  const int joint = model_->body_jntadr[base];
  qpos_ = model_->jnt_qposadr[joint];
  dof_ = model_->jnt_dofadr[joint];
  const auto readings_of = [this](const char* name) {
    const int sensor = id(mjOBJ_SENSOR, fmt::format("{}/{}", kRobot, name));
    return sensor < 0 ? -1 : model_->sensor_adr[sensor];
  };
  gyro_ = readings_of("gyro");
  accelerometer_ = readings_of("accelerometer");

  for (int geom = 0; geom < model_->ngeom; ++geom) {
    const bool own = model_->body_rootid[model_->geom_bodyid[geom]] == base;
    const char* name = mj_.mj_id2name(model_.get(), mjOBJ_GEOM, geom);
    of_robot_.push_back(own);
    floor_.push_back(name != nullptr && std::string_view(name).starts_with("ground"));
    if (own) model_->geom_group[geom] = kOwnGroup;
  }
}

void Physics::set_pose(const Pose2D& pose) {
  const auto [sin, cos] = exact::sincos(0.5 * pose.theta);
  const std::array<double, 7> qpos{pose.x, pose.y, 0.0, cos, 0.0, 0.0, sin};
  std::ranges::copy(qpos, data_->qpos + qpos_);
}

void Physics::place(const Pose2D& pose) {
  mj_.mj_resetData(model_.get(), data_.get());
  set_pose(pose);
  std::ranges::fill(track_, base());
}

void Physics::carry(const Pose2D& pose) {
  set_pose(pose);
  std::fill_n(data_->qvel, model_->nv, 0.0);
  std::fill_n(data_->qacc_warmstart, model_->nv, 0.0);
  std::ranges::fill(track_, base());
}

std::optional<std::string> Physics::find_collision(const Pose2D& pose) {
  const std::vector<double> before = state();
  mj_.mj_resetData(model_.get(), data_.get());
  set_pose(pose);
  mj_.mj_fwdPosition(model_.get(), data_.get());
  std::optional<std::string> found;
  for (int i = 0; i < data_->ncon && !found; ++i) {
    const mjContact& contact = data_->contact[i];
    const int other = of_robot_[static_cast<std::size_t>(contact.geom[0])] ? contact.geom[1] : contact.geom[0];
    if (is_obstacle(other)) found = mj_.mj_id2name(model_.get(), mjOBJ_GEOM, other);
  }
  restore(before);
  return found;
}

Passage Physics::step(const WheelSpeeds& setpoints, double supply) {
  Passage passage;
  const double share = 1.0 / substeps_;
  track_.front() = base();
  for (int i = 0; i < substeps_; ++i) {
    mj_.mj_step1(model_.get(), data_.get());
    passage.approach_speed = std::max(passage.approach_speed, approach_speed());
    set_motors(setpoints, supply);
    mj_.mj_step2(model_.get(), data_.get());
    require_sane();

    const Transform& before = track_[static_cast<std::size_t>(i)];
    const Transform& after = track_[static_cast<std::size_t>(i) + 1] = base();
    passage.distance_driven += exact::hypot(after.position.x - before.position.x, after.position.y - before.position.y);
    if (gyro_ >= 0) passage.yaw_rate += share * data_->sensordata[gyro_ + 2];
    if (accelerometer_ >= 0) {
      const double* force = data_->sensordata + accelerometer_;
      passage.acceleration = passage.acceleration + share * Vec2{force[0], force[1]};
    }
  }
  return passage;
}

// The line of `models::drive_motors`: torque falls from stall to nothing at the no-load speed, both in proportion to
// the supply, and the driver's current limit caps all of it. MuJoCo adds the joint's damping to the force that is
// limited here, so that is taken out of the limits.
void Physics::set_motors(const WheelSpeeds& setpoints, double supply) {
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    const double damping = motor_damping_ * data_->qvel[wheel.dof];
    const auto limited = [this](double torque) { return std::clamp(torque, -stall_torque_, stall_torque_); };
    mjtNum* range = model_->actuator_forcerange + static_cast<std::ptrdiff_t>(2) * wheel.actuator;
    range[0] = limited(-supply * stall_torque_ - damping) + damping;
    range[1] = limited(supply * stall_torque_ - damping) + damping;
    data_->ctrl[wheel.actuator] = setpoints[i];
  }
}

// As contacts are first found: their forces slow the robot down in the rest of the step.
double Physics::approach_speed() const {
  double fastest = 0.0;
  const double* position = data_->qpos + qpos_;
  const double* linear = data_->qvel + dof_;
  const double omega = data_->qvel[dof_ + 5];
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    const bool first = of_robot_[static_cast<std::size_t>(contact.geom[0])];
    if (!is_obstacle(contact.geom[first ? 1 : 0])) continue;
    const double vx = linear[0] - omega * (contact.pos[1] - position[1]);
    const double vy = linear[1] + omega * (contact.pos[0] - position[0]);
    const double along = vx * contact.frame[0] + vy * contact.frame[1];
    fastest = std::max(fastest, first ? along : -along);
  }
  return fastest;
}

void Physics::require_sane() const {
  for (const mjtWarning kind : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data_->warning[kind].number > 0) {
      throw ContractError(fmt::format("MuJoCo's physics came apart {} s after the start", data_->time));
    }
  }
}

Transform Physics::base() const {
  const double* q = data_->qpos + qpos_;
  return {{q[0], q[1], q[2]}, {q[3], q[4], q[5], q[6]}};
}

Pose2D Physics::pose() const {
  const auto [position, rotation] = base();
  return {position.x, position.y, yaw(rotation)};
}

Velocity Physics::velocity() const {
  const double* v = data_->qvel + dof_;
  const auto [sin, cos] = exact::sincos(pose().theta);
  return {cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[5]};
}

WheelSpeeds Physics::wheel_speeds() const {
  WheelSpeeds speeds{};
  for (std::size_t i = 0; i < wheels_.size(); ++i) speeds[i] = data_->qvel[wheels_[i].dof];
  return speeds;
}

std::array<double, 4> Physics::wheel_angles() const {
  std::array<double, 4> angles{};
  for (std::size_t i = 0; i < wheels_.size(); ++i) angles[i] = data_->qpos[wheels_[i].qpos];
  return angles;
}

Physics::Hit Physics::cast(const Vec3& from, const Vec3& direction) const {
  std::array<mjtByte, mjNGROUP> groups{};
  groups.fill(1);
  groups[kOwnGroup] = 0;
  const std::array<double, 3> point{from.x, from.y, from.z};
  const std::array<double, 3> along{direction.x, direction.y, direction.z};
  std::array<double, 3> normal{};
  std::array<int, 1> geom{};
  const double distance = mj_.mj_ray(model_.get(), data_.get(), point.data(), along.data(), groups.data(), true, -1,
                                     geom.data(), normal.data());
  return {distance, {normal[0], normal[1], normal[2]}};
}

std::size_t Physics::state_size() const {
  return static_cast<std::size_t>(mj_.mj_stateSize(model_.get(), mjSTATE_INTEGRATION));
}

std::vector<double> Physics::state() const {
  std::vector<double> state(state_size());
  mj_.mj_getState(model_.get(), data_.get(), state.data(), mjSTATE_INTEGRATION);
  return state;
}

void Physics::restore(std::span<const double> state) {
  mj_.mj_resetData(model_.get(), data_.get());
  mj_.mj_setState(model_.get(), data_.get(), state.data(), mjSTATE_INTEGRATION);
}

}  // namespace threewe::backend::mujoco
