#include "safety/unseen.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/exact.hpp"
#include "hardware/invalid_beams.hpp"
#include "hardware/parameters.hpp"

namespace threewe::safety {
namespace {

constexpr std::size_t kFewest = 3;  // beams make a gap, by kBridgedBeams
constexpr int kBisections = 12;     // the edge of the margin is found to a tenth of a millimetre
constexpr double kNone = std::numeric_limits<double>::infinity();

double increment_of(std::span<const float> ranges) { return 2.0 * exact::kPi / static_cast<double>(ranges.size()); }

// Where the lidar was when it measured a beam.
Pose2D pose_at_beam(const PlacedScan& scan, double beam) {
  const double share = (beam + 0.5) / static_cast<double>(scan.ranges.size());
  return interpolate(scan.turn.odom_from_lidar_at_first, scan.turn.odom_from_lidar_at_last, share);
}

// A point as a scan's beams have it.
struct Polar {
  double beam = 0.0;   // with a fraction
  double range = 0.0;  // [m]
};
Polar polar(const PlacedScan& scan, Vec2 point) {
  const auto beams = static_cast<double>(scan.ranges.size());
  Polar at{0.5 * beams, 0.0};
  for (int i = 0; i < 2; ++i) {  // the beam tells when, and that tells the beam, more exactly
    const Vec2 seen = inverse(pose_at_beam(scan, at.beam)) * point;
    at = {(exact::atan2(seen.y, seen.x) + exact::kPi) / increment_of(scan.ranges), norm(seen)};
  }
  return at;
}

// Does a valid beam lead past a point so near that nothing thick stands between, and is it longer than `longer`?
bool is_passed(double thin, const PlacedScan& scan, const Polar& at, double longer) {
  const auto n = static_cast<std::ptrdiff_t>(scan.ranges.size());
  const double between = 0.5 * thin / (std::max(at.range, thin) * increment_of(scan.ranges));
  const double beside = std::max(between, kBridgedBeams);
  const auto last = static_cast<std::ptrdiff_t>(std::floor(at.beam + beside));
  for (auto i = static_cast<std::ptrdiff_t>(std::ceil(at.beam - beside)); i <= last; ++i) {
    const auto range = static_cast<double>(scan.ranges[static_cast<std::size_t>((i % n + n) % n)]);
    if (range > 0.0 && range >= longer) return true;
  }
  return false;
}

bool is_free(double thin, const PlacedScan& scan, Vec2 point) {
  const Polar at = polar(scan, point);
  return is_passed(thin, scan, at, at.range);
}

// Can something hide in a gap, other than what is nearer than the lidar can measure?
bool is_blind(const SightModel& model, const InvalidBeams& gap, double increment) {
  const bool near = gap.before > 0.0F && static_cast<double>(std::max(gap.before, gap.after)) < model.near_gap;
  return !near && static_cast<double>(gap.count + 1) * increment * model.reach > model.thin;
}

// A beam, however long.
struct Ray {
  Vec2 origin;
  Vec2 direction;
  Vec2 at(double range) const { return origin + range * direction; }
};

Ray ray_of(const PlacedScan& scan, std::size_t beam) {
  const auto number = static_cast<double>(beam);
  const Pose2D lidar = pose_at_beam(scan, number);
  return {lidar.position(), rotate({1.0, 0.0}, lidar.theta + number * increment_of(scan.ranges) - exact::kPi)};
}

// [m] along a ray to where the robot's margin ends.
double end_of_margin(const SightModel& model, const Pose2D& base_from_odom, const Ray& ray) {
  double inside = 0.0;
  double outside = model.reach;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (inside + outside);
    const bool within = model.footprint.signed_distance(base_from_odom * ray.at(middle)) < model.margin;
    (within ? inside : outside) = middle;
  }
  return outside;
}

}  // namespace

SightModel make_sight_model(const RobotProfile& profile, const GateModel& gate) {
  SightModel model;
  if (!profile.lidar) return model;
  const LidarSpec& lidar = *profile.lidar;
  const auto params = params_for<Params>(profile, "safety").unseen;
  model.thin = params.thin;
  model.step = params.step;
  model.footprint = gate.footprint;
  model.margin = gate.margin;
  model.range_min = lidar.range_min;
  // from one scan's end until what the next one shows has stopped the robot
  const Duration between = gate.reaction + 2 * kControlPeriod + 2 * lidar.turn + lidar.latency;
  const double braking = 0.5 * gate.limits.linear / gate.limits.linear_braking;
  model.reach = gate.footprint.farthest_corner(lidar.base_from_lidar.position()) + gate.margin +
                gate.limits.linear * (to_seconds(between) + braking);
  model.near_gap = near_gap(lidar);
  model.memory = gate.sensor_timeout;
  model.scans = static_cast<std::size_t>(model.memory / lidar.turn) + 2;
  return model;
}

void Sight::forget() {
  scans_.clear();
  unseen_.clear();
}

void Sight::add(const SightModel& model, const ScanTurn& turn, std::span<const float> ranges,
                const Pose2D& odom_from_base) {
  scans_.resize(model.scans);
  newest_ = (newest_ + 1) % model.scans;
  PlacedScan& scan = scans_[newest_];
  scan.turn = turn;
  scan.ranges.assign(ranges.begin(), ranges.end());
  const std::vector<InvalidBeams> gaps = invalid_beams(scan.ranges, kFewest);
  if (gaps.empty()) return unseen_.clear();

  const std::vector<double> doubtful = still_unseen(model.thin, scan);
  unseen_.clear();
  const auto is_known = [&](Vec2 point) {
    return std::ranges::any_of(scans_, [&](const PlacedScan& past) {
      return !past.ranges.empty() && turn.end - past.turn.end <= model.memory && is_free(model.thin, past, point);
    });
  };
  const auto first_unknown = [&](const Ray& ray, double limit) {
    const double least = end_of_margin(model, inverse(odom_from_base), ray);
    double range = std::max(least, model.range_min);
    while (range < std::min(model.reach, limit) && is_known(ray.at(range))) range += model.step;
    return std::max(least, std::min(range, limit));
  };
  for (const InvalidBeams& gap : gaps) {
    if (!is_blind(model, gap, increment_of(scan.ranges))) continue;
    for (std::size_t i = 0; i < gap.count; ++i) {
      const std::size_t beam = (gap.first + i) % scan.ranges.size();
      const Ray ray = ray_of(scan, beam);
      const double range = first_unknown(ray, doubtful[beam]);
      if (range < model.reach) unseen_.push_back(ray.at(range));
    }
  }
}

const PlacedScan* Sight::scan_before(std::size_t count) const {
  if (count >= scans_.size()) return nullptr;
  const PlacedScan& scan = scans_[(newest_ + scans_.size() - count) % scans_.size()];
  return scan.ranges.empty() ? nullptr : &scan;
}

// [m] along each beam to the nearest point that was unknown before, and at which no beam looks now.
std::vector<double> Sight::still_unseen(double thin, const PlacedScan& scan) const {
  std::vector<double> nearest(scan.ranges.size(), kNone);
  for (const Vec2 point : unseen_) {
    const Polar at = polar(scan, point);
    if (is_passed(thin, scan, at, 0.0)) continue;
    double& range = nearest[static_cast<std::size_t>(std::floor(at.beam + 0.5)) % nearest.size()];
    range = std::min(range, at.range);
  }
  return nearest;
}

}  // namespace threewe::safety
