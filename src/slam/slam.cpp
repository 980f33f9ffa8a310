#include "threewe/slam/slam.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "slam/scan_beams.hpp"
#include "slam/scan_odometry.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

void require(bool holds, std::string_view field, std::string_view range, double value) {
  if (!holds) throw ContractError(fmt::format("{} must lie in {}, got {:g}", field, range, value));
}

SlamConfig checked(const SlamConfig& config) {
  const Pose2D& lidar = config.base_from_lidar;
  if (!is_finite(lidar)) {
    throw ContractError(
        fmt::format("base_from_lidar must be finite, got ({:g}, {:g}, {:g})", lidar.x, lidar.y, lidar.theta));
  }
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  require(within(config.range_max, 1.0, 200.0), "range_max", "[1, 200] m", config.range_max);
  require(within(config.resolution, 0.02, 0.2), "resolution", "[0.02, 0.2] m", config.resolution);
  require(within(config.range_bias_sigma, 0.0, 0.1), "range_bias_sigma", "[0, 0.1] m", config.range_bias_sigma);
  require(within(config.distance_sigma, 0.0, 0.2), "distance_sigma", "[0, 0.2]", config.distance_sigma);
  require(within(config.position_drift, 0.0, 0.3), "position_drift", "[0, 0.3] m/sqrt(m)", config.position_drift);
  require(within(config.heading_drift, 0.0, 0.3), "heading_drift", "[0, 0.3] rad/sqrt(m)", config.heading_drift);
  return config;
}

SensorModel sensors(const SlamConfig& config) {
  SensorModel model;
  model.base_from_lidar = config.base_from_lidar;
  model.range_bias_sigma = config.range_bias_sigma;
  model.forward_scale_sigma = config.distance_sigma;
  model.wheel_slip = config.position_drift;
  model.wheel_drift = config.heading_drift;
  return model;
}

void check(const LaserScan& scan) {
  if (!(scan.angle_increment > 0.0) || !std::isfinite(scan.angle_increment) || !std::isfinite(scan.angle_min)) {
    throw ContractError(
        fmt::format("a scan's angles must be finite and go up, got angle_min {:g}, angle_increment {:g}",
                    scan.angle_min, scan.angle_increment));
  }
  if (!std::isfinite(scan.time_increment)) throw ContractError("a scan's time_increment must be finite");
  if (!(scan.range_min >= 0.0) || !(scan.range_max > scan.range_min) || !std::isfinite(scan.range_max)) {
    throw ContractError(
        fmt::format("a scan needs 0 <= range_min < range_max, got {:g} and {:g}", scan.range_min, scan.range_max));
  }
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (scan.ranges[i] >= 0.0F && std::isfinite(scan.ranges[i])) continue;
    throw ContractError(
        fmt::format("range {} of a scan is {:g}: no return is range_max, invalid is 0", i, scan.ranges[i]));
  }
}

// Makes the map as large as it will be.
void make_room(const std::vector<std::vector<map::Beam>>& scans, map::LogOddsMap& map) {
  Vec2 low;
  Vec2 high;
  for (const std::vector<map::Beam>& scan : scans) {
    for (const map::Beam& beam : scan) {
      for (const Vec2 p : {beam.origin, beam.origin + beam.range * beam.direction}) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    }
  }
  if (!scans.empty()) map.make_room(low, high);
}

}  // namespace

struct Slam::State {
  explicit State(const SlamConfig& c) : config(c), front({.sensors = sensors(c), .range_max = c.range_max}) {}

  // A scan, and where it was taken.
  struct Node {
    Time stamp{};
    Pose2D map_from_base;
    std::vector<map::Beam> beams;  // in the base frame; empty where it brought nothing new
  };

  void check_order(Time stamp, const LaserScan& scan) const;

  SlamConfig config;
  ScanOdometry front;
  std::size_t beams = 0;  // of each scan
  std::vector<Node> nodes;
};

Slam::Slam(const SlamConfig& config) : state_(std::make_unique<State>(checked(config))) {}
Slam::~Slam() = default;
Slam::Slam(Slam&&) noexcept = default;
Slam& Slam::operator=(Slam&&) noexcept = default;

Pose2D Slam::add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base) {
  if (!is_finite(odom_from_base)) {
    throw ContractError(fmt::format("odometry must be finite, got ({:g}, {:g}, {:g})", odom_from_base.x,
                                    odom_from_base.y, odom_from_base.theta));
  }
  check(scan);
  State& s = *state_;
  s.check_order(stamp, scan);

  s.beams = scan.ranges.size();
  s.nodes.push_back({stamp, s.front.add(stamp, scan, odom_from_base), {}});
  if (s.front.mapped()) s.nodes.back().beams = s.front.beams();
  return s.nodes.back().map_from_base;
}

void Slam::State::check_order(Time stamp, const LaserScan& scan) const {
  if (nodes.empty()) return;
  if (scan.ranges.size() != beams) {
    throw ContractError(fmt::format("a scan of {} ranges after scans of {}: begin a new Slam for another lidar",
                                    scan.ranges.size(), beams));
  }
  if (stamp <= nodes.back().stamp) {
    throw ContractError(fmt::format("time must go on from scan to scan: {:.6f} s after {:.6f} s", to_seconds(stamp),
                                    to_seconds(nodes.back().stamp)));
  }
}

map::OccupancyGrid Slam::map() const {
  std::vector<std::vector<map::Beam>> scans;
  for (const State::Node& node : state_->nodes) {
    if (!node.beams.empty()) scans.push_back(transformed(node.map_from_base, node.beams));
  }
  map::LogOddsMap map({.resolution = state_->config.resolution});
  make_room(scans, map);
  for (const std::vector<map::Beam>& scan : scans) map.insert(scan, state_->front.range_bias());
  return map.grid();
}

std::vector<StampedPose> Slam::trajectory() const {
  std::vector<StampedPose> poses;
  poses.reserve(state_->nodes.size());
  for (const State::Node& node : state_->nodes) poses.push_back({node.stamp, node.map_from_base});
  return poses;
}

}  // namespace threewe::slam
