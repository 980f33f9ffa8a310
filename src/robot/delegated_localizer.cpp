#include "robot/delegated_localizer.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "robot/scan_track.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe {
namespace {

constexpr Duration kPatience = 1s;          // for the next transform; the rarest come with each scan
constexpr Duration kExtrapolation = 300ms;  // beyond the newest odometry
// Of a program that states none, as RViz and AMCL have it of a robot that was placed by hand: 0.5 m, 15 degrees.
constexpr std::array<double, 9> kAssumed{0.25, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.06854};

class DelegatedLocalizer final : public slam::Localizer {
 public:
  DelegatedLocalizer(const RobotProfile& profile, std::string program, const backend::ExternalLocalizer& source)
      : program_(std::move(program)), source_(&source), track_(profile.lidar) {}

  void add(const Sample& sample) override {
    report_ = source_->report();
    asked_ = true;
    if (const auto* odometry = std::get_if<Odometry>(&sample.data)) {
      odometry_ = *odometry;
      odometry_stamp_ = sample.measured;
      track_.add_pose(sample.measured, odometry->pose);
    }
    if (const auto* scan = std::get_if<LaserScan>(&sample.data); scan != nullptr && odometry_) {
      track_.add_scan(*scan, sample.measured);
    }
  }

  slam::PoseEstimate estimate(Time now) const override {
    slam::PoseEstimate estimate;
    estimate.stamp = now;
    if (odometry_) {
      const Duration ahead = std::clamp<Duration>(now - odometry_stamp_, 0ns, kExtrapolation);
      estimate.odom_from_base = integrate(odometry_->pose, odometry_->velocity, to_seconds(ahead));
      estimate.velocity = odometry_->velocity;
    }
    estimate.map_from_odom = report_.map_from_odom.value_or(Pose2D{});
    estimate.covariance = report_.covariance.value_or(kAssumed);
    if (is_silent(now)) estimate.state = slam::LocalizationState::lost;
    return estimate;
  }

  const map::OccupancyGrid& map() const override {
    static const map::OccupancyGrid none;
    return report_.map ? *report_.map : none;
  }
  std::uint64_t map_version() const override { return report_.map_version; }
  std::span<const Vec2> obstacles() const override { return track_.obstacles(); }
  std::unique_ptr<Localizer> clone() const override { return std::make_unique<DelegatedLocalizer>(*this); }

  perception::SensorHealth health(Time now) const {
    perception::SensorHealth health;
    health.name = program_;
    if (asked_ && is_silent(now)) {
      health.fault = perception::SensorFault::silent;
      health.detail = report_.missing;
      if (report_.map_from_odom) health.detail += fmt::format(" for {:.1f} s", to_seconds(now - report_.updated));
    } else if (asked_ && !report_.covariance) {
      health.detail = "it states no covariance; standard deviations of 0.5 m and 15 degrees are assumed";
    }
    return health;
  }

  Time known_until() const { return std::min(odometry_stamp_, report_.updated); }

 private:
  bool is_silent(Time now) const { return !report_.map_from_odom || now - report_.updated > kPatience; }

  std::string program_;
  const backend::ExternalLocalizer* source_;
  backend::ExternalLocalizer::Report report_;  // as of the newest sample
  bool asked_ = false;
  std::optional<Odometry> odometry_;
  Time odometry_stamp_{};
  ScanTrack track_;
};

}  // namespace

std::unique_ptr<slam::Localizer> make_delegated_localizer(const RobotProfile& profile, std::string program,
                                                          const backend::ExternalLocalizer& source) {
  return std::make_unique<DelegatedLocalizer>(profile, std::move(program), source);
}

std::optional<perception::SensorHealth> program_health(const slam::Localizer& localizer, Time now) {
  const auto* delegated = dynamic_cast<const DelegatedLocalizer*>(&localizer);
  return delegated == nullptr ? std::nullopt : std::optional(delegated->health(now));
}

std::optional<Time> known_until(const slam::Localizer& localizer) {
  const auto* delegated = dynamic_cast<const DelegatedLocalizer*>(&localizer);
  return delegated == nullptr ? std::nullopt : std::optional(delegated->known_until());
}

}  // namespace threewe
