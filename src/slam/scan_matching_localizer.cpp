#include "slam/scan_matching_localizer.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <span>
#include <vector>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "map/change_log.hpp"
#include "map/log_odds_map.hpp"
#include "map/scan_hits.hpp"
#include "slam/dead_reckoning.hpp"
#include "slam/global_localizer.hpp"
#include "slam/map_uncertainty.hpp"
#include "slam/online_map.hpp"
#include "slam/pose_filter.hpp"
#include "slam/prior_map.hpp"
#include "slam/range_noise_estimator.hpp"
#include "slam/scan_beams.hpp"
#include "slam/scan_matcher.hpp"

namespace threewe::slam {
namespace {

constexpr double kKeyframeDistance = 0.08;  // [m] the map takes a scan after so much motion ...
constexpr double kKeyframeTurn = 0.07;      // [rad] ... or turning ...
constexpr Duration kKeyframeAge = 1s;       // ... or time
constexpr std::uint64_t kFirstScans = 3;    // all of these make the first map
constexpr Duration kBlindAfter = 500ms;     // without a scan, wheels and gyro go on alone
constexpr Duration kStart = 1s;             // after which the gyro's bias is known
constexpr double kPoorAgreement = 0.6;      // below this the scan seems to be elsewhere
constexpr double kGoodAgreement = 0.7;
constexpr int kFewHits = 30;               // fewer hits in known space tell nothing
constexpr Duration kLostAfter = 2s;        // without a scan that seems to be where it should ...
constexpr double kNoAgreement = 0.35;      // ... and if not even so much of any fits ...
constexpr Duration kLostAtOnceAfter = 1s;  // ... earlier
constexpr double kBiasCreep = 0.004;       // [rad/s] by which a gyro's bias may have changed unnoticed ...
constexpr double kBiasJump = 5.0;          // ... and so many deviations of it are too many
constexpr double kGivenOrigin = 0.02;      // [m] a given map is known so well, from cells and by whoever drew it ...
constexpr double kGivenHeading = 0.006;    // [rad]
constexpr double kToldPosition = 0.25;     // [m] what somebody says of where the robot starts is so good ...
constexpr double kToldHeading = 0.15;      // [rad]
constexpr double kFoundPosition = 0.1;     // [m] ... and what a search finds
constexpr double kFoundHeading = 0.05;     // [rad]
constexpr double kRedrawnPosition = 0.02;  // [m] in a map that was drawn anew the robot's place is known so well
constexpr double kRedrawnHeading = 0.004;  // [rad]
constexpr double kDoubtful = 0.45;         // a given map that resembles the scans less than so for long ...
constexpr double kCertain = 0.55;          // ... until it does again

class ScanMatchingLocalizer final : public Localizer {
 public:
  ScanMatchingLocalizer(const SensorModel& sensors, const InitialState& initial)
      : sensors_(sensors),
        track_({.lateral_scale = sensors.lateral_scale}, sensors.lidar),
        range_noise_(sensors.range_sigma),
        filter_(sensors),
        map_from_start_(initial.map_from_start.value_or(Pose2D{})),
        map_from_odom_(map_from_start_) {
    if (!initial.map) return;
    given_ = std::make_shared<const PriorMap>(*initial.map);
    map_ = OnlineMap(given_->surfaces());
    if (initial.map_from_start) {
      filter_.restart(kToldPosition, kToldHeading);
    } else {
      nowhere_ = true;
      get_lost();
    }
  }

  void add(const Sample& sample) override {
    if (const auto* imu = std::get_if<IMUData>(&sample.data))
      track_.add_gyro(sample.measured, imu->angular_velocity[2]);
    if (const auto* odometry = std::get_if<Odometry>(&sample.data)) {
      track_.add_odometry(sample.measured, *odometry);
      const bool blind = !sensors_.lidar || sample.measured - scanned_ > kBlindAfter;
      if (blind) predict_to(sample.measured);  // no scan will do it
      search_on(sample.measured);
    }
    if (const auto* scan = std::get_if<LaserScan>(&sample.data)) add_scan(sample.measured, *scan);
  }

  PoseEstimate estimate(Time now) const override;
  const map::OccupancyGrid& map() const override { return map_.map().grid(); }
  std::uint64_t map_version() const override { return map_.map().version(); }
  const map::ChangeLog* map_changes() const override { return &map_.map().changes(); }
  std::span<const Vec2> obstacles() const override { return obstacles_; }
  std::unique_ptr<Localizer> clone() const override { return std::make_unique<ScanMatchingLocalizer>(*this); }

 private:
  void add_scan(Time measured, const LaserScan& scan);
  void judge_lidar(const LaserScan& scan);
  Time deskew(Time measured, const LaserScan& scan);
  std::vector<Vec2> what_may_vanish(Vec2 lidar_in_odom, double nearest_seen) const;
  void keep_unseen(const std::vector<Vec2>& nearby);
  void predict_to(Time stamp);
  void learn_gyro_bias(const MotionSummary& motion, Time stamp);
  void find_place(Time stamp);
  void search_on(Time now);
  void doubt(const Pose2D& map_from_base);
  bool is_better(const Pose2D& other, const Pose2D& map_from_base) const;
  void settle(const Pose2D& map_from_base, Time stamp);
  void get_lost();
  void correct(Time stamp);
  bool may_be_elsewhere() const;
  void shift(const Vector7& by, const Pose2D& map_from_base, const Pose2D& odom_from_base);
  void judge(Time stamp, const Match& match);
  void extend_map(Time stamp);
  void follow(const Pose2D& new_from_old);

  SensorModel sensors_;
  DeadReckoning track_;
  RangeNoiseEstimator range_noise_;
  double worse_ = 1.0;  // than its data sheet the lidar is taken to be
  PoseFilter filter_;
  Time filter_stamp_{};  // the filter stands at the newest scan, without a lidar at the newest odometry
  Pose2D map_from_start_;
  Pose2D map_from_odom_;
  OnlineMap map_;
  Pose2D keyframe_;  // map_from_base when the map last took a scan
  Time keyframe_stamp_{};
  MapUncertainty map_uncertainty_;
  double doubtful_turn_ = 0.0;  // [rad] since the scan before
  Time began_{};                // first scan
  Time scanned_{};              // newest one
  bool agrees_ = true;          // the newest scan fits the map
  Time agreed_{};               // when a scan last did ...
  Time resembled_{};            // ... or nearly
  bool lost_ = false;

  std::shared_ptr<const PriorMap> given_;  // null: the robot draws its own map alone
  std::shared_ptr<const PriorMap> home_;   // where a lost robot looks for itself
  std::optional<GlobalLocalizer> finder_;  // while the robot is lost, or doubts its place
  Time searched_{};                        // how far it has searched on
  double trust_ = 1.0;                     // how well the given map has fitted the scans lately
  bool nowhere_ = false;                   // no place was ever known
  bool looked_ = false;                    // a scan has arrived

  std::vector<map::Beam> beams_;  // the newest scan, in the base frame at the end of its turn
  std::vector<Vec2> obstacles_;   // its hits in odom, and what is too near to be seen
  std::size_t seen_ = 0;          // how many of these are hits
};

// One scan: learn how good it is, undo the motion during its turn, carry the belief there, find out where on the map
// that may be, fit it to the map, let the map grow.
void ScanMatchingLocalizer::add_scan(Time measured, const LaserScan& scan) {
  judge_lidar(scan);
  const Time stamp = deskew(measured, scan);
  scanned_ = stamp;
  predict_to(stamp);
  find_place(stamp);
  if (nowhere_) return;
  correct(stamp);
  extend_map(stamp);
}

// A lidar that scatters more than its maker says may be biased more, too. What begins on the way is another thing.
void ScanMatchingLocalizer::judge_lidar(const LaserScan& scan) {
  constexpr double kUsual = 1.2;    // times the scatter of one point is that of beams, of whatever width
  constexpr double kLeast = 0.005;  // [m] where the data sheet promises wonders
  range_noise_.add(scan);
  const double worse = range_noise_.sigma() / (kUsual * std::max(sensors_.range_sigma, kLeast));
  if (track_.has_rolled() || worse <= worse_) return;
  filter_.widen_range_bias(sensors_.range_bias_sigma * exact::sqrt(worse * worse - worse_ * worse_));
  worse_ = worse;
}

// Beams as if all were measured when the turn ended. Returns that time.
Time ScanMatchingLocalizer::deskew(Time measured, const LaserScan& scan) {
  const auto beam_time = [&](std::size_t i) {
    return measured + from_seconds(static_cast<double>(i) * scan.time_increment);
  };
  const std::size_t n = scan.ranges.size();
  const Time end = std::max(measured, n > 0 ? beam_time(n - 1) : measured);
  const Pose2D odom_from_base = track_.at(end);
  const Pose2D base_from_odom = inverse(odom_from_base);

  beams_ = beams_of(scan, scan.range_max,
                    [&](std::size_t i) { return base_from_odom * track_.at(beam_time(i)) * sensors_.base_from_lidar; });
  const double nearest_seen = scan.range_min - track_.calibration().range_bias;
  const std::vector<Vec2> nearby =
      what_may_vanish((odom_from_base * sensors_.base_from_lidar).position(), nearest_seen);
  obstacles_.clear();
  for (const map::Beam& b : beams_) {
    if (b.hit)
      obstacles_.push_back(odom_from_base * (b.origin + (b.range - track_.calibration().range_bias) * b.direction));
  }
  seen_ = obstacles_.size();
  keep_unseen(nearby);
  return end;
}

// Of what is known, that which is nearer than the lidar can see; its scatter would add up from scan to scan.
std::vector<Vec2> ScanMatchingLocalizer::what_may_vanish(Vec2 lidar_in_odom, double nearest_seen) const {
  constexpr double kBlur = 0.03;        // [m] around the least range some beams see and some do not
  constexpr double kNeighbours = 0.08;  // [m]
  const double reach = nearest_seen + kBlur;
  const auto is_unseen = [&](Vec2 p) { return distance(p, lidar_in_odom) < reach; };
  const auto known = std::span(obstacles_);
  std::vector<Vec2> near = map::smoothed_near(lidar_in_odom, reach + kNeighbours, known.first(seen_), lidar_in_odom);
  std::erase_if(near, std::not_fn(is_unseen));
  std::ranges::copy_if(known.subspan(seen_), std::back_inserter(near), is_unseen);
  return near;
}

// What came nearer than the lidar can see is still there.
void ScanMatchingLocalizer::keep_unseen(const std::vector<Vec2>& nearby) {
  constexpr double kSame = 0.01;  // [m] points nearer to each other are one
  for (const Vec2 p : nearby) {
    const auto is_same = [p](Vec2 other) { return distance(p, other) < kSame; };
    const auto kept = obstacles_.begin() + static_cast<std::ptrdiff_t>(seen_);
    if (std::none_of(kept, obstacles_.end(), is_same)) obstacles_.push_back(p);
  }
}

// The belief at the time of the scan, from the odometry since the scan before.
void ScanMatchingLocalizer::predict_to(Time stamp) {
  for (std::size_t age = track_.size(); age-- > 0;) {
    const TrackPoint& p = track_.point(age);
    if (p.stamp <= filter_stamp_ || p.stamp > stamp) continue;
    const double heading = map_from_odom_.theta + p.odom_from_base.theta - 0.5 * p.turn;
    filter_.predict(heading, p.step, p.turn, p.seconds, p.by_gyro);
  }
  const MotionSummary motion = track_.between(filter_stamp_, stamp);
  filter_stamp_ = std::max(filter_stamp_, stamp);
  doubtful_turn_ = motion.doubtful_turn;  // only a scan can tell
  filter_.widen(motion.doubtful_way, motion.doubtful_turn);
  if (motion.at_rest && motion.seconds > 0.0) learn_gyro_bias(motion, stamp);
}

// While the robot stands the gyro shows its bias.
void ScanMatchingLocalizer::learn_gyro_bias(const MotionSummary& motion, Time stamp) {
  const double error = motion.turned / motion.seconds;
  const double variance = sensors_.gyro_sigma * sensors_.gyro_sigma * 0.01 / motion.seconds + 1e-7;
  // a bias creeps; what jumps is a fault, and would be held against the gyro once it is over
  const double known = filter_.covariance()(kGyroBias, kGyroBias) + kBiasCreep * kBiasCreep;
  if (error * error > kBiasJump * kBiasJump * known) return;
  const Pose2D odom_from_base = track_.at(stamp);
  shift(filter_.observe_gyro_bias(error, variance), map_from_odom_ * odom_from_base, odom_from_base);
}

// Looks for a place while there is none, and where the given map does not look like what is seen.
void ScanMatchingLocalizer::find_place(Time stamp) {
  const Pose2D odom_from_base = track_.at(stamp);
  const Pose2D believed = map_from_odom_ * odom_from_base;
  if (!looked_) agreed_ = resembled_ = stamp;
  if (given_ && !looked_ && !nowhere_) {
    const BranchAndBoundMatcher::Window near_told{
        believed, {3.0 * kToldPosition, 3.0 * kToldPosition}, 3.0 * kToldHeading};
    const auto found = given_->search().find(beams_, near_told, kDoubtful);
    if (found && given_->compare(found->pose, beams_).agreement() > kCertain) settle(found->pose, stamp);
  }
  looked_ = true;

  if (given_ && !lost_) doubt(believed);
  if (!finder_) return;
  const std::optional<Pose2D> found = finder_->look(stamp, odom_from_base, beams_);
  if (found && (nowhere_ || is_better(*found, believed))) settle(*found, stamp);
}

// A search of a large map takes longer than a tick: it gets its share of each.
void ScanMatchingLocalizer::search_on(Time now) {
  constexpr Duration kUnit = 50ns;  // for each of these it does the work of one hit, in 3 to 5 ns ...
  constexpr Duration kMost = 20ms;  // ... at most for so long at once
  const Duration since = std::clamp<Duration>(now - searched_, 0ns, kMost);
  searched_ = now;
  if (finder_) finder_->go_on(since / kUnit);
}

// Scans that fit what the robot has mapped by itself say little: it would fit anywhere that it was taken for.
void ScanMatchingLocalizer::doubt(const Pose2D& map_from_base) {
  constexpr double kShare = 0.05;  // of one scan
  const Resemblance seen = given_->compare(map_from_base, beams_);
  if (seen.hits >= kFewHits) trust_ += kShare * (seen.agreement() * (1.0 - seen.contradiction()) - trust_);
  if (trust_ < kDoubtful && !finder_) finder_.emplace(home_ = given_);
  if (trust_ > kCertain) finder_.reset();
}

bool ScanMatchingLocalizer::is_better(const Pose2D& other, const Pose2D& map_from_base) const {
  constexpr double kBetter = 0.15;
  return home_->compare(other, beams_).agreement() > home_->compare(map_from_base, beams_).agreement() + kBetter;
}

// The robot is here. What it has mapped on a given map may have been mapped elsewhere.
void ScanMatchingLocalizer::settle(const Pose2D& map_from_base, Time stamp) {
  map_from_odom_ = map_from_base * inverse(track_.at(stamp));
  filter_.restart(kFoundPosition, kFoundHeading);
  if (given_) map_.begin_again(given_->surfaces());
  finder_.reset();
  nowhere_ = lost_ = false;
  agreed_ = resembled_ = stamp;
  trust_ = 1.0;
}

void ScanMatchingLocalizer::get_lost() {
  lost_ = true;
  map_.break_off();
  map_uncertainty_.forget_way();
  home_ = given_ ? given_ : std::make_shared<const PriorMap>(map());
  finder_.emplace(home_);
}

// Fits the scan to the map; far away first, if it does not fit where it should.
void ScanMatchingLocalizer::correct(Time stamp) {
  const Pose2D odom_from_base = track_.at(stamp);
  if (map_version() == 0) began_ = agreed_ = resembled_ = stamp;
  if (!given_ && !track_.has_rolled() && stamp - began_ < kStart) {
    // it stands where its map begins; of what the gyro has told of a turn its bias is not known yet
    map_from_odom_ = map_from_start_ * inverse(odom_from_base);
    filter_.restart(0.0, 0.0);
    return;
  }
  if (map_version() == 0) return;
  const Pose2D predicted = map_from_odom_ * odom_from_base;
  filter_.widen(0.0005, 0.0002);  // deskewing and stamps are never perfect; also keeps the covariance invertible
  const Placement prior{predicted, track_.calibration().range_bias};
  Match match =
      match_scan(map_.map(), beams_, prior, filter_.scan_covariance().inverse(), predicted, range_noise_.sigma());

  if (match.agreement < kPoorAgreement && match.known_hits >= kFewHits) {
    const SearchWindow window = lost_ ? SearchWindow{0.6, 0.35} : SearchWindow{};
    const Pose2D found = search_pose(map_.map(), beams_, predicted, window);
    PoseFilter wide = filter_;
    wide.widen(0.5 * window.position, 0.5 * window.heading);
    const Match other =
        match_scan(map_.map(), beams_, prior, wide.scan_covariance().inverse(), found, range_noise_.sigma());
    if (other.agreement > match.agreement + 0.15 && may_be_elsewhere()) {
      match = other;
      filter_.widen(0.5 * window.position, 0.5 * window.heading);
    }
  }
  judge(stamp, match);
  if (!agrees_) return;

  const Vector4 moved{match.at.pose.x - predicted.x, match.at.pose.y - predicted.y,
                      wrap_angle(match.at.pose.theta - predicted.theta), match.at.range_bias - prior.range_bias};
  shift(filter_.condition(moved, match.information.inverse()), predicted, odom_from_base);
  const auto hits = std::ranges::count_if(beams_, [](const map::Beam& beam) { return beam.hit; });
  const double known = hits > 0 ? static_cast<double>(match.known_hits) / static_cast<double>(hits) : 1.0;
  // of fewer beams each surface is known less well, too; but the errors of a scan are common to all of its beams
  constexpr double kUsualBeams = 360.0;
  const double fewer = kUsualBeams / static_cast<double>(beams_.size());
  map_uncertainty_.update(match.at.pose.position(),
                          {1.0 - known, range_noise_.sigma(), fewer * fewer * match.told.topLeftCorner<3, 3>()});
}

// Nobody is carried away whose wheels and gyro tell of one motion: a scan that says so is late.
bool ScanMatchingLocalizer::may_be_elsewhere() const { return lost_ || doubtful_turn_ > 0.0 || track_.stands(); }

// Moves the estimate: the pose by moving map_from_odom, the calibration for the steps to come.
void ScanMatchingLocalizer::shift(const Vector7& by, const Pose2D& map_from_base, const Pose2D& odom_from_base) {
  const Pose2D moved{map_from_base.x + by(kX), map_from_base.y + by(kY), wrap_angle(map_from_base.theta + by(kTheta))};
  map_from_odom_ = moved * inverse(odom_from_base);
  Calibration c = track_.calibration();
  c.gyro_bias += by(kGyroBias);
  c.forward_scale *= 1.0 + by(kForwardScale);
  c.lateral_scale *= 1.0 + by(kLateralScale);
  c.range_bias += by(kRangeBias);
  track_.calibrate(c);
}

// Is this scan where we think it is? Lost, when it has not been for long.
void ScanMatchingLocalizer::judge(Time stamp, const Match& match) {
  agrees_ = match.known_hits < kFewHits || match.agreement >= kPoorAgreement - (lost_ ? 0.0 : 0.15);
  if (agrees_) agreed_ = stamp;
  if (lost_ && match.agreement >= kGoodAgreement &&
      home_->compare(match.at.pose, beams_).agreement() >= kGoodAgreement) {
    lost_ = false;
    finder_.reset();
  }
  if (match.known_hits < kFewHits || match.agreement >= kNoAgreement) resembled_ = stamp;
  if (!lost_ && (stamp - agreed_ > kLostAfter || stamp - resembled_ > kLostAtOnceAfter)) get_lost();
}

void ScanMatchingLocalizer::extend_map(Time stamp) {
  if (const std::optional<Pose2D> new_from_old = map_.redraw()) follow(*new_from_old);
  if (!agrees_ || lost_) return;
  const Pose2D map_from_base = map_from_odom_ * track_.at(stamp);
  const Pose2D since = inverse(keyframe_) * map_from_base;
  const bool due = map_version() < kFirstScans || norm(since.position()) > kKeyframeDistance ||
                   std::fabs(since.theta) > kKeyframeTurn || stamp - keyframe_stamp_ >= kKeyframeAge;
  if (!due) return;

  const Matrix3 covariance = filter_.covariance().topLeftCorner<3, 3>();
  map_.insert({stamp, map_from_base, covariance, beams_, track_.calibration().range_bias});
  keyframe_ = map_from_base;
  keyframe_stamp_ = stamp;
}

// A loop has closed, and the map has been drawn anew: the robot is where its surroundings are now.
void ScanMatchingLocalizer::follow(const Pose2D& new_from_old) {
  map_from_odom_ = new_from_old * map_from_odom_;
  keyframe_ = new_from_old * keyframe_;
  filter_.widen(kRedrawnPosition, kRedrawnHeading);
}

PoseEstimate ScanMatchingLocalizer::estimate(Time now) const {
  PoseEstimate e;
  e.stamp = now;
  e.odom_from_base = track_.at(now);
  e.map_from_odom = map_from_odom_;
  if (!track_.empty()) e.velocity = track_.point(0).velocity;
  e.lost = lost_;

  // what odometry added since the scan that the filter stands at
  PoseFilter filter = filter_;
  for (std::size_t age = track_.size(); age-- > 0;) {
    const TrackPoint& p = track_.point(age);
    if (p.stamp <= filter_stamp_) continue;
    const double heading = map_from_odom_.theta + p.odom_from_base.theta - 0.5 * p.turn;
    filter.predict(heading, p.step, p.turn, p.seconds, p.by_gyro);
  }
  // the filter knows the pose in the map; how far the map is off, nobody measures
  Matrix7 covariance = filter.covariance();
  if (lost_) {
    covariance.topLeftCorner<3, 3>().setZero();
    covariance(kX, kX) = home_->spread().x * home_->spread().x;
    covariance(kY, kY) = home_->spread().y * home_->spread().y;
    covariance(kTheta, kTheta) = exact::kPi * exact::kPi / 3.0;
  } else if (given_) {
    covariance(kX, kX) += kGivenOrigin * kGivenOrigin;
    covariance(kY, kY) += kGivenOrigin * kGivenOrigin;
    covariance(kTheta, kTheta) += kGivenHeading * kGivenHeading;
  } else if (map_version() > 0) {
    covariance.topLeftCorner<3, 3>() += map_uncertainty_.covariance();
  }
  std::size_t i = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) e.covariance[i++] = covariance(row, column);
  }
  return e;
}

}  // namespace

std::unique_ptr<Localizer> make_scan_matching_localizer(const SensorModel& sensors, const InitialState& initial) {
  return std::make_unique<ScanMatchingLocalizer>(sensors, initial);
}

}  // namespace threewe::slam
