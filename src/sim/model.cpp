#include "sim/model.hpp"

#include <algorithm>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

int whole_steps(const RobotProfile& profile, const char* field, Duration duration) {
  if (duration.count() % kStep.count() != 0) {
    throw ConfigError(fmt::format("{}: {} of {} s is not a whole number of {} s steps, which this simulator takes",
                                  profile.name, field, to_seconds(duration), to_seconds(kStep)));
  }
  return static_cast<int>(duration / kStep);
}

void require(const RobotProfile& profile, bool ok, const std::string& what) {
  if (!ok) throw ConfigError(fmt::format("{}: {}", profile.name, what));
}

bool same(const scene::Slice& a, const scene::Slice& b) {
  const auto same_segment = [](const scene::Segment& s, const scene::Segment& t) { return s.a == t.a && s.b == t.b; };
  const auto same_circle = [](const scene::Circle& c, const scene::Circle& d) {
    return c.center == d.center && c.radius == d.radius;
  };
  return std::ranges::equal(a.segments, b.segments, same_segment) &&
         std::ranges::equal(a.circles, b.circles, same_circle);
}

// Finding out what can be seen from where takes most of the time of making a model, so that the last few casters are
// kept, and found again by what they were made of.
std::shared_ptr<const RayCaster> find_or_make_caster(scene::Slice slice, double range_max) {
  struct Kept {
    scene::Slice slice;
    std::shared_ptr<const RayCaster> caster;
  };
  constexpr std::size_t kMostKept = 8;
  static std::mutex mutex;
  static std::deque<Kept> kept;

  const std::scoped_lock lock(mutex);
  for (const Kept& old : kept) {
    if (old.caster->range_max() == range_max && same(old.slice, slice)) return old.caster;
  }
  auto caster = std::make_shared<const RayCaster>(slice, range_max);
  kept.push_back({std::move(slice), caster});
  if (kept.size() > kMostKept) kept.pop_front();
  return caster;
}

std::vector<Vec2> wheel_places(const WheelGeometry& wheels) {
  const double x = wheels.half_length;
  const double y = wheels.half_width;
  if (wheels.kinematics == Kinematics::differential) return {{0.0, y}, {0.0, -y}};
  return {{x, y}, {x, -y}, {-x, y}, {-x, -y}};
}

RobotModel make_robot(const scene::Scene& scene, const RobotProfile& profile) {
  RobotModel robot;
  robot.profile = profile;
  robot.drive = models::make_drive(profile, kStep);
  robot.traction_model = models::make_traction_model(profile, kStep);
  robot.battery = models::make_battery(profile.battery);
  robot.odometer = models::make_odometer(profile.odometry, profile.body.wheels);
  robot.wheels = wheel_places(profile.body.wheels);
  robot.body = {profile.body.footprint, profile.body.mass, profile.body.inertia};
  require(profile, robot.body.footprint.corners().size() <= 16, "footprint: at most 16 corners can be simulated");

  constexpr double kFloorClearance = 0.01;  // [m], what lies lower is driven over
  const double fastest = profile.body.no_load_speed * profile.body.wheels.radius;
  const double reach = contact_reach(robot.body.footprint, fastest, profile.hardware_limits.angular, to_seconds(kStep));
  robot.solids = scene.solids_between(kFloorClearance, profile.body.height);
  robot.obstacles = std::make_shared<ShapeIndex>(scene::outlines(robot.solids), reach, 0.125);

  robot.command_latency = whole_steps(profile, "command_latency", profile.command_latency);
  require(profile, robot.command_latency < kMaxLatencySteps,
          fmt::format("command_latency: at most {} s can be simulated", (kMaxLatencySteps - 1) * to_seconds(kStep)));
  robot.odometry_period = whole_steps(profile, "odometry.period", profile.odometry.period);
  if (profile.imu) robot.imu_period = whole_steps(profile, "imu.period", profile.imu->period);
  if (profile.battery) robot.battery_period = whole_steps(profile, "battery.period", profile.battery->period);

  if (profile.camera) {
    require(profile, profile.camera->period >= kStep,
            fmt::format("camera.period: at least {} s can be simulated", to_seconds(kStep)));
  }
  if (profile.ultrasonics) {
    robot.ultrasonic_interval = whole_steps(profile, "ultrasonics.interval", profile.ultrasonics->interval);
    constexpr double kCell = 1.0;  // [m], a quarter of how far they hear
    robot.audible = std::make_shared<ShapeIndex>(scene.at_height(profile.ultrasonics->height),
                                                 profile.ultrasonics->range_max, kCell);
  }
  if (profile.lidar) {
    const LidarSpec& lidar = *profile.lidar;
    robot.turn = whole_steps(profile, "lidar.turn", lidar.turn);
    require(profile, lidar.points_per_turn <= kMaxLidarPoints,
            fmt::format("lidar.points_per_turn: at most {} can be simulated", kMaxLidarPoints));
    require(profile, !lidar.rolling || lidar.points_per_turn % robot.turn == 0,
            fmt::format("lidar.points_per_turn: {} points cannot be spread evenly over the {} steps of a turn",
                        lidar.points_per_turn, robot.turn));
    robot.pattern = models::scan_pattern(lidar);
    robot.caster = find_or_make_caster(scene.at_height(lidar.height), lidar.range_max);
  }
  return robot;
}

}  // namespace

const Renderer& Model::renderer() const {
  std::call_once(asked_, [this] { renderer_.emplace(*scene); });
  return *renderer_;
}

std::shared_ptr<const Model> make_model(std::shared_ptr<const scene::Scene> scene,
                                        const std::vector<RobotProfile>& robots) {
  auto model = std::make_shared<Model>();
  model->scene = std::move(scene);
  for (const RobotProfile& profile : robots) {
    RobotModel robot = make_robot(*model->scene, profile);
    model->robots.push_back(std::move(robot));
  }
  return model;
}

}  // namespace threewe::sim
