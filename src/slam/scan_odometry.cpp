#include "slam/scan_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "core/bounds.hpp"
#include "core/exact.hpp"
#include "core/grid_line.hpp"
#include "slam/scan_beams.hpp"

namespace threewe::slam {
namespace {

constexpr double kCell = 0.10;            // [m] wide enough for two hits of one scan, some metres away
constexpr double kFreeRange = 4.0;        // [m] beams clear nothing beyond: enough to see what has gone
constexpr double kPieceLength = 20.0;     // [m] driven, after which a map is given up ...
constexpr double kOverlap = 5.0;          // [m] ... for one that was begun so long before
constexpr double kMappedDistance = 0.10;  // [m] the maps take a scan after so much motion ...
constexpr double kMappedTurn = 0.07;      // [rad] ... or turning
constexpr double kSearchAbove = 0.05;     // [rad] deviation of the heading: the fit is searched for, not followed
constexpr double kSearchMost = 0.5;       // [m], [rad] to each side
constexpr double kSearchFarthest = 1.0;   // [m] the same where the motion is a guess: every cell of it is tried
constexpr double kPoorAgreement = 0.6;    // below this the scan may be elsewhere, and is searched for
constexpr double kNoAgreement = 0.4;      // below this it is not where it was found ...
constexpr double kLikeUsual = 0.8;        // of what scans agree usually, or more, confirms a place
constexpr double kNoUsual = 0.6;          // ... nor below this share of what scans agree usually ...
constexpr double kUsualShare = 0.1;       // ... of which one scan tells so much
constexpr double kBetter = 0.1;           // agreement by which another account of the motion must fit better
constexpr int kFewHits = 30;              // fewer hits in known space tell nothing ...
constexpr double kEnoughKnown = 0.5;      // ... and so large a share of them is enough to believe them alone ...
constexpr double kFewKnown = 0.2;         // ... and so small a share of them, when the others lie behind walls ...
constexpr double kThroughWalls = 0.35;    // ... of so many beams: in the right place they graze what they pass
constexpr double kBefore = 0.25;          // [m] a beam that ends so near behind a wall has hit it
constexpr int kMaxMisfits = 3;            // scans in a row without agreement: what was mapped is of no use here

// A robot goes on about as it did. A step of the odometry that differs by more is doubted, and if it would take speeds
// that no robot between walls has, nothing but a scan that fits there makes it believed.
constexpr double kJump = 1.0;               // [m]
constexpr double kTurnJump = 0.8;           // [rad]
constexpr double kMostSpeed = 5.0;          // [m/s]
constexpr double kMostTurnRate = 6.0;       // [rad/s]
constexpr double kLeastSeconds = 0.5;       // stamps of old logs come in bursts
constexpr double kMostExtrapolation = 2.0;  // times the interval before, after which nobody knows how it went on
constexpr double kSteadySigma = 0.05;       // [m] by which a step may differ from the one before ...
constexpr double kSteadyTurnSigma = 0.06;   // [rad] ...
constexpr double kSteadyShare = 0.5;        // ... and this share of it

// Motion that odometry does not tell of.
constexpr double kMoved = 0.02;        // [m] ...
constexpr double kTurned = 0.01;       // [rad] ...
constexpr double kMovedChi = 25.0;     // ... and five deviations of what the scan tells
constexpr double kFreePrior = 0.3;     // [m] the scan alone decides, and this keeps what it does not tell ...
constexpr double kFreeTurn = 0.1;      // [rad]
constexpr double kFreeBias = 0.001;    // [m]
constexpr double kFrozenMoved = 0.3;   // [m] by odometry, while scans repeat to the bit ...
constexpr double kFrozenTurned = 0.2;  // [rad] ... or so: no lidar does that

double square(double x) { return x * x; }

std::ptrdiff_t hits_of(const std::vector<map::Beam>& beams) {
  return std::ranges::count_if(beams, [](const map::Beam& beam) { return beam.hit; });
}

// Odometry that jumps says nothing about how the robot moves.
Velocity mean_velocity(const Pose2D& step, double seconds) {
  const Vec2 rolled = rotate(step.position(), -0.5 * step.theta);
  const Velocity mean{rolled.x / seconds, rolled.y / seconds, step.theta / seconds};
  const bool jumped = norm({mean.vx, mean.vy}) > kMaxSpeed || std::fabs(mean.omega) > kMaxSpeed;
  return jumped ? Velocity{} : mean;
}

}  // namespace

ScanOdometry::ScanOdometry(const Settings& settings) : settings_(settings), belief_(settings) {}

// One scan: carry the belief to it, fit it to the last metres, let their maps grow.
Pose2D ScanOdometry::add(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& odom_from_base) {
  std::optional<Pose2D> step;
  if (odom_from_base) step = raw_ ? (*raw_ == *odom_from_base ? Pose2D{} : inverse(*raw_) * *odom_from_base) : Pose2D{};
  raw_ = odom_from_base;
  const bool first = belief_.track.empty();
  if (step && !first && !is_bounded(belief_.odometry.pose * *step)) step = Pose2D{};
  const Pose2D before = first ? Pose2D{} : belief_.local_from_base();
  const double seconds = first ? 0.0 : to_seconds(stamp - belief_.track.point(0).stamp);

  registration_ = {};
  if (repeats(scan, step)) {
    registration_.scan = Registration::Scan::repeated;
    predict(stamp, {step.value_or(Pose2D{})});
    beams_.clear();
  } else {
    judge(register_scan(stamp, scan, step));
    extend_maps();
  }
  driven_ += norm(belief_.track.point(0).step);
  moved_ = inverse(before) * belief_.local_from_base();
  moved_seconds_ = seconds;
  return belief_.local_from_base();
}

// A scan that equals the one before to the bit was not measured: the robot stands in a world without noise, or its
// lidar has stopped, which shows when it drives on.
bool ScanOdometry::repeats(const LaserScan& scan, const std::optional<Pose2D>& step) {
  const auto is_hit = [&](float range) { return range > 0.0F && static_cast<double>(range) < scan.range_max; };
  const bool same = ranges_ == scan.ranges && std::ranges::any_of(ranges_, is_hit);
  if (!same) {
    ranges_ = scan.ranges;
    frozen_step_ = {};
    return false;
  }
  frozen_step_ = frozen_step_ * step.value_or(Pose2D{});
  registration_.frozen = norm(frozen_step_.position()) > kFrozenMoved || std::fabs(frozen_step_.theta) > kFrozenTurned;
  return true;
}

// Fits the scan where odometry leads; where that is doubtful, where the motion so far leads, too. Returns whether it is
// related to the scans before at all.
bool ScanOdometry::register_scan(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& step) {
  const Motion steady = steady_motion(stamp);
  const bool stands = step && *step == Pose2D{};
  odometry_stopped_ = odometry_stopped_ && stands;
  registration_.odometry_stopped = odometry_stopped_;
  if (!step || odometry_stopped_) {
    follow(stamp, scan, steady);
    return pieces_.empty() || is_confirmed(belief_.match);
  }

  const Belief before = belief_;
  const double seconds = before.track.empty() ? 1.0 : to_seconds(stamp - before.track.point(0).stamp);
  const Pose2D off = inverse(steady.step) * *step;
  const double metres = norm(off.position());
  const double turn = std::fabs(off.theta);
  const bool jumps = metres > kJump || turn > kTurnJump;
  const bool impossible =
      jumps && std::max(metres / kMostSpeed, turn / kMostTurnRate) > std::max(seconds, kLeastSeconds);
  follow(stamp, scan, {*step});
  if (pieces_.empty()) return true;
  if (stands && has_moved()) {
    odometry_stopped_ = registration_.odometry_stopped = true;
    belief_ = before;
    follow(stamp, scan, steady);
    return true;
  }
  const bool doubtful = jumps || belief_.contradicted || (stands && !is_confirmed(belief_.match));
  if (doubtful) decide(stamp, scan, before, steady, impossible);
  if (!impossible || registration_.odometry_jumped || is_confirmed(belief_.match)) return true;
  belief_ = before;
  follow(stamp, scan, steady);
  return false;
}

// Two accounts of the motion, the odometry's first: the scan decides.
void ScanOdometry::decide(Time stamp, const LaserScan& scan, const Belief& before, const Motion& steady,
                          bool impossible) {
  Belief by_odometry = std::exchange(belief_, before);
  follow(stamp, scan, steady);
  const Match& with = by_odometry.match;
  const Match& without = belief_.match;
  const bool better = with.known_hits >= kFewHits && without.agreement > with.agreement + kBetter;
  if (is_confirmed(without) && (better || impossible || by_odometry.contradicted)) {
    const bool stands = by_odometry.odometry.pose == before.odometry.pose;
    odometry_stopped_ = registration_.odometry_stopped = stands;
    registration_.odometry_jumped = !stands;
    return;
  }
  belief_ = std::move(by_odometry);
  look(stamp, scan);
}

// The robot goes on as it did from the scan before the last to the last.
ScanOdometry::Motion ScanOdometry::steady_motion(Time stamp) const {
  if (belief_.track.empty()) return {};
  Pose2D step;
  if (moved_seconds_ > 0.0) {
    const double times = to_seconds(stamp - belief_.track.point(0).stamp) / moved_seconds_;
    step = integrate({}, mean_velocity(moved_, 1.0), std::min(times, kMostExtrapolation));
  }
  return {step, kSteadySigma + kSteadyShare * norm(step.position()),
          kSteadyTurnSigma + kSteadyShare * std::fabs(step.theta)};
}

void ScanOdometry::follow(Time stamp, const LaserScan& scan, const Motion& motion) {
  predict(stamp, motion);
  look(stamp, scan);
  correct(motion);
}

// The belief at the time of the scan, from the motion since the scan before.
void ScanOdometry::predict(Time stamp, const Motion& motion) {
  DeadReckoning& track = belief_.track;
  const double seconds = track.empty() ? 0.0 : to_seconds(stamp - track.point(0).stamp);
  belief_.odometry = {belief_.odometry.pose * motion.step,
                      seconds > 0.0 ? mean_velocity(motion.step, seconds) : Velocity{}};
  track.add_odometry(stamp, belief_.odometry);

  const TrackPoint& step = track.point(0);
  const double heading = belief_.local_from_base().theta - 0.5 * step.turn;
  belief_.filter.predict(heading, step.step, step.turn, step.seconds, false);
  belief_.match = {};
  belief_.contradicted = false;
}

// The scan's beams as if all had been measured at its stamp.
void ScanOdometry::look(Time stamp, const LaserScan& scan) {
  const DeadReckoning& track = belief_.track;
  const Pose2D base_from_odom = inverse(track.at(stamp));
  beams_ = beams_of(scan, settings_.range_max, [&](std::size_t i) {
    const Time measured = stamp + from_seconds(static_cast<double>(i) * scan.time_increment);
    return base_from_odom * track.at(measured) * settings_.sensors.base_from_lidar;
  });
}

// Fits the scan to the older map; where it does not fit, the belief stays as it was predicted.
void ScanOdometry::correct(const Motion& motion) {
  if (pieces_.empty()) return;
  PoseFilter& filter = belief_.filter;
  const Pose2D predicted = belief_.local_from_base();
  filter.widen(0.0005, 0.0002);  // keeps the covariance invertible
  const bool guessed = motion.position_sigma > 0.0;
  if (guessed) filter.widen(motion.position_sigma, motion.heading_sigma);
  const Placement prior{predicted, range_bias()};
  Match match =
      match_scan(reference(), beams_, prior, filter.scan_covariance().inverse(), predicted, 0.0, Directions::all);

  const Matrix4 belief = filter.scan_covariance();
  const double turned = exact::sqrt(belief(kTheta, kTheta));
  const double moved_by = exact::sqrt(std::max(belief(kX, kX), belief(kY, kY)));
  const bool poor = match.agreement < kPoorAgreement && match.known_hits >= kFewHits;
  if (poor || turned > kSearchAbove) {
    const double least = poor && guessed ? kSearchMost : 0.0;
    const double most = std::clamp(3.0 * motion.position_sigma, kSearchMost, kSearchFarthest);
    const SearchWindow window{std::clamp(3.0 * moved_by, std::max(least, 0.1), most),
                              std::clamp(3.0 * turned, std::max(least, 0.05), kSearchMost)};
    const Pose2D found = search_pose(reference(), beams_, predicted, window);
    PoseFilter wide = filter;
    if (poor) wide.widen(0.5 * window.position, 0.5 * window.heading);
    const Match other =
        match_scan(reference(), beams_, prior, wide.scan_covariance().inverse(), found, 0.0, Directions::all);
    if (other.agreement > match.agreement + (poor ? 0.1 : 0.02)) {
      match = other;
      filter = std::move(wide);
    }
  }
  belief_.match = match;
  belief_.contradicted = is_contradicted(match);
  if (belief_.contradicted) return;

  const Pose2D& pose = match.at.pose;
  const Vector4 moved{pose.x - predicted.x, pose.y - predicted.y, wrap_angle(pose.theta - predicted.theta),
                      match.at.range_bias - prior.range_bias};
  shift(filter.condition(moved, match.information.inverse()), predicted);
}

// Moves the estimate: the pose by moving local_from_odom, the calibration for the steps to come.
void ScanOdometry::shift(const Vector7& by, const Pose2D& from) {
  const Pose2D moved{from.x + by(kX), from.y + by(kY), wrap_angle(from.theta + by(kTheta))};
  belief_.local_from_odom = moved * inverse(belief_.track.point(0).odom_from_base);
  Calibration c = belief_.track.calibration();
  c.forward_scale *= 1.0 + by(kForwardScale);
  c.range_bias += by(kRangeBias);
  belief_.track.calibrate(c);
}

// Odometry has the robot stand: is that where its scan lies, when nothing but the scan counts?
bool ScanOdometry::has_moved() const {
  if (!is_confirmed(belief_.match)) return false;
  const Pose2D here = belief_.local_from_base();
  const Matrix4 prior =
      Vector4(1.0 / square(kFreePrior), 1.0 / square(kFreePrior), 1.0 / square(kFreeTurn), 1.0 / square(kFreeBias))
          .asDiagonal();
  const Match free = match_scan(reference(), beams_, {here, range_bias()}, prior, here, 0.0, Directions::all);
  const Vector3 off(free.at.pose.x - here.x, free.at.pose.y - here.y, wrap_angle(free.at.pose.theta - here.theta));
  const bool far = off.head<2>().norm() > kMoved || std::fabs(off.z()) > kTurned;
  return far && is_confirmed(free) && off.dot(free.told.topLeftCorner<3, 3>() * off) > kMovedChi;
}

// Whether the scan lies where it was found by itself, whatever was expected.
bool ScanOdometry::is_confirmed(const Match& match) const {
  const double enough = std::max<double>(kFewHits, kEnoughKnown * static_cast<double>(hits_of(beams_)));
  return match.known_hits >= enough && match.agreement >= std::max(kPoorAgreement, kLikeUsual * usual_);
}

// Whether the scan does not lie where it was found, by what is known there.
bool ScanOdometry::is_contradicted(const Match& match) const {
  const auto hits = hits_of(beams_);
  const bool few = match.known_hits < kFewHits || match.known_hits < kFewKnown * static_cast<double>(hits);
  if (match.known_hits >= kFewHits && match.agreement < std::max(kNoAgreement, kNoUsual * usual_)) return true;
  return few && hits >= kFewHits && crosses_walls();
}

// Whether most of what is seen lies behind walls, as from another room.
bool ScanOdometry::crosses_walls() const {
  const map::LogOddsMap& map = reference();
  const map::OccupancyGrid& grid = map.grid();
  const double cells = 1.0 / grid.resolution;
  const Pose2D here = belief_.local_from_base();
  const auto passes = [&](const map::Beam& beam) {
    const Vec2 from = here * beam.origin;
    const Vec2 to = here * (beam.origin + std::max(beam.range - kBefore, 0.0) * beam.direction);
    return !walk_grid_line(cells * (from - grid.origin), cells * (to - grid.origin),
                           [&](int x, int y) { return map.log_odds({x, y}) <= 0; });
  };
  const auto crossing = std::ranges::count_if(beams_, [&](const map::Beam& beam) { return beam.hit && passes(beam); });
  return static_cast<double>(crossing) > kThroughWalls * static_cast<double>(hits_of(beams_));
}

// What is to become of the scan, which may be related to those before or not.
void ScanOdometry::judge(bool related) {
  if (pieces_.empty()) return;
  const Match& match = belief_.match;
  if (related && !belief_.contradicted) {
    misfits_ = 0;
    if (match.known_hits >= kFewHits) usual_ += kUsualShare * (match.agreement - usual_);
    return;
  }
  registration_.scan = Registration::Scan::misfit;
  ++misfits_;
  const bool at_once = !related && raw_.has_value();
  if (hits_of(beams_) >= kFewHits && (at_once || misfits_ >= kMaxMisfits)) {
    registration_.scan = Registration::Scan::lost;
    misfits_ = 0;
    pieces_.clear();
  } else {
    beams_.clear();
  }
}

void ScanOdometry::extend_maps() {
  if (registration_.scan == Registration::Scan::misfit) return;
  const Pose2D here = belief_.local_from_base();
  const Pose2D since = inverse(mapped_from_) * here;
  const bool moved = norm(since.position()) > kMappedDistance || std::fabs(since.theta) > kMappedTurn;
  if (!pieces_.empty() && !moved) return;

  const auto age = [this](const Piece& piece) { return driven_ - piece.begun; };
  if (pieces_.size() == 2 && age(pieces_.front()) > kPieceLength) pieces_.erase(pieces_.begin());
  if (pieces_.empty() || age(pieces_.back()) > kPieceLength - kOverlap) {
    pieces_.push_back({map::LogOddsMap({.resolution = kCell, .free_range = kFreeRange}), driven_});
  }
  const std::vector<map::Beam> in_local = filled(transformed(here, beams_), kCell);
  for (Piece& piece : pieces_) piece.map.insert(in_local, range_bias());
  mapped_from_ = here;
}

}  // namespace threewe::slam
