#include "slam/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "core/grid_line.hpp"
#include "core/numbers.hpp"
#include "slam/scan_beams.hpp"

namespace threewe::slam {
namespace {

constexpr std::uint64_t kFirstScans = 3;  // all of these make the first map

Time time_of_beam(Time measured, const LaserScan& scan, std::size_t i) {
  return measured + from_seconds(static_cast<double>(i) * scan.time_increment);
}

}  // namespace

Time end_of(Time measured, const LaserScan& scan) {
  const std::size_t n = scan.ranges.size();
  return std::max(measured, n > 0 ? time_of_beam(measured, scan, n - 1) : measured);
}

FrontEnd::FrontEnd(const SensorModel& sensors, SharedParams params, const Pose2D& map_from_odom, double range_bias)
    : params_(std::move(params)),
      sensors_(sensors),
      track_({.lateral_scale = sensors.lateral_scale, .range_bias = range_bias}, sensors.lidar && sensors.streams,
             params_->dead_reckoning),
      range_noise_(sensors.range_sigma),
      filter_(sensors, params_->filter),
      map_from_odom_(map_from_odom) {}

void FrontEnd::add_scan(Time measured, const LaserScan& scan, Time stamp, double range_max) {
  judge_lidar(scan);
  const Pose2D base_from_odom = inverse(track_.at(stamp));
  beams_ = beams_of(
      scan, range_max,
      [&](std::size_t i) {
        return base_from_odom * track_.at(time_of_beam(measured, scan, i)) * sensors_.base_from_lidar;
      },
      params_->beams, point_offset(sensors_.points_per_turn, scan.angle_increment));
}

// A lidar that is noisier than its data sheet says may be biased more, too. What begins on the way is another thing.
void FrontEnd::judge_lidar(const LaserScan& scan) {
  const Params::Registration& p = params_->registration;
  range_noise_.add(scan);
  const double noisier = range_noise_.sigma() / (p.poor_lidar * std::max(sensors_.range_sigma, p.least_noise));
  if (track_.has_rolled() || noisier <= noisier_) return;
  filter_.widen_range_bias(sensors_.range_bias_sigma * exact::sqrt(noisier * noisier - noisier_ * noisier_));
  noisier_ = noisier;
}

void FrontEnd::predict_to(Time stamp) {
  const MotionSummary motion = track_.between(stamp_, stamp);
  const Pose2D before = map_from_base();
  rests_ = motion.at_rest && motion.seconds > 0.0 && is_gyro_bias(motion);
  if (!rests_) {
    predict(filter_, stamp);
    agreement_at_rest_ = 0.0;
  }
  stamp_ = std::max(stamp_, stamp);
  doubtful_turn_ = motion.doubtful_turn;  // only a scan can tell
  filter_.widen(motion.doubtful_way, motion.doubtful_turn);
  if (!rests_) return;
  map_from_odom_ = before * inverse(track_.at(stamp_));
  learn_gyro_bias(motion);
}

void FrontEnd::predict(PoseFilter& filter, Time until) const {
  for (std::size_t age = track_.size(); age-- > 0;) {
    const TrackPoint& p = track_.point(age);
    if (p.stamp <= stamp_ || p.stamp > until) continue;
    const double heading = map_from_odom_.theta + p.odom_from_base.theta - 0.5 * p.turn;
    filter.predict(heading, p.step, p.turn, p.seconds, p.by_gyro);
  }
}

double FrontEnd::gyro_bias_error(const MotionSummary& motion) const {
  return motion.measured / motion.seconds - track_.calibration().gyro_bias;
}

// While the wheels stand the gyro shows its bias. A bias creeps; what jumps is a fault or a turn, and would be held
// against the gyro once it is over.
bool FrontEnd::is_gyro_bias(const MotionSummary& motion) const {
  const Params::Filter& p = params_->filter;
  const double known = filter_.covariance()(kGyroBias, kGyroBias) + p.bias_creep * p.bias_creep;
  return square(gyro_bias_error(motion)) <= p.bias_jump * p.bias_jump * known;
}

void FrontEnd::learn_gyro_bias(const MotionSummary& motion) {
  const double variance = sensors_.gyro_sigma * sensors_.gyro_sigma * 0.01 / motion.seconds + 1e-7;
  shift(filter_.observe_gyro_bias(gyro_bias_error(motion), variance), map_from_base());
}

const Match& FrontEnd::match(const map::LogOddsMap& map, const Doubt& doubt) {
  holds_ = false;
  if (rests_ && !doubt.lost && knows_more_than_scan()) return match_at_rest(map, doubt);
  return match_near(map, map_from_base(), doubt, false);
}

// Near a pose; where it does not fit there, or the robot may have been moved, or the heading is unsure, everywhere
// around.
const Match& FrontEnd::match_near(const map::LogOddsMap& map, const Pose2D& start, const Doubt& doubt, bool moved) {
  const Params::Registration& p = params_->registration;
  filter_.widen(params_->filter.scan_position, params_->filter.scan_heading);
  if (doubt.position > 0.0) filter_.widen(doubt.position, doubt.heading);
  match_ = match_at(map, start, filter_);
  const bool poor = moved || (match_.agreement < p.poor_agreement && match_.known_hits >= p.few_hits);
  if (poor || filter_.covariance()(kTheta, kTheta) > square(p.unsure_heading)) search(map, doubt, poor);
  fits_ = !is_contradicted(map, doubt);
  return match_;
}

// Scans of a robot at rest have their errors in common: once the filter knows as much as one of them tells, another one
// would only have the pose follow the map, and the map the pose.
bool FrontEnd::knows_more_than_scan() const {
  const Matrix3 ratios = filter_.covariance().topLeftCorner<3, 3>() * match_.scan_information.topLeftCorner<3, 3>();
  return ratios.trace() < 3.0;
}

// Wheels and gyro stand. The robot holds its pose, unless it was pushed: then its scan fits elsewhere when nothing but
// the scan counts, or much worse than before.
const Match& FrontEnd::match_at_rest(const map::LogOddsMap& map, const Doubt& doubt) {
  const Params::Registration& p = params_->registration;
  const Pose2D here = map_from_base();
  match_ = match_alone(map);
  fits_ = !is_contradicted(map, doubt);
  const double worse = std::max(range_noise() / params_->matching.usual_noise, 1.0);
  const Pose2D off = inverse(here) * match_.at.pose;
  const bool near = norm(off.position()) < worse * p.pushed && std::fabs(off.theta) < worse * p.pushed_turn;
  const bool alike = match_.agreement > agreement_at_rest_ - p.better_poor;
  agreement_at_rest_ = std::max(match_.agreement, agreement_at_rest_ - p.fading);
  holds_ = fits_ && near && alike;
  if (holds_) return match_;
  if (near || !is_confirmed(match_)) return match_near(map, here, doubt, !alike);
  filter_.widen(norm(off.position()), std::fabs(off.theta));
  return match_near(map, Pose2D{match_.at.pose}, doubt, !alike);
}

Match FrontEnd::match_at(const map::LogOddsMap& map, const Pose2D& start, const PoseFilter& filter) const {
  return match_scan(map, beams_, {map_from_base(), range_bias()}, filter.scan_covariance().inverse(), start,
                    range_noise_.sigma(), Directions::observed, params_->matching);
}

Match FrontEnd::match_alone(const map::LogOddsMap& map) const {
  const Pose2D here = map_from_base();
  return match_scan(map, beams_, {here, range_bias()}, free_prior(params_->matching), here, range_noise(),
                    Directions::observed, params_->matching);
}

// Tries all poses around, and takes the best one if the scan clearly fits better there.
void FrontEnd::search(const map::LogOddsMap& map, const Doubt& doubt, bool poor) {
  const Params::Registration& p = params_->registration;
  if (poor && !may_be_elsewhere(doubt)) return;
  const SearchWindow around = window(doubt);
  const Pose2D found = search_pose(map, beams_, map_from_base(), around);
  PoseFilter wide = filter_;
  if (poor) wide.widen(0.5 * around.position, 0.5 * around.heading);
  const Match other = match_at(map, found, wide);
  if (other.agreement <= match_.agreement + (poor ? p.better_poor : p.better)) return;
  match_ = other;
  filter_ = std::move(wide);
}

// Three standard deviations to each side.
SearchWindow FrontEnd::window(const Doubt& doubt) const {
  const Params::Registration& p = params_->registration;
  const bool guessed = doubt.lost || doubt.position > 0.0;
  const Matrix7& belief = filter_.covariance();
  const double position = 3.0 * exact::sqrt(std::max(belief(kX, kX), belief(kY, kY)));
  const double heading = 3.0 * exact::sqrt(belief(kTheta, kTheta));
  return {std::clamp(position, guessed ? p.widest_position : p.search_position, p.widest_position),
          std::clamp(heading, guessed ? p.widest_heading : p.search_heading, p.widest_heading)};
}

// No robot is teleported whose wheels and gyro measure one motion: a scan that says so is late.
bool FrontEnd::may_be_elsewhere(const Doubt& doubt) const {
  return doubt.lost || !sensors_.gyro || doubtful_turn_ > 0.0 || track_.stands();
}

bool FrontEnd::is_confirmed(const Match& match) const {
  const Params::Registration& p = params_->registration;
  const double enough = std::max<double>(p.few_hits, p.known_share * static_cast<double>(hits()));
  return match.known_hits >= enough && match.agreement >= p.good_agreement;
}

// Whether the scan does not lie where it was matched, by what is known there.
bool FrontEnd::is_contradicted(const map::LogOddsMap& map, const Doubt& doubt) const {
  const Params::Registration& p = params_->registration;
  const auto all = static_cast<double>(hits());
  const bool doubtful = doubt.lost || match_.known_hits < p.known_share * all;
  const double least = doubtful ? p.poor_agreement : p.least_agreement;
  if (match_.known_hits >= p.few_hits && match_.agreement < least) return true;
  const bool few = match_.known_hits < std::max<double>(p.few_hits, p.few_known_share * all);
  return few && all >= p.few_hits && crosses_walls(map);
}

// Whether most of what is seen lies behind walls, as from another room.
bool FrontEnd::crosses_walls(const map::LogOddsMap& map) const {
  const Params::Registration& p = params_->registration;
  const map::OccupancyGrid& grid = map.grid();
  const double cells = 1.0 / grid.resolution;
  const Pose2D here = map_from_base();
  const auto passes = [&](const map::Beam& beam) {
    const Vec2 from = here * beam.origin;
    const Vec2 to = here * (beam.origin + std::max(beam.range - p.before_wall, 0.0) * beam.direction);
    return !walk_grid_line(cells * (from - grid.origin), cells * (to - grid.origin),
                           [&](int x, int y) { return map.log_odds({x, y}) <= 0; });
  };
  const auto crossing = std::ranges::count_if(beams_, [&](const map::Beam& beam) { return beam.hit && passes(beam); });
  return static_cast<double>(crossing) > p.through_walls * static_cast<double>(hits());
}

void FrontEnd::update() {
  const Pose2D predicted = map_from_base();
  const Pose2D& pose = match_.at.pose;
  const Vector4 moved{pose.x - predicted.x, pose.y - predicted.y, wrap_angle(pose.theta - predicted.theta),
                      match_.at.range_bias - range_bias()};
  shift(filter_.condition(moved, match_.information.inverse(), match_.unobserved), predicted);
}

// Moves the estimate: the pose by moving map_from_odom, the calibration for the steps to come.
void FrontEnd::shift(const Vector7& by, const Pose2D& from) {
  const Pose2D moved{from.x + by(kX), from.y + by(kY), wrap_angle(from.theta + by(kTheta))};
  map_from_odom_ = moved * inverse(track_.at(stamp_));
  Calibration c = track_.calibration();
  c.gyro_bias += by(kGyroBias);
  c.forward_scale *= 1.0 + by(kForwardScale);
  c.lateral_scale *= 1.0 + by(kLateralScale);
  c.range_bias += by(kRangeBias);
  track_.calibrate(c);
}

void FrontEnd::set_pose(const Pose2D& map_from_base, double position_sigma, double heading_sigma) {
  map_from_odom_ = map_from_base * inverse(track_.at(stamp_));
  filter_.restart(position_sigma, heading_sigma);
}

void FrontEnd::move_map(const Pose2D& new_from_old, double position_sigma, double heading_sigma) {
  map_from_odom_ = new_from_old * map_from_odom_;
  mapped_at_ = new_from_old * mapped_at_;
  filter_.widen(position_sigma, heading_sigma);
}

bool FrontEnd::is_due(std::uint64_t version) const {
  const Params::Mapping& p = params_->mapping;
  const Pose2D since = inverse(mapped_at_) * map_from_base();
  return version < kFirstScans || norm(since.position()) > p.distance || std::fabs(since.theta) > p.turn ||
         stamp_ - mapped_stamp_ >= p.age;
}

void FrontEnd::set_mapped() {
  mapped_at_ = map_from_base();
  mapped_stamp_ = stamp_;
}

Matrix7 FrontEnd::newest_covariance() const {
  PoseFilter filter = filter_;
  predict(filter, Time::max());
  return filter.covariance();
}

std::ptrdiff_t FrontEnd::hits() const {
  return std::ranges::count_if(beams_, [](const map::Beam& beam) { return beam.hit; });
}

}  // namespace threewe::slam
