#include "robot/truth_localizer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/exact.hpp"
#include "map/change_log.hpp"
#include "map/log_odds_map.hpp"
#include "robot/scan_track.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

constexpr double kKeyframeDistance = 0.08;  // [m] the map takes a scan after so much motion ...
constexpr double kKeyframeTurn = 0.07;      // [rad] ... or turning
constexpr double kFreeNoReturn = 4.0;       // [m] a beam without return clears so much

class TruthLocalizer final : public slam::Localizer {
 public:
  TruthLocalizer(const RobotProfile& profile, const slam::InitialState& initial, const scene::TruthView& truth)
      : lidar_(profile.lidar),
        map_from_odom_(initial.map_from_start.value_or(Pose2D{})),
        truth_(&truth),
        track_(profile.lidar) {
    if (initial.map) map_ = map::LogOddsMap::going_on_from(*initial.map);
  }

  void add(const Sample& sample) override {
    track_.add_pose(sample.received, odom_from_base());
    const auto* scan = std::get_if<LaserScan>(&sample.data);
    if (scan == nullptr || !lidar_) return;
    track_.add_scan(*scan, sample.measured);
    if (is_elsewhere()) extend_map(*scan, sample.measured);
  }

  slam::PoseEstimate estimate(Time now) const override {
    slam::PoseEstimate e;
    e.stamp = now;
    e.odom_from_base = odom_from_base();
    e.map_from_odom = map_from_odom_;
    e.velocity = truth_->true_velocity();
    return e;
  }
  void set_truth(const scene::TruthView& truth) { truth_ = &truth; }
  const map::OccupancyGrid& map() const override { return map_.grid(); }
  std::uint64_t map_version() const override { return map_.version(); }
  const map::ChangeLog* map_changes() const override { return &map_.changes(); }
  std::span<const Vec2> obstacles() const override { return track_.obstacles(); }
  std::unique_ptr<Localizer> clone() const override { return std::make_unique<TruthLocalizer>(*this); }

 private:
  Pose2D odom_from_base() const { return inverse(truth_->start_pose()) * truth_->true_pose(); }
  bool is_elsewhere() const;
  void extend_map(const LaserScan& scan, Time measured);

  std::optional<LidarSpec> lidar_;
  Pose2D map_from_odom_;
  const scene::TruthView* truth_;
  ScanTrack track_;  // of the ticks in which something arrived
  map::LogOddsMap map_;
  Pose2D keyframe_;  // odom_from_base when the map last took a scan
};

bool TruthLocalizer::is_elsewhere() const {
  const Pose2D since = inverse(keyframe_) * odom_from_base();
  return map_.version() == 0 || norm(since.position()) > kKeyframeDistance || std::abs(since.theta) > kKeyframeTurn;
}

void TruthLocalizer::extend_map(const LaserScan& scan, Time measured) {
  std::vector<map::Beam> beams;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (range < scan.range_min || range <= 0.0) continue;
    const Time taken = measured + from_seconds(static_cast<double>(i) * scan.time_increment);
    const Pose2D map_from_lidar = map_from_odom_ * track_.at(taken) * lidar_->base_from_lidar;
    const double angle = map_from_lidar.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const bool hit = range < scan.range_max;
    beams.push_back(
        {map_from_lidar.position(), rotate({1.0, 0.0}, angle), hit ? range : std::min(kFreeNoReturn, range), hit});
  }
  map_.insert(beams);
  keyframe_ = odom_from_base();
}

}  // namespace

std::unique_ptr<slam::Localizer> make_truth_localizer(const RobotProfile& profile, const slam::InitialState& initial,
                                                      const scene::TruthView& truth) {
  if (initial.map && !initial.map_from_start) {
    throw ContractError("localization 'truth' in a given map needs initial_pose: the truth knows nothing of that map");
  }
  return std::make_unique<TruthLocalizer>(profile, initial, truth);
}

void set_truth(slam::Localizer& localizer, const scene::TruthView& truth) {
  if (auto* it = dynamic_cast<TruthLocalizer*>(&localizer)) it->set_truth(truth);
}

}  // namespace threewe
