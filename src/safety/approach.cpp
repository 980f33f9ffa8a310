#include "safety/approach.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "hardware/parameters.hpp"
#include "threewe/core/grid_index.hpp"

namespace threewe::safety {
namespace {

// Where an earlier scan was taken from, in the lidar's frame of the newest.
struct View {
  Vec2 origin;        // [m]
  double turn = 0.0;  // [rad] from the earlier to the newest
};

// At a share of the turns of the lidar in which they were taken.
View view(const ScanTurn& earlier, double share_of_earlier, const ScanTurn& newest, double share_of_newest) {
  const Pose2D now = interpolate(newest.odom_from_lidar_at_first, newest.odom_from_lidar_at_last, share_of_newest);
  const Pose2D then = interpolate(earlier.odom_from_lidar_at_first, earlier.odom_from_lidar_at_last, share_of_earlier);
  const Pose2D now_from_then = inverse(now) * then;
  return {now_from_then.position(), -now_from_then.theta};
}

// A scan to compare the newest with: from beam to beam, the view changes evenly.
struct Earlier {
  Earlier(const ApproachModel& model, const PlacedScan& compared, const PlacedScan& with)
      : scan(compared),
        newest(with),
        age(to_seconds(with.turn.end - compared.turn.end)),
        way(model.params.least_speed * age),
        begin(view(compared.turn, 0.0, with.turn, 0.0)),
        change(view(compared.turn, 1.0, with.turn, 1.0)) {
    change = {change.origin - begin.origin, wrap_angle(change.turn - begin.turn)};
  }
  View at(double share) const { return {begin.origin + share * change.origin, begin.turn + share * change.turn}; }

  const PlacedScan& scan;
  const PlacedScan& newest;
  double age;  // [s]
  double way;  // [m] that what approaches has come since, at least
  View begin;
  View change;
};

// The scan so many before the newest, or where scans were lost the oldest after it that is not too old.
const PlacedScan* to_compare(const ApproachModel& model, const Sight& sight, std::size_t count) {
  const Time newest = sight.scan_before(0)->turn.end;
  const auto age = [newest](const PlacedScan* scan) { return newest - scan->turn.end; };
  const PlacedScan* scan = sight.scan_before(count);
  while (scan != nullptr && age(scan) > model.params.until) scan = sight.scan_before(--count);
  return scan == nullptr || age(scan) < model.params.since ? nullptr : scan;
}

// A hit of the newest scan.
struct Hit {
  double beam = 0.0;
  double share = 0.0;  // of the turn
  Vec2 direction;
  double range = 0.0;  // [m]
};

// The same place, as the earlier scan has it.
struct Polar {
  double beam = 0.0;
  double range = 0.0;  // [m]
};

Polar seen_from(const View& view, const Hit& hit, double beams_per_radian) {
  const Vec2 d = hit.range * hit.direction - view.origin;
  const double range = exact::sqrt(dot(d, d));
  // the bearing differs by the lidar's turn and by a parallax, whose sine this is
  const double sine = cross(hit.direction, d) / range;
  return {hit.beam + beams_per_radian * (view.turn + sine * (1.0 + sine * sine / 6.0)), range};
}

// Did a beam look hardly farther than a hit is now, along nearly the same bearing? So it is nearly always, and soon
// seen.
bool was_there(const Earlier& then, const View& view, const Hit& hit, double beams_per_radian) {
  const double nearer = dot(view.origin, hit.direction);  // at most; and this by its bearing
  const double aside = beams_per_radian * (view.turn - cross(hit.direction, view.origin) / hit.range);
  const auto beam = to_cell(hit.beam + aside + 0.5);
  if (beam < 0 || std::cmp_greater_equal(beam, then.scan.ranges.size())) return false;
  const auto looked = static_cast<double>(then.scan.ranges[static_cast<std::size_t>(beam)]);
  return looked > 0.0 && looked < hit.range - nearer + then.way;
}

// [m/s] by which a hit has come nearer since an earlier scan, at least; none where that did not look there.
double came_since(const ApproachModel& model, const Earlier& then, const Hit& hit) {
  const std::vector<float>& ranges = then.scan.ranges;
  const auto beams = static_cast<double>(ranges.size());
  const double beams_per_radian = beams / (2.0 * exact::kPi);
  const View evenly = then.at(hit.share);
  if (was_there(then, evenly, hit, beams_per_radian)) return 0.0;
  Polar there = seen_from(evenly, hit, beams_per_radian);
  if (there.beam < 0.0 || there.beam >= beams) {  // that one was measured at the other end of the turn
    const double other = (there.beam + (there.beam < 0.0 ? beams : -beams) + 0.5) / beams;
    there = seen_from(view(then.scan.turn, other, then.newest.turn, hit.share), hit, beams_per_radian);
  }
  const double bearing = std::max(1.0, beams_per_radian * model.params.bearing);
  const auto n = static_cast<std::ptrdiff_t>(ranges.size());
  double before = kInfinity;
  const auto last = static_cast<std::ptrdiff_t>(std::floor(there.beam + bearing));
  for (auto i = static_cast<std::ptrdiff_t>(std::ceil(there.beam - bearing)); i <= last; ++i) {
    const auto looked = static_cast<double>(ranges[static_cast<std::size_t>((i % n + n) % n)]);
    if (looked <= 0.0) continue;
    if (looked < there.range + then.way) return 0.0;
    before = std::min(before, looked);
  }
  return before < kInfinity ? (before - there.range) / then.age : 0.0;
}

}  // namespace

ApproachModel make_approach_model(const RobotProfile& profile, const GateModel& gate) {
  ApproachModel model;
  if (!profile.lidar) return model;
  const LidarSpec& lidar = *profile.lidar;
  model.params = params_for<Params>(profile, "safety").approach;
  for (int i = 0; i < lidar.beams; ++i)
    model.directions.push_back(rotate({1.0, 0.0}, i * (2.0 * exact::kPi / lidar.beams) - exact::kPi));
  model.youngest = static_cast<std::size_t>((model.params.since + lidar.turn - 1ns) / lidar.turn);
  model.oldest = static_cast<std::size_t>(model.params.until / lidar.turn);
  model.range_min = lidar.range_min;
  model.body = gate.footprint.inscribed_radius();
  model.reaction = to_seconds(gate.reaction);
  model.braking = gate.limits.linear_braking;
  model.body_from_lidar = gate.footprint.farthest_corner(lidar.base_from_lidar.position()) + gate.margin;
  model.linear = gate.limits.linear;
  model.acceleration = gate.limits.linear_acceleration;
  model.until_next = to_seconds(2 * lidar.turn + lidar.latency + 2 * kControlPeriod);
  return model;
}

// [m] from the lidar: the body, and the ways until the robot stands, its own and that of what comes, from this scan on
// until the next one shows more.
double reach(const ApproachModel& model, const Velocity& last) {
  const double speed = std::min(exact::hypot(last.vx, last.vy) + model.acceleration * model.until_next, model.linear);
  const double time = model.until_next + model.reaction + speed / model.braking;
  return model.body_from_lidar + time * (speed + model.params.fastest);
}

void Approach::forget() {
  seen_.reset();
  approaching_.clear();
}

void Approach::update(const ApproachModel& model, const Sight& sight, const Velocity& last) {
  const PlacedScan* newest = sight.scan_before(0);
  if (newest == nullptr || newest->ranges.size() != model.directions.size()) return forget();
  const Duration interval = 2 * (model.params.until - model.params.since) / 5;  // more often would tell no more
  if (seen_ && newest->turn.end - *seen_ < interval) return;
  seen_ = newest->turn.end;
  approaching_.clear();
  const PlacedScan* young = to_compare(model, sight, model.youngest);
  const PlacedScan* old = to_compare(model, sight, model.oldest);
  if (young == nullptr || old == nullptr || young == old) return;

  std::optional<std::array<Earlier, 2>> before;  // worth while only where something is near
  std::array<Approaching, kMost> together;       // NOLINT: what is used is filled
  std::size_t count = 0;
  std::size_t run = 0;
  std::size_t beam_before = 0;
  const Vec2 lidar = newest->turn.odom_from_lidar_at_last.position();
  const auto settle = [&] {
    for (std::size_t k = 0; std::cmp_greater_equal(run, model.params.together) && k < count; ++k)
      put(together[k], lidar);
    count = run = 0;
  };
  const auto beams = static_cast<double>(newest->ranges.size());
  const double farthest = reach(model, last);
  for (std::size_t i = 0; i < newest->ranges.size(); ++i) {
    const auto range = static_cast<double>(newest->ranges[i]);
    if (range > farthest || range < model.range_min || range <= 0.0) continue;
    if (!before) before.emplace(std::array{Earlier(model, *young, *newest), Earlier(model, *old, *newest)});
    const auto beam = static_cast<double>(i);
    const Hit hit{beam, (beam + 0.5) / beams, model.directions[i], range};
    double speed = model.params.fastest;
    for (const Earlier& then : *before) {
      speed = std::min(speed, came_since(model, then, hit));
      if (speed < model.params.least_speed) break;
    }
    if (speed < model.params.least_speed || i > beam_before + 2) settle();
    if (speed < model.params.least_speed) continue;
    beam_before = i;
    ++run;
    const Pose2D odom_from_lidar =
        interpolate(newest->turn.odom_from_lidar_at_first, newest->turn.odom_from_lidar_at_last, hit.share);
    if (count < kMost) together[count++] = {odom_from_lidar * (range * hit.direction), speed};
  }
  settle();
}

// Where there is no room left, in place of the farthest.
void Approach::put(const Approaching& hit, Vec2 lidar) {
  if (approaching_.size() < kMost) return approaching_.push_back(hit);
  const auto away = [lidar](const Approaching& it) { return distance(it.position, lidar); };
  Approaching& farthest = *std::ranges::max_element(approaching_, {}, away);
  if (away(hit) < away(farthest)) farthest = hit;
}

void Approach::append_predicted(const ApproachModel& model, const Velocity& last, Vec2 robot, Time now,
                                std::vector<Vec2>& points) const {
  const double stopping = model.reaction + exact::hypot(last.vx, last.vy) / model.braking;
  for (const Approaching& it : approaching()) {
    const Vec2 d = robot - it.position;
    const double way = std::min(it.speed * (stopping + to_seconds(now - *seen_)), norm(d) - model.body);
    if (way > 0.0) points.push_back(it.position + (way / norm(d)) * d);
  }
}

}  // namespace threewe::safety
