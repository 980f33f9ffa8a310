#include "threewe/slam/slam.hpp"

#include <utility>

#include <fmt/format.h>

#include "slam/scan_beams.hpp"
#include "slam/scan_odometry.hpp"
#include "slam/slam_config.hpp"
#include "slam/slam_file.hpp"
#include "slam/trail.hpp"
#include "threewe/core/bounds.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

SensorModel sensors(const SlamConfig& config) {
  SensorModel model;
  model.base_from_lidar = config.base_from_lidar;
  model.range_bias_sigma = config.range_bias_sigma;
  model.forward_scale_sigma = config.distance_sigma;
  model.wheel_slip = config.position_drift;
  model.wheel_drift = config.heading_drift;
  return model;
}

}  // namespace

struct Slam::State {
  explicit State(const SlamConfig& c, double range_bias = 0.0)
      : config((check(c), c)), front({.sensors = sensors(c), .range_max = c.range_max, .range_bias = range_bias}) {}

  void check_order(Time stamp, const LaserScan& scan) const;

  SlamConfig config;
  ScanOdometry front;
  std::size_t beams = 0;  // of each scan; 0 before the first
  Trail trail;
};

Slam::Slam(const SlamConfig& config) : state_(std::make_unique<State>(config)) {}
Slam::~Slam() = default;
Slam::Slam(Slam&&) noexcept = default;
Slam& Slam::operator=(Slam&&) noexcept = default;

Pose2D Slam::add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base) {
  check_bounds("odometry", odom_from_base);
  check_bounds(scan);
  State& s = *state_;
  s.check_order(stamp, scan);

  s.beams = scan.ranges.size();
  const Pose2D local_from_base = s.front.add(stamp, scan, odom_from_base);
  return s.trail.add({stamp, local_from_base, s.front.covariance(), s.front.beams(), s.front.range_bias()});
}

void Slam::State::check_order(Time stamp, const LaserScan& scan) const {
  if (trail.data().steps.empty()) return;
  if (beams != 0 && scan.ranges.size() != beams) {
    throw ContractError(fmt::format("a scan of {} ranges after scans of {}: begin a new Slam for another lidar",
                                    scan.ranges.size(), beams));
  }
  if (stamp <= trail.data().steps.back().stamp) {
    throw ContractError(fmt::format("time must go on from scan to scan: {:.6f} s after {:.6f} s", to_seconds(stamp),
                                    to_seconds(trail.data().steps.back().stamp)));
  }
}

map::OccupancyGrid Slam::map() const {
  const TrailData& trail = state_->trail.data();
  std::vector<std::vector<map::Beam>> scans;
  for (std::size_t k = 0; k < trail.keyframes.size(); ++k) {
    const Pose2D& map_from_keyframe = trail.graph.poses()[k];
    for (const Keyframe::Scan& scan : trail.keyframes[k].scans) {
      scans.push_back(unpacked(scan.beams, map_from_keyframe * scan.keyframe_from_base));
    }
  }
  return drawn(scans, {.resolution = state_->config.resolution}, state_->front.range_bias()).grid();
}

std::vector<LoopClosure> Slam::closures() const {
  const TrailData& trail = state_->trail.data();
  const auto stamp = [&](int keyframe) { return trail.keyframes[static_cast<std::size_t>(keyframe)].stamp; };
  std::vector<LoopClosure> closures;
  for (const Constraint& c : trail.graph.constraints()) {
    if (c.doubtful) closures.push_back({stamp(c.from), stamp(c.to), c.from_from_to});
  }
  return closures;
}

std::vector<StampedPose> Slam::trajectory() const {
  const TrailData& trail = state_->trail.data();
  std::vector<StampedPose> poses;
  poses.reserve(trail.steps.size());
  for (const TrailStep& step : trail.steps) poses.push_back({step.stamp, trail.pose_of(step)});
  return poses;
}

void Slam::save(const std::filesystem::path& path) const {
  const State& s = *state_;
  if (s.trail.data().steps.empty()) throw ContractError("a map without any scan cannot be saved: add one first");
  write_slam_file(path, {s.config, s.front.range_bias(), s.trail.data()});
}

Slam Slam::load(const std::filesystem::path& path, const std::optional<Pose2D>& map_from_base) {
  if (map_from_base) check_bounds("where the robot goes on", *map_from_base);
  SlamFile file = read_slam_file(path);
  Slam slam(file.config);
  slam.state_ = std::make_unique<State>(file.config, file.range_bias);
  const Pose2D last = file.trail.pose_of(file.trail.steps.back());
  slam.state_->trail = Trail(std::move(file.trail), map_from_base.value_or(last));
  return slam;
}

}  // namespace threewe::slam
