#include "threewe/robot/robot.hpp"

#include <cmath>
#include <utility>

#include "threewe/core/errors.hpp"
#include "threewe/map/ros_map.hpp"

namespace threewe {
namespace {

// [ns] from what a user gave in seconds. Three years are as good as for ever, and nanoseconds still hold them.
Duration duration(double seconds, const char* what) {
  constexpr double kLongest = 1e8;
  if (std::isfinite(seconds) && seconds >= 0.0 && seconds <= kLongest) return from_seconds(seconds);
  throw ContractError(std::string(what) + " must lie in [0, 1e8] s, not " + std::to_string(seconds));
}

std::optional<Duration> timeout_of(const std::optional<double>& seconds) {
  return seconds ? std::optional(duration(*seconds, "timeout")) : std::nullopt;
}

}  // namespace

Robot::Robot() : Robot(Options{}) {}

Robot::Robot(const Options& options) : owned_(std::make_unique<World>(options)) {
  world_ = owned_.get();
  runtime_ = &world_->robot(0);
  if (world_->truth_service() != nullptr) simulation_.emplace(*world_, 0);
  connect();
}

Robot::Robot(World& world, std::size_t index) : world_(&world), runtime_(&world.robot(index)) {
  if (world_->truth_service() != nullptr) simulation_.emplace(world, index);
  connect();
}

Robot::~Robot() = default;

void Robot::connect() {
  runtime_->connect();
  world_->wait(runtime_->ready());
}

void Robot::disconnect() { runtime_->disconnect(); }

const LaserScan& Robot::get_lidar_scan() const { return runtime_->lidar_scan(); }
const IMUData& Robot::get_imu() const { return runtime_->imu(); }
Pose2D Robot::get_pose() const { return runtime_->pose().map_from_base(); }
const Odometry& Robot::get_odometry() const { return runtime_->odometry(); }
bool Robot::lost() const { return runtime_->pose().lost(); }
Velocity Robot::get_velocity() const { return runtime_->pose().velocity; }
const map::OccupancyGrid& Robot::get_map() const { return runtime_->map(); }
void Robot::save_map(const std::filesystem::path& yaml) const { map::save_ros_map(get_map(), yaml); }
const BatteryState& Robot::get_battery_state() const { return runtime_->battery(); }
const RGBDImage& Robot::get_image(std::string_view camera) const { return runtime_->image(camera); }
const RGBDImage& Robot::get_rgbd_image() const { return runtime_->rgbd_image(); }
std::map<std::string, RangeData> Robot::get_ultrasonic_ranges() const { return runtime_->ultrasonic_ranges(); }

Pose2D Robot::get_transform(std::string_view target, std::string_view source) const {
  return runtime_->transform(target, source);
}

void Robot::set_velocity(double vx, double vy, double omega, double hold, bool creep_mode) {
  runtime_->set_velocity({vx, vy, omega}, duration(hold, "hold"), creep_mode);
}

Velocity Robot::execute_action(const std::array<double, 3>& action, double period) {
  world_->wait(runtime_->execute_action(action, duration(period, "period")));
  return runtime_->commanded().command;
}

void Robot::stop() { runtime_->stop(); }

MotionHandle Robot::move_to(double x, double y) { return move_to(x, y, MoveOptions{}); }

MotionHandle Robot::move_to(double x, double y, const MoveOptions& options) {
  const nav::MoveTo goal{.goal = {x, y},
                         .theta = options.theta,
                         .tolerance = options.tolerance,
                         .angle_tolerance = options.angle_tolerance};
  return runtime_->start(runtime_->in_map(goal, options.frame), timeout_of(options.timeout));
}

MotionHandle Robot::move_forward(double distance, double tolerance, std::optional<double> timeout) {
  return runtime_->start(nav::MoveForward{distance, tolerance}, timeout_of(timeout));
}

MotionHandle Robot::rotate(double angle, double angle_tolerance, std::optional<double> timeout) {
  return runtime_->start(nav::Rotate{angle, angle_tolerance}, timeout_of(timeout));
}

MotionHandle Robot::follow_path(const std::vector<Vec2>& path, double tolerance, std::optional<double> timeout) {
  return runtime_->start(nav::FollowPath{path, tolerance}, timeout_of(timeout));
}

MotionHandle Robot::follow_waypoints(const std::vector<nav::MoveTo>& waypoints, std::optional<double> timeout) {
  return runtime_->start(nav::FollowWaypoints{waypoints}, timeout_of(timeout));
}

ExplorationHandle Robot::explore(std::optional<double> timeout, bool thorough) {
  return {runtime_->start(nav::Explore{thorough}, timeout_of(timeout))};
}

MoveResult Robot::wait(const MotionHandle& motion, const OnProgress& on_progress) {
  drive(motion, on_progress);
  return motion->result();
}

ExploreResult Robot::wait(const ExplorationHandle& exploration, const OnProgress& on_progress) {
  drive(exploration.motion, on_progress);
  return exploration.motion->explore_result();
}

void Robot::drive(const MotionHandle& motion, const OnProgress& on_progress) {
  constexpr Duration kTold = 100ms;
  if (!on_progress) return world_->wait(motion);
  Time due = now() + kTold;
  const std::uint64_t observer = runtime_->observe([&](const TickView& view) {
    if (view.now < due) return;
    due = view.now + kTold;
    on_progress(motion->progress());
  });
  try {
    world_->wait(motion);
  } catch (...) {
    runtime_->unobserve(observer);
    motion->cancel();
    world_->wait(motion);  // it has ended: no later wait returns it again
    throw;
  }
  runtime_->unobserve(observer);
}

void Robot::sleep(double seconds) {
  const WaitHandle wait = world_->sleep(duration(seconds, "sleep"));
  try {
    world_->wait(wait);
  } catch (...) {
    world_->forget(wait);
    throw;
  }
}

void Robot::thinking(double seconds, const std::function<void()>& work) {
  const Duration charge = duration(seconds, "thinking");
  world_->open_hold();
  try {
    work();
  } catch (...) {
    world_->forget(world_->close_hold(Duration::zero()));
    throw;
  }
  world_->wait(world_->close_hold(charge));
}

void Robot::emergency_stop() { runtime_->estop(); }
void Robot::release_emergency_stop() { runtime_->release_estop(); }
Simulation* Robot::simulation() { return simulation_ ? &*simulation_ : nullptr; }

}  // namespace threewe
