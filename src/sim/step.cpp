#include "sim/step.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <hwy/cache_control.h>

#include "models/ultrasonic.hpp"
#include "sim/drive_kernel.hpp"
#include "sim/multi_body_contact.hpp"
#include "sim/sonar_return.hpp"

namespace threewe::sim {
namespace {

constexpr double kSeconds = 0.01;
static_assert(kSeconds == to_seconds(kStep));

// Worlds that are driven at a time: their states stay in the nearest cache until the step ends.
constexpr std::size_t kAtATime = 16;

// How well the floor holds, as the mean under the driven wheels: they share the weight, and the friction of the whole
// body is what limits its pull. So grip changes wheel by wheel as a robot drives onto ice.
double floor_friction_at(const scene::Scene& scene, const RobotModel& robot, const Pose2D& pose) {
  double sum = 0.0;
  for (const Vec2 wheel : robot.wheels) sum += scene.friction_at(pose * wheel);
  return sum / static_cast<double>(robot.wheels.size());
}

// A robot as a step begins. The command that arrives now is the one sent a latency ago.
inline void begin_step(const Model& model, const RobotModel& robot, RobotState& state, const Velocity& sent,
                       kernel::Driver& driver) {
  state.commands[(state.steps + state.command_latency) % kMaxLatencySteps] = sent;
  driver.robot = &robot;
  driver.state = &state;
  driver.command = &state.commands[state.steps % kMaxLatencySteps];
  driver.floor = model.scene->patches.empty() ? 1.0 : floor_friction_at(*model.scene, robot, state.pose);
}

void arrive(RobotState& state, const Motion& motion) {
  state.distance_driven += distance(state.pose.position(), motion.pose.position());
  state.pose = motion.pose;
  state.velocity = motion.velocity;
  if (motion.approach_speed > state.max_collision_speed) state.max_collision_speed = motion.approach_speed;
  ++state.steps;
}

// Where nothing stands near.
void arrive(RobotState& state, const kernel::Driven& driven) {
  state.pose = driven.pose();
  state.velocity = driven.velocity();
  state.distance_driven = driven.distance_driven;
  ++state.steps;
}

// The other robots of a world, and the people in it, for one robot.
class Others {
 public:
  Others() = default;  // it is alone
  Others(const Model& model, std::span<const RobotState> world, std::size_t robot,
         std::span<const scene::Circle> people, std::span<const scene::Circle> legs)
      : model_(&model), world_(world), robot_(robot), people_(people), legs_(legs) {}

  // Their outlines as high as `height` [m], where they are now. Valid until the next call.
  MovingShapes at(double height) {
    segments_.clear();
    for (std::size_t i = 0; i < world_.size(); ++i) {
      if (i != robot_ && model_->robots[i].profile.body.height > height) add_outline(i);
    }
    if (height < kKneeHeight) return {segments_, legs_};
    return {segments_, height < kPersonHeight ? people_ : std::span<const scene::Circle>()};
  }

 private:
  void add_outline(std::size_t robot) {
    const auto& corners = model_->robots[robot].body.footprint.corners();
    const Pose2D& pose = world_[robot].pose;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      segments_.push_back({pose * corners[i], pose * corners[(i + 1) % corners.size()], -1});
    }
  }

  const Model* model_ = nullptr;
  std::span<const RobotState> world_;
  std::size_t robot_ = 0;
  std::span<const scene::Circle> people_;
  std::span<const scene::Circle> legs_;
  std::vector<scene::Segment> segments_;
};

// The share of a turn that a step, counted from 1, sweeps between two poses; or the whole turn at its end.
void sweep_lidar(const RobotModel& robot, const RobotState& state, std::uint64_t step, const Pose2D& before,
                 const Pose2D& after, const MovingShapes& moving, double reach, std::span<float> points_of_turn) {
  const LidarSpec& lidar = *robot.profile.lidar;
  const auto points = static_cast<std::uint64_t>(lidar.points_per_turn);
  const auto turn = static_cast<std::uint64_t>(robot.turn);
  const std::uint64_t within = (step - 1) % turn;
  const std::uint64_t share = lidar.rolling ? points / turn : points;
  const std::uint64_t first = lidar.rolling ? within * share : 0;
  const std::span<float> ranges = points_of_turn.subspan(first, share);
  const double angle = robot.pattern.first_angle + static_cast<double>(first) * robot.pattern.angle_step;
  const Pose2D end = after * lidar.base_from_lidar;
  const Pose2D begin = lidar.rolling ? before * lidar.base_from_lidar : end;
  robot.caster->cast_rolling(begin, end, angle, robot.pattern.angle_step, ranges, moving, reach);

  const std::uint64_t turns = (step - 1) / turn;
  models::measure_ranges(lidar, state.key(Stream::lidar), state.lidar_bias, turns * points + first, ranges,
                         state.variation);
}

// One sensor's ping, heard at once: sound takes 12 ms for 2 m and back, in which a robot moves by no more than 6 mm.
void ping(const RobotModel& robot, std::size_t sensor, Others& others, RobotState& state) {
  const UltrasonicSpec& spec = *robot.profile.ultrasonics;
  const Pose2D pose = state.pose * spec.mounts[sensor].base_from_ultrasonic;
  const SonarCone cone{pose, spec.field_of_view, spec.max_incidence, spec.range_max};
  const double echo = nearest_sonar_return(cone, *robot.audible, others.at(spec.height)).range;

  RngKey key = state.key(Stream::ultrasonic);
  key.sensor = static_cast<std::uint16_t>(sensor);
  const std::uint64_t pings = state.steps / static_cast<std::uint64_t>(robot.ultrasonic_interval);
  state.ultrasonic_range = models::measure_range(spec, key, (pings - 1) / spec.mounts.size(), echo);
}

void sense(const RobotModel& robot, const Sensing& sensing, Others& others, const Pose2D& before,
           const Velocity& carried, RobotState& state) {
  if (sensing.imu && imu_ready(robot, state)) {
    const Vec2 acceleration = (1.0 / kSeconds) * Vec2{state.velocity.vx - carried.vx, state.velocity.vy - carried.vy};
    state.imu = models::measure_imu(*robot.profile.imu, state.key(Stream::imu), state.velocity.omega, acceleration,
                                    state.imu_state, state.variation);
  }
  if (sensing.ultrasonics) {
    if (const auto sensor = ping_ready(robot, state)) ping(robot, *sensor, others, state);
  }
  if (sensing.lidar && robot.caster && (robot.profile.lidar->rolling || scan_ready(robot, state))) {
    sweep_lidar(robot, state, state.steps, before, state.pose, others.at(robot.profile.lidar->height),
                sensing.lidar_reach, state.lidar_points);
  }
}

// What a robot's lidar needs to look again later.
void keep_path(std::span<Pose2D> path, const Pose2D& before, const RobotState& state) {
  const std::size_t within = (state.steps - 1) % (path.size() - 1);
  if (within == 0) path[0] = before;
  path[within + 1] = state.pose;
}

bool is_any_on(const Sensing& sensing) { return sensing.lidar || sensing.imu || sensing.ultrasonics; }

// People walk; robots drive, push one another, and slide along what stands there, all at once; then all of them look.
void step_crowd(const World& crowd) {
  const auto& [model_pointer, world, commands, people, sensing, path] = crowd;
  const Model& model = *model_pointer;
  walk(model, world, people);
  const std::vector<scene::Circle> circles = circles_of(model, people);
  const std::vector<scene::Circle> legs = legs_of(model, people);
  std::vector<kernel::Driver> drivers(world.size());
  for (std::size_t i = 0; i < world.size(); ++i) {
    begin_step(model, model.robots[i], world[i], commands[i], drivers[i]);
  }
  std::vector<kernel::Driven> driven(world.size());
  kernel::drive(drivers, driven);
  std::vector<Mover> movers;
  for (std::size_t i = 0; i < world.size(); ++i) {
    movers.push_back({&model.robots[i].body, world[i].pose, driven[i].carried(), driven[i].velocity(), 0.0,
                      world[i].variation.mass});
  }
  exchange_momentum(movers, kSeconds);

  std::vector<Motion> motions;
  std::vector<Pose2D> moved;
  for (std::size_t i = 0; i < world.size(); ++i) {
    motions.push_back(move(model.robots[i].body, *model.robots[i].obstacles, {{}, legs}, movers[i].pose,
                           movers[i].velocity, movers[i].carried, kSeconds));
    motions[i].approach_speed = std::max(motions[i].approach_speed, movers[i].approach_speed);
    moved.push_back(motions[i].pose);
  }
  const std::vector<bool> stays = must_stay(movers, moved);
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (stays[i]) motions[i] = {movers[i].pose, {}, true, motions[i].approach_speed};
    arrive(world[i], motions[i]);
  }
  for (std::size_t i = 0; i < world.size(); ++i) {
    Others others(model, world, i, circles, legs);
    sense(model.robots[i], sensing, others, movers[i].pose, movers[i].carried, world[i]);
  }
  const auto reads_nothing = [&](const kernel::Driver& driver) {
    return !sensing.odometry || !odometry_ready(*driver.robot, *driver.state);
  };
  std::erase_if(drivers, reads_nothing);
  kernel::measure_odometry(drivers);
}

// Brings what a drive needs of a state into the nearest cache, ahead of time.
void fetch(const World& world) {
  constexpr std::size_t kLine = 64;
  const auto* state = reinterpret_cast<const std::byte*>(world.robots.data());
  for (std::size_t line = 0; line < offsetof(RobotState, variation); line += kLine) hwy::Prefetch(state + line);
}

// Worlds of one robot each, without people; at most kAtATime.
void step_singles(std::span<const World* const> worlds) {
  std::array<kernel::Driver, kAtATime> drivers;
  std::array<kernel::Driven, kAtATime> driven;
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const World& world = *worlds[i];
    begin_step(*world.model, world.model->robots[0], world.robots[0], world.commands[0], drivers[i]);
  }
  kernel::drive(std::span(drivers).first(worlds.size()), std::span(driven).first(worlds.size()));

  Others none;
  std::size_t reading = 0;  // their encoders now; they come first among the drivers
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const RobotModel& robot = *drivers[i].robot;
    RobotState& state = *drivers[i].state;
    const Pose2D before = state.pose;
    const Velocity carried = driven[i].carried();
    if (robot.obstacles->near(before.position()).empty()) {
      arrive(state, driven[i]);
    } else {
      arrive(state,
             move(robot.body, *robot.obstacles, {}, before, driven[i].velocity(), carried, kSeconds, driven[i].pose()));
    }
    if (!worlds[i]->path.empty()) keep_path(worlds[i]->path, before, state);
    if (is_any_on(worlds[i]->sensing)) sense(robot, worlds[i]->sensing, none, before, carried, state);
    if (worlds[i]->sensing.odometry && odometry_ready(robot, state)) drivers[reading++] = drivers[i];
  }
  kernel::measure_odometry(std::span(drivers).first(reading));
}

// [steps]; what a state has no room for is cut off.
std::uint64_t varied_latency(int steps, double factor) {
  const double varied = std::floor(factor * steps + 0.5);
  return static_cast<std::uint64_t>(std::clamp(varied, 0.0, kMaxLatencySteps - 1.0));
}

bool is_due(int period, const RobotState& state) {
  return period > 0 && state.steps > 0 && state.steps % static_cast<std::uint64_t>(period) == 0;
}

}  // namespace

RobotState begin(const Model& model, std::size_t robot, const Pose2D& pose, std::uint64_t seed, std::uint32_t episode,
                 const models::Variation& variation) {
  const RobotModel& made = model.robots[robot];
  const RobotProfile& profile = made.profile;
  RobotState state;
  state.seed = seed;
  state.episode = episode;
  state.robot = static_cast<std::uint32_t>(robot);
  state.start = pose;
  state.pose = pose;
  vary(made, variation, state);
  state.command_latency = varied_latency(made.command_latency, variation.command_latency);
  state.wheel_errors =
      models::draw_wheel_errors(profile.odometry, state.key(Stream::odometry), variation.odometry_slip);
  if (profile.battery) {
    BatterySpec battery = *profile.battery;
    battery.resistance = state.battery_resistance;
    state.battery = models::start_battery(battery, variation.battery_charge);
  }
  if (profile.imu) state.imu_state = models::start_imu(*profile.imu, state.key(Stream::imu));
  if (profile.lidar) state.lidar_bias = models::lidar_bias(*profile.lidar, state.key(Stream::lidar));
  return state;
}

void vary(const RobotModel& robot, const models::Variation& variation, RobotState& state) {
  state.variation = variation;
  state.traction = models::make_traction(robot.profile, kStep, variation);
  if (robot.profile.battery) {
    state.battery_resistance = variation.battery_resistance * robot.profile.battery->resistance;
  }
}

Duration varied_latency(Duration latency, const models::Variation& variation) {
  const double varied = variation.sensor_latency * static_cast<double>(latency.count());
  return static_cast<Duration::rep>(std::floor(varied / static_cast<double>(kStep.count()) + 0.5)) * kStep;
}

void step(std::span<const World> worlds, int steps) {
  std::array<const World*, kAtATime> singles;
  std::size_t count = 0;
  const auto step_those = [&] {
    for (int i = 0; i < steps; ++i) step_singles(std::span(singles).first(count));
    count = 0;
  };
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const World& world = worlds[i];
    assert(world.robots.size() == world.model->robots.size() && world.commands.size() == world.robots.size());
    assert(world.people.empty() || world.people.size() == world.model->scene->people.size());
    if (i + kAtATime < worlds.size()) fetch(worlds[i + kAtATime]);
    if (world.robots.size() > 1 || !world.people.empty()) {
      for (int k = 0; k < steps; ++k) step_crowd(world);
      continue;
    }
    singles[count++] = &world;
    if (count == kAtATime) step_those();
  }
  step_those();
}

void step(const Model& model, std::span<RobotState> states, std::span<const Velocity> commands,
          std::span<PersonState> people) {
  const std::size_t robots = model.robots.size();
  const std::size_t walkers = people.empty() ? 0 : model.scene->people.size();
  assert(states.size() % robots == 0 && states.size() == commands.size());
  assert(people.size() * robots == states.size() * walkers);
  std::vector<World> worlds;
  worlds.reserve(states.size() / robots);
  for (std::size_t i = 0; i < states.size() / robots; ++i) {
    worlds.push_back({&model,
                      states.subspan(i * robots, robots),
                      commands.subspan(i * robots, robots),
                      people.subspan(i * walkers, walkers),
                      {},
                      {}});
  }
  step(worlds);
}

bool imu_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.imu_period, state); }
bool odometry_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.odometry_period, state); }
bool battery_ready(const RobotModel& robot, const RobotState& state) {
  const auto period = static_cast<std::uint64_t>(robot.battery_period);
  return period > 0 && state.steps > 0 && (state.steps - 1) % period == 0;
}

std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state) {
  if (!is_due(robot.ultrasonic_interval, state)) return std::nullopt;
  const std::uint64_t pings = state.steps / static_cast<std::uint64_t>(robot.ultrasonic_interval);
  return (pings - 1) % robot.profile.ultrasonics->mounts.size();
}

bool scan_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.turn, state); }

std::span<const float> scan_points(const RobotModel& robot, const RobotState& state) {
  return std::span(state.lidar_points).first(static_cast<std::size_t>(robot.profile.lidar->points_per_turn));
}

void retake_scan(const RobotModel& robot, const RobotState& state, std::uint64_t turn, std::span<const Pose2D> path,
                 double reach, std::span<float> points) {
  const std::size_t steps = path.size() - 1;
  assert(std::cmp_equal(steps, robot.turn) && std::cmp_equal(points.size(), robot.profile.lidar->points_per_turn));
  for (std::size_t i = robot.profile.lidar->rolling ? 0 : steps - 1; i < steps; ++i)
    sweep_lidar(robot, state, turn * steps + i + 1, path[i], path[i + 1], {}, reach, points);
}

}  // namespace threewe::sim
