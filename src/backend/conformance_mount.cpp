// Whether sensors sit where the profile says, and look past the robot itself.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

Bench with_lidar(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::lidar), "the robot has no lidar");
  expect(bench.profile().lidar.has_value(), "features() lists a lidar that the profile lacks");
  return bench;
}

/// Of each beam, whether it ends within the robot's outline or just beside it.
std::vector<bool> ends_at_the_robot(const LaserScan& scan, const RobotProfile& profile) {
  constexpr double kBeside = 0.05;  // [m]
  std::vector<bool> ends(scan.ranges.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Vec2 point = profile.lidar->base_from_lidar * point_of(scan, i);
    ends[i] = hits_something(scan, i) && profile.body.footprint.signed_distance(point) < kBeside;
  }
  return ends;
}

/// What is there at whichever heading turns with the robot, and so is the robot.
void the_lidar_does_not_hit_the_robot(const Context& context) {
  constexpr int kHeadings = 4;
  constexpr int kMostMissed = 1;  // of them, by a beam that met nothing
  Bench bench = with_lidar(context);
  std::vector<int> times;
  LaserScan scan;
  for (int heading = 0; heading < kHeadings; ++heading) {
    scan = bench.next_scan();
    const std::vector<bool> ends = ends_at_the_robot(scan, bench.profile());
    times.resize(ends.size());
    for (std::size_t i = 0; i < ends.size(); ++i) times[i] += ends[i] ? 1 : 0;
    bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(0.5 / bench.turning()));
  }
  const auto always = [](int n) { return n >= kHeadings - kMostMissed; };
  const auto first = std::ranges::find_if(times, always);
  if (first == times.end()) return;
  const auto i = static_cast<std::size_t>(first - times.begin());
  const Vec2 point = bench.profile().lidar->base_from_lidar * point_of(scan, i);
  throw Failure(
      fmt::format("{} of {} beams end at the robot itself, whichever way it stands: beam {} at ({:.2f}, {:.2f}) m of "
                  "the base. Does "
                  "the lidar see its own robot? What it sees of it must be 0 (invalid), or range_min beyond it",
                  std::ranges::count_if(times, always), times.size(), i, point.x, point.y));
}

/// Where the lidar would be by two scans around a turn on the spot: a lidar that is `off` from where it is thought
/// moves what it sees by (R - 1) off.
struct Fit {
  Vec2 off;
  double misfit = 0.0;
};

/// The least misfit over all headings near that of odometry, which may be off.
double misfit_with(Vec2 off, const std::vector<Vec2>& before, const std::vector<Vec2>& after, double turned) {
  double best = 1.0;
  for (int step = -5; step <= 5; ++step) {
    const double theta = turned + 0.03 * step;
    const Vec2 moved = rotate(off, theta) - off;
    best = std::min(best, misfit(before, after, {moved.x, moved.y, theta}));
  }
  return best;
}

Fit fit_mount(const std::vector<Vec2>& before, const std::vector<Vec2>& after, double turned) {
  Fit best{{}, misfit_with({}, before, after, turned)};
  for (const double step : {0.04, 0.01}) {
    const Vec2 middle = best.off;
    for (int x = -4; x <= 4; ++x) {
      for (int y = -4; y <= 4; ++y) {
        const Vec2 off = middle + Vec2{step * x, step * y};
        const double other = misfit_with(off, before, after, turned);
        if (other < best.misfit) best = {off, other};
      }
    }
  }
  return best;
}

void the_lidar_is_where_the_profile_says(const Context& context) {
  constexpr double kMostOff = 0.03;    // [m]
  constexpr double kExplained = 0.08;  // [m], what is worse has another cause
  constexpr double kEvidence = 0.02;   // [m] that the scans must fit better there: along a corridor, any place will do
  Bench bench = with_lidar(context);
  const Pose2D mount = bench.profile().lidar->base_from_lidar;
  const std::vector<Vec2> before = hits(bench.next_scan(), mount);
  const double start = bench.odometry().pose.theta;
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(2.8 / bench.turning()));
  const std::vector<Vec2> all = hits(bench.next_scan(), mount);
  applies_if(std::min(before.size(), all.size()) >= 20, "fewer than 20 beams hit something here");
  std::vector<Vec2> after;
  for (std::size_t i = 0; i < all.size(); i += 3) after.push_back(all[i]);

  const double turned = wrap_angle(bench.odometry().pose.theta - start);
  const double as_stated = misfit_with({}, before, after, turned);
  const Fit fit = fit_mount(before, after, turned);
  applies_if(fit.misfit <= kExplained, "scans do not show the turn: see lidar_sees_the_robot_turn_left");
  expect(norm(fit.off) <= kMostOff || as_stated < fit.misfit + kEvidence,
         "by scans before and after a turn of {:.1f} rad the lidar is at ({:.2f}, {:.2f}) m of the base; the profile's "
         "base_from_lidar says ({:.2f}, {:.2f}). Is a sign wrong, is the lidar turned, or does it sit elsewhere?",
         turned, mount.x + fit.off.x, mount.y + fit.off.y, mount.x, mount.y);
}

constexpr Check kMountChecks[] = {
    {"the_lidar_does_not_hit_the_robot", the_lidar_does_not_hit_the_robot},
    {"the_lidar_is_where_the_profile_says", the_lidar_is_where_the_profile_says},
};

}  // namespace

std::span<const Check> mount_checks() { return kMountChecks; }

}  // namespace threewe::backend::conformance
