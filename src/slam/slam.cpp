#include "threewe/slam/slam.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "slam/front_end.hpp"
#include "slam/keyframe_graph.hpp"
#include "slam/local_map.hpp"
#include "slam/odometry_check.hpp"
#include "slam/relocalizer.hpp"
#include "slam/slam_config.hpp"
#include "slam/slam_file.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

SensorModel sensors(const SlamConfig& config) {
  SensorModel model;
  model.gyro = false;
  model.streams = false;
  model.base_from_lidar = config.base_from_lidar;
  model.range_bias_sigma = config.range_bias_sigma;
  model.forward_scale_sigma = config.distance_sigma;
  model.wheel_slip = config.position_drift;
  model.wheel_drift = config.heading_drift;
  return model;
}

// Of a log's robot nothing is known but its lidar.
SharedParams params_of(const SlamConfig& config) {
  Params params;
  Scales scales;
  if (config.range_bias_sigma > 0.0) scales.bias = config.range_bias_sigma / SlamConfig{}.range_bias_sigma;
  scale_parameters(parameters_of(params), scales);
  return std::make_shared<const Params>(params);
}

// Components as users see them: counted, in order of time.
std::vector<int> numbered(std::vector<int> components) {
  std::vector<int> number(components.size());
  int count = 0;
  for (std::size_t k = 0; k < components.size(); ++k) {
    const auto root = static_cast<std::size_t>(components[k]);
    if (root == k) number[k] = count++;
    components[k] = number[root];
  }
  return components;
}

}  // namespace

std::string_view to_string(SlamIncident incident) {
  switch (incident) {
    case SlamIncident::lidar_frozen: return "lidar_frozen";
    case SlamIncident::odometry_jumped: return "odometry_jumped";
    case SlamIncident::odometry_stopped: return "odometry_stopped";
    case SlamIncident::odometry_scaled: return "odometry_scaled";
    case SlamIncident::track_lost: return "track_lost";
    case SlamIncident::components_joined: return "components_joined";
  }
  return "";
}

struct Slam::State {
  explicit State(const SlamConfig& c, double range_bias = 0.0)
      : config((check(c), c)),
        params(params_of(config)),
        front(sensors(c), params, {}, range_bias),
        odometry_check(params),
        local_map(params),
        keyframe_graph(true, params),
        relocalizer(params) {}

  Pose2D add(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& odom_from_base);
  void check_order(Time stamp, const LaserScan& scan) const;
  void record(Time stamp, const Registration& seen, bool joined);
  void record(Time stamp, SlamIncident incident, bool happens);

  SlamConfig config;
  SharedParams params;
  FrontEnd front;
  OdometryCheck odometry_check;
  LocalMap local_map;
  std::size_t beam_count = 0;  // of each scan; 0 before the first
  KeyframeGraph keyframe_graph;
  Relocalizer relocalizer;
  std::vector<SlamEvent> events;
  std::array<bool, 6> happening{};  // by incident, at the newest scan
};

Slam::Slam(const SlamConfig& config) : state_(std::make_unique<State>(config)) {}
Slam::~Slam() = default;
Slam::Slam(Slam&&) noexcept = default;
Slam& Slam::operator=(Slam&&) noexcept = default;

Pose2D Slam::add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base) {
  check_bounds("odometry", odom_from_base);
  return state_->add(stamp, scan, odom_from_base);
}

Pose2D Slam::add(Time stamp, const LaserScan& scan) { return state_->add(stamp, scan, {}); }

// Checks the scan, registers it with the last metres, takes it into the graph, looks for a robot that was lost.
Pose2D Slam::State::add(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& odom_from_base) {
  check_bounds(scan);
  check_order(stamp, scan);

  beam_count = scan.ranges.size();
  const Registration seen = odometry_check.add(front, local_map.map(), stamp, scan, config.range_max, odom_from_base);
  const bool lost = seen.scan == Registration::Scan::lost;
  const bool measured = lost || seen.scan == Registration::Scan::fits;
  if (lost) local_map.clear();
  if (measured) local_map.extend(front);

  const Pose2D local_from_base = front.map_from_base();
  const std::vector<map::Beam> beams = measured ? front.beams() : std::vector<map::Beam>{};
  const int joined_before = keyframe_graph.joined();
  keyframe_graph.add({stamp, local_from_base, front.covariance().topLeftCorner<3, 3>(), beams, front.range_bias(),
                      front.range_noise(), lost});
  const auto found = relocalizer.look(keyframe_graph, stamp, local_from_base, beams, front.range_bias());
  if (found) keyframe_graph.join_at(found->component, found->map_from_base, front.range_bias());
  record(stamp, seen, keyframe_graph.joined() != joined_before);
  return keyframe_graph.data().pose_of(keyframe_graph.data().steps.back());
}

void Slam::State::record(Time stamp, const Registration& newest, bool joined) {
  record(stamp, SlamIncident::lidar_frozen, newest.frozen);
  record(stamp, SlamIncident::odometry_jumped, newest.odometry_jumped);
  record(stamp, SlamIncident::odometry_stopped, newest.odometry_stopped);
  record(stamp, SlamIncident::odometry_scaled, newest.odometry_scaled);
  record(stamp, SlamIncident::track_lost, newest.scan == Registration::Scan::lost);
  record(stamp, SlamIncident::components_joined, joined);
}

// An incident that goes on from the scan before is the same event.
void Slam::State::record(Time stamp, SlamIncident incident, bool happens) {
  bool& happening_before = happening[static_cast<std::size_t>(incident)];
  const bool goes_on = std::exchange(happening_before, happens) && happens;
  if (!happens) return;
  if (!goes_on) {
    events.push_back({incident, stamp, stamp, 1});
    return;
  }
  const auto same = std::ranges::find(events.rbegin(), events.rend(), incident, &SlamEvent::incident);
  same->end = stamp;
  ++same->scans;
}

void Slam::State::check_order(Time stamp, const LaserScan& scan) const {
  if (keyframe_graph.data().steps.empty()) return;
  if (beam_count != 0 && scan.ranges.size() != beam_count) {
    throw ContractError(fmt::format("a scan of {} ranges after scans of {}: begin a new Slam for another lidar",
                                    scan.ranges.size(), beam_count));
  }
  if (stamp <= keyframe_graph.data().steps.back().stamp) {
    throw ContractError(fmt::format("time must go on from scan to scan: {:.6f} s after {:.6f} s", to_seconds(stamp),
                                    to_seconds(keyframe_graph.data().steps.back().stamp)));
  }
}

map::OccupancyGrid Slam::map(int component) const {
  const State& s = *state_;
  return drawn_component(s.keyframe_graph.data(), numbered(s.keyframe_graph.components()), component,
                         s.config.resolution, s.front.range_bias(), *s.params)
      .grid();
}

std::vector<SlamEvent> Slam::events() const { return state_->events; }

std::vector<LoopClosure> Slam::closures() const {
  const KeyframeGraphData& keyframe_graph = state_->keyframe_graph.data();
  const auto stamp = [&](int keyframe) { return keyframe_graph.keyframes[static_cast<std::size_t>(keyframe)].stamp; };
  std::vector<LoopClosure> closures;
  for (const Constraint& c : keyframe_graph.graph.constraints()) {
    if (c.doubtful) closures.push_back({stamp(c.from), stamp(c.to), c.from_from_to});
  }
  return closures;
}

std::vector<StampedPose> Slam::trajectory() const {
  const KeyframeGraphData& keyframe_graph = state_->keyframe_graph.data();
  std::vector<StampedPose> poses;
  poses.reserve(keyframe_graph.steps.size());
  const std::vector<int> component = numbered(state_->keyframe_graph.components());
  for (const TrajectoryStep& step : keyframe_graph.steps) {
    poses.push_back({step.stamp, keyframe_graph.pose_of(step), component[static_cast<std::size_t>(step.keyframe)]});
  }
  return poses;
}

void Slam::save(const std::filesystem::path& path) const {
  const State& s = *state_;
  if (s.keyframe_graph.data().steps.empty())
    throw ContractError("a map without any scan cannot be saved: add one first");
  write_slam_file(path, {s.config, s.front.range_bias(), s.keyframe_graph.data()});
}

Slam Slam::load(const std::filesystem::path& path, const std::optional<Pose2D>& map_from_base) {
  if (map_from_base) check_bounds("where the robot goes on", *map_from_base);
  SlamFile file = read_slam_file(path);
  Slam slam(file.config);
  slam.state_ = std::make_unique<State>(file.config, file.range_bias);
  const Pose2D last = file.keyframe_graph.pose_of(file.keyframe_graph.steps.back());
  slam.state_->keyframe_graph =
      KeyframeGraph(std::move(file.keyframe_graph), map_from_base.value_or(last), slam.state_->params);
  return slam;
}

}  // namespace threewe::slam
