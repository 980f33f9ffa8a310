#include "threewe/sim/step.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

#include "sim/crowd.hpp"
#include "threewe/hardware/limits.hpp"
#include "threewe/models/battery.hpp"
#include "threewe/models/ultrasonic.hpp"
#include "threewe/sim/echo.hpp"

namespace threewe::sim {
namespace {

constexpr double kSeconds = 0.01;
static_assert(kSeconds == to_seconds(kStep));

// A robot as a step begins: what its sensors look back on, and where its wheels would take it.
struct Before {
  Pose2D pose;
  Velocity carried;  // its velocity, seen from the heading that the step begins with
  Velocity driven;   // the same after its wheels have pulled, if nothing is in the way
};

// The command that arrives now is the one sent a latency ago; the firmware takes it within the hardware limits.
Velocity deliver_command(const RobotModel& robot, RobotState& state, const Velocity& sent) {
  state.commands[(state.steps + state.command_latency) % kMaxLatencySteps] = sent;
  return within_limits(robot.drive.limits, state.commands[state.steps % kMaxLatencySteps]);
}

double battery_supply(const RobotModel& robot, const RobotState& state) {
  return robot.profile.battery ? models::supply_ratio(*robot.profile.battery, state.battery) : 1.0;
}

// How well the floor holds, as the mean under the driven wheels: they share the weight, and the friction of the whole
// body is what limits its pull. So grip changes wheel by wheel as a robot drives onto ice.
double floor_grip(const Model& model, const RobotModel& robot, const Pose2D& pose) {
  if (model.scene->patches.empty()) return 1.0;
  double sum = 0.0;
  for (const Vec2 wheel : robot.wheels) sum += model.scene->grip_at(pose * wheel);
  return sum / static_cast<double>(robot.wheels.size());
}

// Motors turn the wheels, the wheels pull the body, and the battery pays.
Before drive_robot(const Model& model, const RobotModel& robot, RobotState& state, const Velocity& sent) {
  const models::Drive& drive = robot.drive;
  const Velocity command = deliver_command(robot, state, sent);
  state.wheel_speeds = models::drive_motors(
      drive, state.traction, state.wheel_speeds, wheel_speeds(drive.wheels, command), battery_supply(robot, state),
      models::motor_shares(state.traction, state.key(Stream::motor), state.steps));
  for (std::size_t i = 0; i < 4; ++i) state.wheel_angles[i] += kSeconds * state.wheel_speeds[i];

  // momentum keeps its direction while the body turns beneath it
  const Vec2 linear = rotate({state.velocity.vx, state.velocity.vy}, -kSeconds * state.velocity.omega);
  Before before{state.pose, {linear.x, linear.y, state.velocity.omega}, {}};
  Velocity rolling = body_velocity(drive.wheels, state.wheel_speeds);
  rolling.vy *= state.wheel_errors.lateral;
  before.driven = models::grip(drive, state.traction, before.carried, rolling, floor_grip(model, robot, state.pose));
  if (robot.profile.battery) {
    const double power = models::drive_power(drive, state.traction, before.carried, before.driven, rolling);
    BatterySpec spec = *robot.profile.battery;
    spec.resistance = state.battery_resistance;
    models::drain_battery(spec, power, kSeconds, state.battery);
  }
  return before;
}

// The world holds the body back.
Motion slide(const RobotModel& robot, const Before& before, std::span<const scene::Circle> legs) {
  return move(robot.body, *robot.obstacles, {{}, legs}, before.pose, before.driven, before.carried, kSeconds);
}

void arrive(RobotState& state, const Motion& motion) {
  state.distance_driven += distance(state.pose.position(), motion.pose.position());
  state.pose = motion.pose;
  state.velocity = motion.velocity;
  if (motion.approach_speed > state.max_collision_speed) state.max_collision_speed = motion.approach_speed;
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

// The share of a turn that a step sweeps, from the poses in between; or the whole turn at its end.
void sweep_lidar(const RobotModel& robot, Others& others, const Pose2D& before, RobotState& state) {
  const LidarSpec& lidar = *robot.profile.lidar;
  const auto points = static_cast<std::uint64_t>(lidar.points_per_turn);
  const auto turn = static_cast<std::uint64_t>(robot.turn);
  const std::uint64_t within = (state.steps - 1) % turn;
  if (!lidar.rolling && within + 1 < turn) return;

  const std::uint64_t share = lidar.rolling ? points / turn : points;
  const std::uint64_t first = lidar.rolling ? within * share : 0;
  const std::span<float> ranges = std::span(state.lidar_points).subspan(first, share);
  const double angle = robot.pattern.first_angle + static_cast<double>(first) * robot.pattern.angle_step;
  const Pose2D end = state.pose * lidar.base_from_lidar;
  const Pose2D begin = lidar.rolling ? before * lidar.base_from_lidar : end;
  robot.caster->cast_rolling(begin, end, angle, robot.pattern.angle_step, ranges, others.at(lidar.height));

  const std::uint64_t turns = (state.steps - 1) / turn;
  models::measure_ranges(lidar, state.key(Stream::lidar), state.lidar_bias, turns * points + first, ranges);
}

// One sensor's ping, heard at once: sound takes 12 ms for 2 m and back, in which a robot moves by no more than 6 mm.
void ping(const RobotModel& robot, std::size_t sensor, Others& others, RobotState& state) {
  const UltrasonicSpec& spec = *robot.profile.ultrasonics;
  const Pose2D pose = state.pose * spec.mounts[sensor].base_from_ultrasonic;
  const SoundCone cone{pose, spec.field_of_view, spec.max_incidence, spec.range_max};
  const double echo = nearest_echo(cone, *robot.audible, others.at(spec.height)).range;

  RngKey key = state.key(Stream::ultrasonic);
  key.sensor = static_cast<std::uint16_t>(sensor);
  const std::uint64_t pings = state.steps / static_cast<std::uint64_t>(robot.ultrasonic_interval);
  state.ultrasonic_range = models::measure_range(spec, key, (pings - 1) / spec.mounts.size(), echo);
}

void sense(const RobotModel& robot, const Sensing& sensing, Others& others, const Before& before, RobotState& state) {
  if (sensing.imu && imu_ready(robot, state)) {
    const Vec2 acceleration =
        (1.0 / kSeconds) * Vec2{state.velocity.vx - before.carried.vx, state.velocity.vy - before.carried.vy};
    state.imu = models::measure_imu(*robot.profile.imu, state.key(Stream::imu), state.velocity.omega, acceleration,
                                    state.imu_state);
  }
  if (sensing.odometry && odometry_ready(robot, state)) {
    models::measure_odometry(robot.profile.odometry, robot.drive.wheels, state.wheel_errors, state.wheel_angles,
                             state.odometry);
  }
  if (sensing.ultrasonics) {
    if (const auto sensor = ping_ready(robot, state)) ping(robot, *sensor, others, state);
  }
  if (sensing.lidar && robot.caster) sweep_lidar(robot, others, before.pose, state);
}

// People walk; robots drive, push one another, and slide along what stands there, all at once; then all of them look.
void step_crowd(const World& crowd) {
  const auto& [model_pointer, world, commands, people, sensing] = crowd;
  const Model& model = *model_pointer;
  walk(model, world, people);
  const std::vector<scene::Circle> circles = circles_of(model, people);
  const std::vector<scene::Circle> legs = legs_of(model, people);
  std::vector<Before> before;
  std::vector<Mover> movers;
  for (std::size_t i = 0; i < world.size(); ++i) {
    before.push_back(drive_robot(model, model.robots[i], world[i], commands[i]));
    movers.push_back(
        {&model.robots[i].body, before[i].pose, before[i].carried, before[i].driven, 0.0, world[i].variation.mass});
  }
  exchange_momentum(movers, kSeconds);

  std::vector<Motion> motions;
  std::vector<Pose2D> moved;
  for (std::size_t i = 0; i < world.size(); ++i) {
    before[i].driven = movers[i].velocity;
    motions.push_back(slide(model.robots[i], before[i], legs));
    motions[i].approach_speed = std::max(motions[i].approach_speed, movers[i].approach_speed);
    moved.push_back(motions[i].pose);
  }
  const std::vector<bool> stays = must_stay(movers, moved);
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (stays[i]) motions[i] = {before[i].pose, {}, true, motions[i].approach_speed};
    arrive(world[i], motions[i]);
  }
  for (std::size_t i = 0; i < world.size(); ++i) {
    Others others(model, world, i, circles, legs);
    sense(model.robots[i], sensing, others, before[i], world[i]);
  }
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
  state.variation = variation;
  state.traction = models::make_traction(profile, kStep, variation);
  state.command_latency = varied_latency(made.command_latency, variation.command_latency);
  state.wheel_errors =
      models::draw_wheel_errors(profile.odometry, state.key(Stream::odometry), variation.odometry_slip);
  if (profile.battery) {
    BatterySpec battery = *profile.battery;
    battery.resistance = state.battery_resistance = variation.battery_resistance * battery.resistance;
    state.battery = models::start_battery(battery, variation.battery_charge);
  }
  if (profile.imu) state.imu_state = models::start_imu(*profile.imu, state.key(Stream::imu));
  if (profile.lidar) state.lidar_bias = models::lidar_bias(*profile.lidar, state.key(Stream::lidar));
  return state;
}

void step(std::span<const World> worlds) {
  Others nobody;
  for (const World& world : worlds) {
    const Model& model = *world.model;
    assert(world.robots.size() == model.robots.size() && world.commands.size() == model.robots.size());
    assert(world.people.empty() || world.people.size() == model.scene->people.size());
    if (world.robots.size() > 1 || !world.people.empty()) {
      step_crowd(world);
      continue;
    }
    const RobotModel& robot = model.robots[0];
    RobotState& state = world.robots[0];
    const Before before = drive_robot(model, robot, state, world.commands[0]);
    arrive(state, slide(robot, before, {}));
    sense(robot, world.sensing, nobody, before, state);
  }
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
                      {}});
  }
  step(worlds);
}

bool imu_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.imu_period, state); }
bool odometry_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.odometry_period, state); }
bool battery_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.battery_period, state); }

std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state) {
  if (!is_due(robot.ultrasonic_interval, state)) return std::nullopt;
  const std::uint64_t pings = state.steps / static_cast<std::uint64_t>(robot.ultrasonic_interval);
  return (pings - 1) % robot.profile.ultrasonics->mounts.size();
}

bool scan_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.turn, state); }

std::span<const float> scan_points(const RobotModel& robot, const RobotState& state) {
  return std::span(state.lidar_points).first(static_cast<std::size_t>(robot.profile.lidar->points_per_turn));
}

}  // namespace threewe::sim
