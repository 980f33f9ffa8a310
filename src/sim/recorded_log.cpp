#include "sim/recorded_log.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "core/config.hpp"
#include "core/exact.hpp"
#include "core/rng.hpp"
#include "models/lidar.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

// A robot as large as a Pioneer 2, kept a hand's breadth away from things.
constexpr double kHalfWidth = 0.25;  // [m]
constexpr double kHeight = 0.5;      // [m]
constexpr double kTrack = 0.40;      // [m] between its wheels
constexpr double kSpeed = 0.5;       // [m/s]
constexpr double kTurnRate = 0.7;    // [rad/s]
constexpr double kLookAhead = 0.4;   // [m] along its way
constexpr Duration kStep = 50ms;

constexpr double kScanDistance = 0.5;  // [m]
constexpr double kScanTurn = 1.0 / 3;  // [rad]

// Wheels: sizes and track are not what the odometer takes them for (the two systematic errors of J. Borenstein, L.
// Feng: Measurement and correction of systematic odometry errors in mobile robots. IEEE Trans. Robotics and Automation
// 12 (6), 1996), and they slip. The figures are estimates, such that headings come out about as wrong as in the log of
// the Intel Research Lab (D. Haehnel, 2003): by 2.6 degrees for each 0.66 m, the median against what GMapping made of
// it.
constexpr double kWheelScale = 0.01;  // each wheel's size is off by a share in +- this
constexpr double kTrackScale = 0.05;  // the track too
constexpr double kSlip = 0.02;        // [m/sqrt(m)] of each wheel

// SICK LMS 200, technical description: 180 degrees, 1 degree a beam, +-15 mm systematic and 5 mm statistical error up
// to 8 m, more beyond: 10 mm here. 80 m is where its centimetre mode ends. Logs of 180 beams dropped the last.
LidarSpec sick() {
  LidarSpec spec;
  spec.base_from_lidar = {0.10, 0.0, 0.0};
  spec.height = 0.35;
  spec.beams = 180;
  spec.range_max = 80.0;
  spec.sigma = 0.010;
  spec.bias = 0.015;
  return spec;
}

// The way from stop to stop, by the shortest paths.
std::vector<Vec2> way_through(const LogSpec& log) {
  const auto scene = std::make_shared<const scene::Scene>(log.scene);
  const scene::SceneTables tables(scene, Footprint::rectangle(2 * kHalfWidth, 2 * kHalfWidth), kHeight);
  std::vector<Vec2> way = {log.scene.starts.front().position()};
  for (const Vec2 stop : log.stops) {
    if (distance(way.back(), stop) < 0.01) continue;
    const std::vector<Vec2> leg = tables.geodesic_field(stop).path_from(way.back());
    if (leg.empty()) {
      throw ConfigError(fmt::format("log {}: no way from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) for a robot {} m wide",
                                    log.name, way.back().x, way.back().y, stop.x, stop.y, 2 * kHalfWidth));
    }
    way.insert(way.end(), leg.begin() + 1, leg.end());
  }
  return way;
}

// A carrot that moves ahead of the robot along its way (R. Wallace et al.: First results in robot road-following,
// 1985).
class Carrot {
 public:
  explicit Carrot(const std::vector<Vec2>& way) : way_(way), at_(way.front()) {}

  bool at_end() const { return next_ == way_.size(); }
  Vec2 place() const { return at_; }
  void keep_ahead_of(Vec2 robot) {
    while (!at_end() && distance(robot, at_) < kLookAhead) {
      const double left = distance(at_, way_[next_]);
      if (left > kStride) {
        at_ = at_ + (kStride / left) * (way_[next_] - at_);
      } else {
        at_ = way_[next_++];
      }
    }
  }

 private:
  static constexpr double kStride = 0.02;  // [m]
  const std::vector<Vec2>& way_;
  std::size_t next_ = 1;
  Vec2 at_;
};

// Towards a place: turning first, when it lies to the side.
Velocity steer(const Pose2D& robot, Vec2 place) {
  const Vec2 there = inverse(robot) * place;
  const double bearing = exact::atan2(there.y, there.x);
  const double ahead = std::max(0.0, 1.0 - std::fabs(bearing) / 0.9);
  return {kSpeed * ahead, 0.0, std::clamp(2.5 * bearing, -kTurnRate, kTurnRate)};
}

// What wheel encoders make of a motion.
class Wheels {
 public:
  explicit Wheels(std::uint64_t seed) : slip_{.seed = seed, .stream = Stream::odometry} {
    RngKey episode = slip_;
    episode.stream = Stream::episode;
    const auto draw = [&](std::uint64_t i, double most) { return 1.0 + uniform(episode, i, 0, -most, most); };
    left_ = draw(0, kWheelScale);
    right_ = draw(1, kWheelScale);
    track_ = kTrack * draw(2, kTrackScale);
  }

  Pose2D odometry() const { return odom_from_base_; }
  void roll(const Velocity& v, double seconds) {
    const double left = measured(left_, (v.vx - 0.5 * kTrack * v.omega) * seconds, 0);
    const double right = measured(right_, (v.vx + 0.5 * kTrack * v.omega) * seconds, 1);
    ++steps_;
    odom_from_base_ = integrate(odom_from_base_, {0.5 * (left + right), 0.0, (right - left) / track_}, 1.0);
  }

 private:
  double measured(double scale, double rolled, std::uint32_t wheel) const {
    return scale * rolled + kSlip * exact::sqrt(std::fabs(rolled)) * normal(slip_, steps_, wheel);
  }

  RngKey slip_;
  double left_ = 1.0;
  double right_ = 1.0;
  double track_ = kTrack;
  std::uint64_t steps_ = 0;
  Pose2D odom_from_base_;
};

class Scanner {
 public:
  Scanner(const scene::Scene& scene, std::uint64_t seed)
      : slice_(scene.at_height(spec_.height)),
        key_{.seed = seed, .stream = Stream::lidar},
        bias_(models::lidar_bias(spec_, key_)) {}

  LaserScan look(const Pose2D& scene_from_base) {
    const Pose2D lidar = scene_from_base * spec_.base_from_lidar;
    const auto beams = static_cast<std::size_t>(spec_.beams);
    LaserScan scan{-0.5 * exact::kPi, exact::kPi / spec_.beams, 0.0, spec_.range_min, spec_.range_max, {}};
    for (std::size_t i = 0; i < beams; ++i) {
      const double angle = lidar.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      scan.ranges.push_back(static_cast<float>(scene::cast_ray(slice_, lidar.position(), angle, spec_.range_max)));
    }
    models::measure_ranges(spec_, key_, bias_, taken_ * beams, scan.ranges);
    ++taken_;
    return scan;
  }

 private:
  LidarSpec spec_ = sick();
  scene::Slice slice_;
  RngKey key_;
  double bias_;
  std::uint64_t taken_ = 0;
};

}  // namespace

LogSpec load_log_spec(std::string_view name) {
  const std::filesystem::path file = find_asset("logs", name);
  ConfigNode node = ConfigNode::load(file);
  LogSpec log;
  log.name = file.stem().string();
  log.description = node.text("description");
  const std::string place = node.text("scene");
  const bool own = place.ends_with(".yaml");  // beside the survey
  log.scene = scene::Scene::load(own ? (file.parent_path() / place).string() : place);
  const int laps = node.has("laps") ? node.integer_in("laps", 1, 100) : 1;
  std::vector<Vec2> lap;
  for (const ConfigNode& stop : node.at("tour").items()) lap.push_back(log.scene.room(stop.text()).anchor);
  if (lap.empty()) node.at("tour").fail("a tour leads to one room at least");
  for (int i = 0; i < laps; ++i) log.stops.insert(log.stops.end(), lap.begin(), lap.end());
  node.finish();
  return log;
}

std::vector<std::string> log_names() { return asset_names("logs"); }

Pose2D log_lidar() { return sick().base_from_lidar; }

std::vector<RecordedScan> drive(const LogSpec& log, std::uint64_t seed) {
  const std::vector<Vec2> way = way_through(log);
  Carrot carrot(way);
  Wheels wheels(seed);
  Scanner scanner(log.scene, seed);
  Pose2D robot = log.scene.starts.front();
  std::vector<RecordedScan> scans;
  for (Time now{}; !carrot.at_end() || distance(robot.position(), carrot.place()) > 0.1; now += kStep) {
    const Pose2D since = scans.empty() ? Pose2D{} : inverse(scans.back().scene_from_base) * robot;
    if (scans.empty() || norm(since.position()) >= kScanDistance || std::fabs(since.theta) >= kScanTurn) {
      scans.push_back({now, robot, wheels.odometry(), scanner.look(robot)});
    }
    carrot.keep_ahead_of(robot.position());
    const Velocity velocity = steer(robot, carrot.place());
    robot = integrate(robot, velocity, to_seconds(kStep));
    wheels.roll(velocity, to_seconds(kStep));
  }
  return scans;
}

}  // namespace threewe::sim
