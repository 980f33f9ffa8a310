#include "threewe/env/robot/robot_env.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "env/checks.hpp"
#include "env/episodes.hpp"
#include "env/exclusive_use.hpp"
#include "env/observations.hpp"
#include "env/robot/places.hpp"
#include "hardware/turn.hpp"
#include "sim/model.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe::env {

struct RobotEnv::Impl {
  Impl(Options wanted, const World::Options& robot, const std::vector<std::string>& scenes);

  void begin(const Reset& reset);
  void drive(std::span<const float> asked);
  void end_step();
  void observe();
  void fail_if_broken() const;

  std::span<const float> cast_rays(const Pose2D& lidar);
  std::span<const std::int16_t> look();
  std::span<const float> newest_scan();
  void copy_picture(std::span<std::byte> color, std::span<std::byte> depth) const;
  task::Belief belief();

  Runtime& robot() { return places[info.scene].robot(); }
  const Runtime& robot() const { return places[info.scene].robot(); }
  const scene::TruthView& truth() const { return places[info.scene].truth(); }

  // never changes
  std::vector<RobotPlace> places;
  Options options;
  std::unique_ptr<task::Task> task;
  std::vector<std::string> metric_names;
  std::vector<bool> task_fields;  // which of the task's fields are wanted
  models::Variation variation;

  // the episode
  EpisodeInfo info;
  bool begun = false;
  bool over = false;
  std::atomic<bool> busy{};
  Velocity action;  // in force

  // what the last call came to
  double reward = 0.0;
  std::uint8_t terminated = 0;
  std::uint8_t truncated = 0;
  std::vector<double> metrics;
  std::array<double, 3> true_pose{};
  double scan_age = 0.0;
  std::vector<Array> observations;

  // working memory
  std::vector<float> rays;  // noise-free, as many as the task reads
  std::vector<float> scan;
  SemanticImage seen;
};

RobotEnv::Impl::Impl(Options wanted, const World::Options& robot, const std::vector<std::string>& scenes)
    : places(make_robot_places(wanted, robot, scenes)) {
  wanted.hardware = hardware_of(places.front(), robot.robots.front());
  wanted.randomization = models::load_randomization(robot.randomization);
  wanted.scenes.clear();
  task::Scenes tables;
  for (const RobotPlace& place : places) {
    wanted.scenes.push_back(place.scene);
    tables.push_back(place.tables);
  }
  options = checked(std::move(wanted));
  task = options.task({tables, 1, 1, options.hardware, options.control_period});
  rays.resize(rays_of(*task, options.hardware));
  if (!rays.empty()) {
    for (RobotPlace& place : places) place.caster = sim::make_model(place.scene, {options.hardware})->robots[0].caster;
  }
  metric_names = task->metrics();
  metrics.resize(metric_names.size());
  const std::vector<task::Field> fields = observation_fields(options, task->fields());
  task_fields = which_are_among(fields, task->fields());
  observations = make_arrays(fields, 1);
}

// An episode begins with fresh minds and at a stand-still, when each sensor has delivered.
void RobotEnv::Impl::begin(const Reset& reset) {
  const EpisodeInfo next = next_episode(begun ? &info : nullptr, reset, places.size());
  over = true;  // until the robot is there
  Pose2D start;
  task->begin(0, {next.scene, next.seed, next.episode}, reset.request, {&start, 1});
  info = next;
  begun = true;
  action = {};
  reward = 0.0;
  terminated = truncated = 0;
  variation = models::draw_variation(options.randomization, info.seed, info.episode, 0);

  robot().connect();
  places[info.scene].world->reset({.seed = info.seed, .poses = {start}, .episode = info.episode});
  places[info.scene].world->settle();
  fail_if_broken();
  over = false;
}

void RobotEnv::Impl::drive(std::span<const float> asked) {
  const auto share = [&](std::size_t axis) { return std::clamp(double{asked[axis]}, -1.0, 1.0); };
  action = {share(0), share(1), share(2)};
  over = true;  // unless it gets there
  const bool sideways = options.hardware.kinematics() == Kinematics::holonomic;
  places[info.scene].world->wait(
      robot().execute_action({action.vx, sideways ? action.vy : 0.0, action.omega}, options.control_period));
  fail_if_broken();
}

void RobotEnv::Impl::end_step() {
  task::TaskState now;
  now.pose = now.lidar = truth().true_pose();
  now.action = action;
  now.distance_driven = truth().distance_driven();
  now.max_collision_speed = truth().max_collision_speed();
  const task::FrameIds looks = [this] { return look(); };
  now.look = &looks;
  if (options.hardware.lidar) now.lidar = now.pose * options.hardware.lidar->base_from_lidar;
  if (!rays.empty()) now.ranges = cast_rays(now.lidar);
  task::Outcome outcome;
  task->step(0, {&now, 1}, {&outcome, 1});

  ++info.steps;
  reward = outcome.reward;
  terminated = outcome.terminated ? 1 : 0;
  truncated = !outcome.terminated && info.steps >= options.max_steps ? 1 : 0;
  over = terminated != 0 || truncated != 0;
}

void RobotEnv::Impl::observe() {
  const task::Belief belief = this->belief();
  task->update(0, belief);
  auto array = observations.begin();
  const auto next = [&](bool wanted) { return wanted ? (array++)->row(0) : std::span<std::byte>(); };
  const auto color = next(options.observed.image);
  const auto depth = next(options.observed.depth);
  copy_picture(color, depth);
  put_scan(belief.scan, next(options.observed.lidar));
  const Pose2D& pose = belief.map_from_base;
  put({pose.x, pose.y, pose.theta}, next(options.observed.pose));
  const Velocity& velocity = robot().pose().velocity;
  put({velocity.vx, velocity.vy, velocity.omega}, next(options.observed.velocity));
  std::array<std::span<std::byte>, kMostTaskFields> fields;
  for (std::size_t field = 0; field < task_fields.size(); ++field) fields[field] = next(task_fields[field]);
  task->observe(0, 0, belief, std::span(fields).first(task_fields.size()));

  const Pose2D truly = truth().true_pose();
  true_pose = {truly.x, truly.y, truly.theta};
  task->measure(0, metrics);
}

task::Belief RobotEnv::Impl::belief() {
  task::Belief belief;
  belief.map_from_base = robot().pose().map_from_base();
  if (!robot().features().has(SensorType::lidar)) return belief;
  const LidarSpec& lidar = *options.hardware.lidar;
  belief.scan = newest_scan();
  belief.base_from_lidar = lidar.base_from_lidar;
  belief.range_max = lidar.range_max;
  return belief;
}

// Counter-clockwise from the robot's back, wherever the backend's scans begin.
std::span<const float> RobotEnv::Impl::newest_scan() {
  const Sample& sample = robot().sample(SensorType::lidar);
  const auto& newest = std::get<LaserScan>(sample.data);
  scan_age =
      to_seconds(places[info.scene].world->now() - end_of_turn(*options.hardware.lidar, newest, sample.measured));
  scan = newest.ranges;
  const auto first = static_cast<std::ptrdiff_t>(
      std::floor(wrap_angle(-exact::kPi - newest.angle_min) / newest.angle_increment + 0.5));
  const auto beams = static_cast<std::ptrdiff_t>(scan.size());
  std::ranges::rotate(scan, scan.begin() + ((first % beams) + beams) % beams);
  return scan;
}

void RobotEnv::Impl::copy_picture(std::span<std::byte> color, std::span<std::byte> depth) const {
  const auto copy = []<typename T>(const std::vector<T>& from, std::span<std::byte> to) {
    std::memcpy(to.data(), from.data(), to.size());
  };
  if (!color.empty()) copy(robot().image().color, color);
  if (!depth.empty()) copy(robot().rgbd_image().depth, depth);
}

// Noise-free rays from where the lidar really is, among what stands there and nothing that moves.
std::span<const float> RobotEnv::Impl::cast_rays(const Pose2D& lidar) {
  places[info.scene].caster->cast(lidar, 0.0, 2.0 * exact::kPi / static_cast<double>(rays.size()), rays);
  return rays;
}

// What the robot's camera truly shows now.
std::span<const std::int16_t> RobotEnv::Impl::look() {
  if (!options.hardware.camera) return {};
  const CameraSpec& camera = *options.hardware.camera;
  seen = truth().look(camera.intrinsics(), truth().true_pose() * camera.base_from_camera, camera.mount_height, false);
  return seen.ids;
}

void RobotEnv::Impl::fail_if_broken() const {
  if (!robot().fault().empty()) {
    throw ConnectionError(
        fmt::format("robot '{}' failed: {}; reset() connects it again", robot().profile().name, robot().fault()));
  }
}

RobotEnv::RobotEnv(Options options, const World::Options& robot, const std::vector<std::string>& scenes)
    : impl_(std::make_unique<Impl>(std::move(options), robot, scenes)) {}
RobotEnv::~RobotEnv() = default;

const Options& RobotEnv::options() const { return impl_->options; }

void RobotEnv::reset(const Reset& reset) {
  const ExclusiveUse use(impl_->busy, "reset");
  if (!impl_->begun && !reset.seed) throw ContractError("reset: the first episode needs a seed");
  if (reset.scene && *reset.scene >= impl_->places.size()) {
    throw ContractError(fmt::format("reset: there is no scene {}, only {}", *reset.scene, impl_->places.size()));
  }
  impl_->begin(reset);
  impl_->observe();
}

void RobotEnv::step(std::span<const float> action) {
  const ExclusiveUse use(impl_->busy, "step");
  check_actions(action, 1);
  if (!impl_->begun) throw ContractError("step() before the first reset()");
  if (impl_->over) throw ContractError("step(): the episode of environment 0 is over; reset it first");
  impl_->drive(action);
  impl_->end_step();
  impl_->observe();
}

std::span<const Array> RobotEnv::observations() const { return impl_->observations; }
std::span<const double> RobotEnv::rewards() const { return {&impl_->reward, 1}; }
std::span<const std::uint8_t> RobotEnv::terminated() const { return {&impl_->terminated, 1}; }
std::span<const std::uint8_t> RobotEnv::truncated() const { return {&impl_->truncated, 1}; }
const std::vector<std::string>& RobotEnv::metric_names() const { return impl_->metric_names; }
std::span<const double> RobotEnv::metrics() const { return impl_->metrics; }
std::span<const double> RobotEnv::true_poses() const { return impl_->true_pose; }
std::span<const double> RobotEnv::scan_ages() const { return {&impl_->scan_age, 1}; }
EpisodeInfo RobotEnv::episode(std::size_t world) const {
  check_place(world, 1);
  const ExclusiveUse use(impl_->busy, "episode");
  return impl_->info;
}

std::string RobotEnv::instruction(std::size_t world) const {
  check_place(world, 1);
  const ExclusiveUse use(impl_->busy, "instruction");
  if (!impl_->begun) throw ContractError("instruction() before the first reset()");
  return impl_->task->instruction(0);
}

std::string RobotEnv::instruction_name() const { return impl_->task->instruction_name(); }

models::Variation RobotEnv::variation(std::size_t world, std::size_t robot) const {
  check_place(world, 1, robot, 1);
  const ExclusiveUse use(impl_->busy, "variation");
  return impl_->variation;
}

World& RobotEnv::world(std::size_t scene) {
  check_place(scene, impl_->places.size());
  return *impl_->places[scene].world;
}

TopView RobotEnv::top_view(std::size_t world) const {
  check_place(world, 1);
  const ExclusiveUse use(impl_->busy, "top_view");
  if (!impl_->begun) throw ContractError("there is nothing to see before the first reset()");
  TopView view;
  const Pose2D pose = impl_->truth().true_pose();
  view.robots.push_back(pose);
  const Pose2D base_from_odom = inverse(impl_->robot().pose().odom_from_base);
  view.hits.push_back(transformed(pose * base_from_odom, impl_->robot().obstacles()));
  for (const scene::PersonPose& person : impl_->truth().people()) {
    view.people.push_back({person.pose.position(), person.radius});
  }
  view.task = impl_->task->debug_overlay(0);
  return view;
}

}  // namespace threewe::env
