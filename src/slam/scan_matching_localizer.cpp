#include "slam/scan_matching_localizer.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "core/exact.hpp"
#include "map/change_log.hpp"
#include "map/log_odds_map.hpp"
#include "slam/front_end.hpp"
#include "slam/global_localizer.hpp"
#include "slam/localization_state.hpp"
#include "slam/map_uncertainty.hpp"
#include "slam/obstacle_points.hpp"
#include "slam/online_map.hpp"
#include "slam/prior_map.hpp"

namespace threewe::slam {
namespace {

class ScanMatchingLocalizer final : public Localizer {
 public:
  ScanMatchingLocalizer(const SensorModel& sensors, const InitialState& initial, const SharedParams& params)
      : params_(params),
        p_(params->localization),
        sensors_(sensors),
        front_(sensors, params, initial.map_from_start.value_or(Pose2D{})),
        map_from_start_(initial.map_from_start.value_or(Pose2D{})),
        map_(params),
        map_uncertainty_(params->map_uncertainty),
        obstacles_(params->obstacles) {
    if (!initial.map) return;
    prior_ = std::make_shared<const PriorMap>(*initial.map, params);
    map_ = OnlineMap(prior_->surfaces(), params);
    if (initial.map_from_start) {
      front_.set_pose(map_from_start_, p_.initial_position, p_.initial_heading);
    } else {
      change_state(LocalizationEvent::misfits);
    }
  }

  void add(const Sample& sample) override {
    if (const auto* imu = std::get_if<IMUData>(&sample.data))
      front_.add_gyro(sample.measured, imu->angular_velocity[2]);
    if (const auto* odometry = std::get_if<Odometry>(&sample.data)) {
      front_.add_odometry(sample.measured, *odometry);
      const bool blind = !sensors_.lidar || sample.measured - scanned_ > p_.blind_after;
      if (blind) front_.predict_to(sample.measured);  // no scan will do it
      search_on(sample.measured);
    }
    if (const auto* scan = std::get_if<LaserScan>(&sample.data)) add_scan(sample.measured, *scan);
  }

  PoseEstimate estimate(Time now) const override;
  const map::OccupancyGrid& map() const override { return map_.map().grid(); }
  std::uint64_t map_version() const override { return map_.map().version(); }
  const map::ChangeLog* map_changes() const override { return &map_.map().changes(); }
  std::span<const Vec2> obstacles() const override { return obstacles_.points(); }
  std::unique_ptr<Localizer> clone() const override { return std::make_unique<ScanMatchingLocalizer>(*this); }

 private:
  void add_scan(Time measured, const LaserScan& scan);
  void find_place();
  bool find_place_near_start();
  void search_on(Time now);
  void doubt();
  bool is_better(const Pose2D& other) const;
  void settle(const Pose2D& map_from_base);
  bool stands_at_start() const;
  void correct();
  void update_map_uncertainty();
  void judge();
  void extend_map();
  void change_state(LocalizationEvent event);
  bool lost() const { return state_ == LocalizationState::lost || state_ == LocalizationState::relocating; }
  bool has_pose() const { return !lost() || agreed_.has_value(); }
  Matrix3 covariance() const;

  SharedParams params_;
  Params::Localization p_;
  SensorModel sensors_;
  FrontEnd front_;
  Pose2D map_from_start_;
  OnlineMap map_;
  MapUncertainty map_uncertainty_;
  ObstaclePoints obstacles_;

  LocalizationState state_ = LocalizationState::tracking;
  Time began_{};                           // first scan
  Time scanned_{};                         // newest one
  std::optional<Time> agreed_;             // when a scan last fitted the map; empty until the robot is placed in it ...
  std::optional<Time> resembled_;          // ... or nearly
  std::shared_ptr<const PriorMap> prior_;  // null: the robot draws its own map alone
  std::shared_ptr<const PriorMap> search_map_;  // where a lost robot is searched for
  std::optional<GlobalLocalizer> finder_;       // while it is not tracked
  Time searched_{};                             // how far it has searched on
  double trust_ = 1.0;                          // how well the prior map has fitted the scans lately
};

// One scan: undo the motion during its turn, carry the belief there, find out where on the map that may be, fit it to
// the map, let the map grow.
void ScanMatchingLocalizer::add_scan(Time measured, const LaserScan& scan) {
  scanned_ = end_of(measured, scan);
  front_.add_scan(measured, scan, scanned_, scan.range_max);
  const Pose2D odom_from_base = front_.track().at(scanned_);
  obstacles_.update(front_.beams(), front_.range_bias(), odom_from_base,
                    (odom_from_base * sensors_.base_from_lidar).position(), scan.range_min - front_.range_bias());
  front_.predict_to(scanned_);
  find_place();
  if (!has_pose()) return;
  correct();
  extend_map();
}

// Searches for the robot while it is lost, and where the prior map does not look like what is seen.
void ScanMatchingLocalizer::find_place() {
  const bool first = has_pose() && !agreed_;
  if (first) agreed_ = resembled_ = scanned_;
  if (first && prior_) find_place_near_start();
  if (prior_ && !lost()) doubt();
  if (!finder_) return;
  const Pose2D odom_from_base = front_.track().at(scanned_);
  const std::optional<Pose2D> found = finder_->look(scanned_, odom_from_base, front_.beams());
  change_state(finder_->has_candidate() ? LocalizationEvent::candidate_found : LocalizationEvent::candidate_rejected);
  if (found && (!has_pose() || is_better(*found))) settle(*found);
}

// The initial pose may be off.
bool ScanMatchingLocalizer::find_place_near_start() {
  const double reach = 3.0 * p_.initial_position;
  const BranchAndBoundMatcher::Window near_start{front_.map_from_base(), {reach, reach}, 3.0 * p_.initial_heading};
  const Params::Registration& p = params_->registration;
  const auto found = prior_->search().find(front_.beams(), near_start, p.least_agreement);
  if (!found || prior_->compare(found->pose, front_.beams()).agreement() <= p.poor_agreement) return false;
  settle(found->pose);
  return true;
}

// A search of a large map takes longer than a tick: it gets its share of each.
void ScanMatchingLocalizer::search_on(Time now) {
  constexpr Duration kUnit = 50ns;  // for each of these it does the work of one hit, in 3 to 5 ns ...
  constexpr Duration kMost = 20ms;  // ... at most for so long at once
  const Duration since = std::clamp<Duration>(now - searched_, 0ns, kMost);
  searched_ = now;
  if (!finder_) return;
  finder_->go_on(since / kUnit);
  if (finder_->has_candidate()) change_state(LocalizationEvent::candidate_found);
}

// Scans that fit what the robot has mapped by itself say little: it would fit anywhere that it was taken for.
void ScanMatchingLocalizer::doubt() {
  const Resemblance seen = prior_->compare(front_.map_from_base(), front_.beams());
  if (seen.hits >= params_->registration.few_hits)
    trust_ += p_.doubt_share * (seen.agreement() * (1.0 - seen.contradiction()) - trust_);
  if (trust_ < p_.doubtful_prior) change_state(LocalizationEvent::prior_contradicts);
  if (trust_ > p_.certain_prior) change_state(LocalizationEvent::prior_agrees);
}

bool ScanMatchingLocalizer::is_better(const Pose2D& other) const {
  const auto agreement = [this](const Pose2D& pose) { return search_map_->compare(pose, front_.beams()).agreement(); };
  return agreement(other) > agreement(front_.map_from_base()) + params_->registration.better_poor;
}

// The robot is here. What it has mapped on a prior map may have been mapped elsewhere.
void ScanMatchingLocalizer::settle(const Pose2D& map_from_base) {
  front_.set_pose(map_from_base, p_.found_position, p_.found_heading);
  if (prior_) map_.begin_again(prior_->surfaces());
  change_state(LocalizationEvent::relocalized);
  agreed_ = resembled_ = scanned_;
  trust_ = 1.0;
}

// A robot that is not tracked is searched for in the whole map.
void ScanMatchingLocalizer::change_state(LocalizationEvent event) {
  const LocalizationState before = std::exchange(state_, next_state(state_, event));
  if (state_ == before) return;
  if (state_ == LocalizationState::tracking) finder_.reset();
  if (state_ == LocalizationState::doubting) finder_.emplace(search_map_ = prior_, params_);
  if (event != LocalizationEvent::misfits) return;
  map_.break_off();
  map_uncertainty_.forget_way();
  search_map_ = prior_ ? prior_ : std::make_shared<const PriorMap>(map(), params_);
  finder_.emplace(search_map_, params_);
}

// The robot has not moved since its own map began; of what the gyro has measured its bias is not known yet.
bool ScanMatchingLocalizer::stands_at_start() const {
  return !prior_ && !front_.track().has_rolled() && scanned_ - began_ < p_.start;
}

// Fits the scan to the map.
void ScanMatchingLocalizer::correct() {
  if (map_version() == 0) began_ = *(agreed_ = resembled_ = scanned_);
  if (stands_at_start()) return front_.set_pose(map_from_start_, 0.0, 0.0);
  if (map_version() == 0) return;
  front_.match(map_.map(), {.lost = lost()});
  judge();
  if (!front_.fits() || front_.holds()) return;
  front_.update();
  update_map_uncertainty();
}

void ScanMatchingLocalizer::update_map_uncertainty() {
  // of fewer beams each surface is known less well, too; but the errors of a scan are common to all of its beams
  constexpr double kUsualBeams = 360.0;
  const double fewer = kUsualBeams / static_cast<double>(front_.beams().size());
  const Match& match = front_.newest_match();
  const auto hits = static_cast<double>(front_.hits());
  const double known = hits > 0.0 ? static_cast<double>(match.known_hits) / hits : 1.0;
  map_uncertainty_.update(match.at.pose.position(), {1.0 - known, front_.range_noise(),
                                                     fewer * fewer * match.scan_information.topLeftCorner<3, 3>()});
}

// Is this scan where we think it is? Lost, when none has been for long.
void ScanMatchingLocalizer::judge() {
  const Match& match = front_.newest_match();
  const Params::Registration& p = params_->registration;
  if (front_.fits()) agreed_ = scanned_;
  // in a corridor most beams fit along all of it: what fits here must not fit better elsewhere
  if (lost() && match.agreement >= p.good_agreement &&
      search_map_->compare(match.at.pose, front_.beams()).agreement() >= p.good_agreement &&
      finder_->found_best(match.at.pose, front_.track().at(scanned_))) {
    change_state(LocalizationEvent::recognised);
    trust_ = 1.0;
  }
  if (match.known_hits < p.few_hits || match.agreement >= p_.lost_agreement) resembled_ = scanned_;
  if (lost()) return;
  if (scanned_ - *agreed_ > p_.lost_after || scanned_ - *resembled_ > p_.lost_at_once_after)
    change_state(LocalizationEvent::misfits);
}

void ScanMatchingLocalizer::extend_map() {
  if (const std::optional<Pose2D> new_from_old = map_.redraw())
    front_.move_map(*new_from_old, p_.redrawn_position, p_.redrawn_heading);
  if (!front_.fits() || lost() || !front_.is_due(map_version())) return;
  map_.insert({scanned_, front_.map_from_base(), front_.covariance().topLeftCorner<3, 3>(), front_.beams(),
               front_.range_bias(), front_.range_noise()});
  front_.set_mapped();
}

PoseEstimate ScanMatchingLocalizer::estimate(Time now) const {
  const DeadReckoning& track = front_.track();
  PoseEstimate e;
  e.stamp = now;
  e.odom_from_base = track.at(now);
  e.map_from_odom = front_.map_from_odom();
  if (!track.empty()) e.velocity = track.point(0).velocity;
  e.state = state_;
  const Matrix3 of_pose = covariance();
  std::size_t i = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) e.covariance[i++] = of_pose(row, column);
  }
  return e;
}

// The filter knows the pose in the map; how far the map is off, is not measured.
Matrix3 ScanMatchingLocalizer::covariance() const {
  const auto square = [](double x) { return x * x; };
  if (lost()) {
    const Vec2 spread = search_map_->spread();
    return Vector3(square(spread.x), square(spread.y), exact::kPi * exact::kPi / 3.0).asDiagonal();
  }
  Matrix3 covariance = front_.newest_covariance().topLeftCorner<3, 3>();
  if (prior_) {
    covariance +=
        Matrix3(Vector3(square(p_.prior_position), square(p_.prior_position), square(p_.prior_heading)).asDiagonal());
  } else if (map_version() > 0) {
    covariance += map_uncertainty_.covariance();
  }
  return covariance;
}

}  // namespace

std::unique_ptr<Localizer> make_scan_matching_localizer(const SensorModel& sensors, const InitialState& initial,
                                                        const SharedParams& params) {
  return std::make_unique<ScanMatchingLocalizer>(sensors, initial, params);
}

}  // namespace threewe::slam
