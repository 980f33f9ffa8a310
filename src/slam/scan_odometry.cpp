#include "slam/scan_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "slam/scan_beams.hpp"
#include "threewe/core/bounds.hpp"

namespace threewe::slam {
namespace {

constexpr double kCell = 0.10;            // [m] wide enough for two hits of one scan, some metres away
constexpr double kFreeRange = 4.0;        // [m] beams clear nothing beyond: enough to see what has gone
constexpr double kPieceLength = 20.0;     // [m] driven, after which a map is given up ...
constexpr double kOverlap = 5.0;          // [m] ... for one that was begun so long before
constexpr double kMappedDistance = 0.10;  // [m] the maps take a scan after so much motion ...
constexpr double kMappedTurn = 0.07;      // [rad] ... or turning
constexpr double kSearchAbove = 0.05;     // [rad] deviation of the heading: the fit is searched for, not followed
constexpr double kPoorAgreement = 0.6;    // below this the scan may be elsewhere, and is searched for
constexpr double kNoAgreement = 0.4;      // below this it is not where it was found
constexpr int kFewHits = 30;              // fewer hits in known space tell nothing
constexpr int kMaxMisfits = 3;            // scans in a row without agreement: what was mapped is of no use here

}  // namespace

ScanOdometry::ScanOdometry(const Settings& settings)
    : settings_(settings), track_(Calibration{.range_bias = settings.range_bias}), filter_(settings.sensors) {}

// One scan: carry the belief to it, fit it to the last metres, let their maps grow.
Pose2D ScanOdometry::add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base) {
  predict(stamp, odom_from_base);
  look(stamp, scan);
  correct();
  extend_maps();
  return local_from_base();
}

// The belief at the time of the scan, from the odometry since the scan before.
void ScanOdometry::predict(Time stamp, const Pose2D& odom_from_base) {
  Velocity velocity;
  if (!track_.empty()) {
    const double seconds = to_seconds(stamp - track_.point(0).stamp);
    const Pose2D moved = inverse(odometry_.pose) * odom_from_base;
    const Vec2 rolled = rotate(moved.position(), -0.5 * moved.theta);
    // odometry that jumps says nothing about how the robot moves
    const Velocity since{rolled.x / seconds, rolled.y / seconds, moved.theta / seconds};
    const bool jumped = norm({since.vx, since.vy}) > kMaxSpeed || std::fabs(since.omega) > kMaxSpeed;
    velocity = jumped ? Velocity{} : since;
  }
  odometry_ = {odom_from_base, velocity};
  track_.add_odometry(stamp, odometry_);

  const TrackPoint& step = track_.point(0);
  const double heading = local_from_base().theta - 0.5 * step.turn;
  filter_.predict(heading, step.step, step.turn, step.seconds, false);
  driven_ += norm(step.step);
}

// The scan's beams as if all had been measured at its stamp.
void ScanOdometry::look(Time stamp, const LaserScan& scan) {
  const Pose2D base_from_odom = inverse(track_.at(stamp));
  beams_ = beams_of(scan, settings_.range_max, [&](std::size_t i) {
    const Time measured = stamp + from_seconds(static_cast<double>(i) * scan.time_increment);
    return base_from_odom * track_.at(measured) * settings_.sensors.base_from_lidar;
  });
}

// Fits the scan to the older map; where it does not fit, the belief stays as it was predicted.
void ScanOdometry::correct() {
  if (pieces_.empty()) return;
  const Pose2D predicted = local_from_base();
  filter_.widen(0.0005, 0.0002);  // keeps the covariance invertible
  const Placement prior{predicted, range_bias()};
  Match match = match_scan(reference(), beams_, prior, filter_.scan_covariance().inverse(), predicted);

  const Matrix4 belief = filter_.scan_covariance();
  const double turned = exact::sqrt(belief(kTheta, kTheta));
  const double moved_by = exact::sqrt(std::max(belief(kX, kX), belief(kY, kY)));
  const bool poor = match.agreement < kPoorAgreement && match.known_hits >= kFewHits;
  if (poor || turned > kSearchAbove) {
    const SearchWindow window{std::clamp(3.0 * moved_by, 0.1, 0.5), std::clamp(3.0 * turned, 0.05, 0.5)};
    const Pose2D found = search_pose(reference(), beams_, predicted, window);
    PoseFilter wide = filter_;
    if (poor) wide.widen(0.5 * window.position, 0.5 * window.heading);
    const Match other = match_scan(reference(), beams_, prior, wide.scan_covariance().inverse(), found);
    if (other.agreement > match.agreement + (poor ? 0.1 : 0.02)) {
      match = other;
      filter_ = std::move(wide);
    }
  }
  const bool fits = match.known_hits < kFewHits || match.agreement >= kNoAgreement;
  misfits_ = fits ? 0 : misfits_ + 1;
  if (!fits) return;

  const Pose2D& pose = match.at.pose;
  const Vector4 moved{pose.x - predicted.x, pose.y - predicted.y, wrap_angle(pose.theta - predicted.theta),
                      match.at.range_bias - prior.range_bias};
  shift(filter_.condition(moved, match.information.inverse()), predicted);
}

// Moves the estimate: the pose by moving local_from_odom, the calibration for the steps to come.
void ScanOdometry::shift(const Vector7& by, const Pose2D& from) {
  const Pose2D moved{from.x + by(kX), from.y + by(kY), wrap_angle(from.theta + by(kTheta))};
  local_from_odom_ = moved * inverse(track_.point(0).odom_from_base);
  Calibration c = track_.calibration();
  c.forward_scale *= 1.0 + by(kForwardScale);
  c.range_bias += by(kRangeBias);
  track_.calibrate(c);
}

void ScanOdometry::extend_maps() {
  const Pose2D here = local_from_base();
  const Pose2D since = inverse(mapped_from_) * here;
  const bool moved = norm(since.position()) > kMappedDistance || std::fabs(since.theta) > kMappedTurn;
  if (misfits_ >= kMaxMisfits) pieces_.clear();
  mapped_ = pieces_.empty() || (moved && misfits_ == 0);
  if (!mapped_) return;

  const auto age = [this](const Piece& piece) { return driven_ - piece.begun; };
  if (pieces_.size() == 2 && age(pieces_.front()) > kPieceLength) pieces_.erase(pieces_.begin());
  if (pieces_.empty() || age(pieces_.back()) > kPieceLength - kOverlap) {
    pieces_.push_back({map::LogOddsMap({.resolution = kCell, .free_range = kFreeRange}), driven_});
  }
  const std::vector<map::Beam> in_local = transformed(here, beams_);
  for (Piece& piece : pieces_) piece.map.insert(in_local, range_bias());
  mapped_from_ = here;
  misfits_ = 0;
}

}  // namespace threewe::slam
