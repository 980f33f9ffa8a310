// The form of a scan, and whether it sees the robot move the way it moved.
#include <algorithm>
#include <cmath>
#include <limits>

#include "backend/conformance_bench.hpp"
#include "core/exact.hpp"
#include "hardware/sample_checks.hpp"

namespace threewe::backend::conformance {

namespace {

constexpr double kTurn = 2.0 * exact::kPi;

Bench with_lidar(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::lidar), "the robot has no lidar");
  expect(bench.profile().lidar.has_value(), "features() lists a lidar that the profile lacks");
  return bench;
}

/// The scans of a few seconds, at rest and turning.
std::vector<Sample> some_scans(Bench& bench) {
  bench.drive({}, 1s);
  bench.drive({0.0, 0.0, bench.turning()}, 1s);
  std::vector<Sample> scans = bench.of(SensorType::lidar);
  expect(!scans.empty(), "no scan arrived within 2 s");
  return scans;
}

void scan_has_the_profiles_beams(const Context& context) {
  Bench bench = with_lidar(context);
  for (const Sample& sample : some_scans(bench)) {
    const auto beams = static_cast<int>(std::get<LaserScan>(sample.data).ranges.size());
    expect(beams == bench.profile().lidar->beams, "a scan of {} beams; the profile has {}", beams,
           bench.profile().lidar->beams);
  }
}

void scan_limits_are_the_profiles(const Context& context) {
  Bench bench = with_lidar(context);
  const LidarSpec& spec = *bench.profile().lidar;
  for (const Sample& sample : some_scans(bench)) {
    const auto& scan = std::get<LaserScan>(sample.data);
    expect(scan.range_min == spec.range_min && scan.range_max == spec.range_max,
           "a scan from {} to {} m; the profile has {} to {} m", scan.range_min, scan.range_max, spec.range_min,
           spec.range_max);
  }
}

void scan_ranges_are_valid(const Context& context) {
  Bench bench = with_lidar(context);
  for (const Sample& sample : some_scans(bench)) {
    const auto& scan = std::get<LaserScan>(sample.data);
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const auto range = static_cast<double>(scan.ranges[i]);
      const bool within = range >= scan.range_min - kRangeTolerance && range <= scan.range_max + kRangeTolerance;
      expect(range == 0.0 || within, "beam {}: {} m is neither 0 (invalid) nor within {} to {} m", i, range,
             scan.range_min, scan.range_max);
    }
  }
}

void scan_angles_cover_the_turn(const Context& context) {
  Bench bench = with_lidar(context);
  for (const Sample& sample : some_scans(bench)) {
    const auto& scan = std::get<LaserScan>(sample.data);
    const double covered = scan.angle_increment * static_cast<double>(scan.ranges.size());
    expect(std::abs(covered - kTurn) <= 1e-6, "{} beams of {} rad cover {} rad, not one turn counter-clockwise",
           scan.ranges.size(), scan.angle_increment, covered);
    expect(std::abs(scan.angle_min) <= kTurn / 2 + 1e-6, "angle_min is {} rad, outside [-pi, pi]", scan.angle_min);
  }
}

void scan_times_fit_the_turn(const Context& context) {
  Bench bench = with_lidar(context);
  const double turn = to_seconds(bench.profile().lidar->turn);
  for (const Sample& sample : some_scans(bench)) {
    const auto& scan = std::get<LaserScan>(sample.data);
    const double span = scan.time_increment * static_cast<double>(scan.ranges.size());
    expect(span == 0.0 || std::abs(std::abs(span) - turn) <= 0.02 * turn,
           "the beams span {} s; a turn takes {} s (0 for a scan taken at one time)", span, turn);
    const Time last = sample.measured + from_seconds(span - scan.time_increment);
    expect(std::max(sample.measured, last) <= sample.received, "a beam measured at {} s was received at {} s",
           to_seconds(std::max(sample.measured, last)), to_seconds(sample.received));
  }
}

void scan_turns_as_the_device_does(const Context& context) {
  Bench bench = with_lidar(context);
  const bool clockwise = bench.profile().lidar->clockwise;
  for (const Sample& sample : some_scans(bench)) {
    const double increment = std::get<LaserScan>(sample.data).time_increment;
    expect(increment == 0.0 || (increment < 0.0) == clockwise,
           "time_increment is {} s, but the device turns {}clockwise", increment, clockwise ? "" : "counter-");
  }
}

/// The best misfit over headings near that of `guess`, which odometry knows least well.
double best_misfit(const std::vector<Vec2>& before, const std::vector<Vec2>& after, const Pose2D& guess) {
  double best = std::numeric_limits<double>::infinity();
  for (int step = -8; step <= 8; ++step) {
    best = std::min(best, misfit(before, after, {guess.x, guess.y, guess.theta + 0.02 * step}));
  }
  return best;
}

/// What the lidar and the odometry say about one motion.
struct Witnesses {
  std::vector<Vec2> before;
  std::vector<Vec2> after;
  Pose2D motion;  ///< by odometry
};

Witnesses watch(Bench& bench, const Velocity& velocity, double seconds) {
  const Pose2D base_from_lidar = bench.profile().lidar->base_from_lidar;
  Witnesses seen;
  seen.before = hits(bench.next_scan(), base_from_lidar);
  const Pose2D start = bench.odometry().pose;
  bench.drive_and_stop(velocity, from_seconds(seconds));
  seen.after = hits(bench.next_scan(), base_from_lidar);
  seen.motion = inverse(start) * bench.odometry().pose;
  applies_if(std::min(seen.before.size(), seen.after.size()) >= 20, "fewer than 20 beams hit something here");
  return seen;
}

/// A motion that scans may show instead of the one that odometry has, and what that would mean.
struct Mistake {
  Pose2D motion;
  const char* shown = "";
  const char* cause = "";
};

std::vector<Mistake> mistakes(const Pose2D& m) {
  std::vector<Mistake> all{
      {{}, "no motion", "are they new, and of this robot?"},
      {{0.5 * m.x, 0.5 * m.y, 0.5 * m.theta}, "half of it", "are their ranges too short, or is odometry too long?"},
      {{2.0 * m.x, 2.0 * m.y, 2.0 * m.theta}, "twice as much", "are their ranges too long, or is odometry too short?"},
      {inverse(m), "the opposite",
       "do beams come clockwise, are front and back swapped, or has odometry a wrong sign?"}};
  const auto aside = [&m](double angle) {
    const Vec2 there = rotate(m.position(), angle);
    return Pose2D{there.x, there.y, m.theta};
  };
  if (norm(m.position()) > 0.3) {
    all.push_back({aside(0.25 * kTurn), "a motion to the left",
                   "are they turned by 90 degrees: do angle_min and base_from_lidar say where beam 0 points?"});
    all.push_back({aside(-0.25 * kTurn), "a motion to the right",
                   "are they turned by -90 degrees: do angle_min and base_from_lidar say where beam 0 points?"});
  }
  return all;
}

/// The motion as odometry has it must explain the scans better than any mistake does.
void expect_best_fit(const Witnesses& seen, const char* motion) {
  const double fit = best_misfit(seen.before, seen.after, seen.motion);
  double best = std::numeric_limits<double>::infinity();
  Mistake likeliest;
  for (const Mistake& mistake : mistakes(seen.motion)) {
    const double other = best_misfit(seen.before, seen.after, mistake.motion);
    if (other >= best) continue;
    best = other;
    likeliest = mistake;
  }
  expect(fit < best,
         "odometry shows {} by ({:.2f} m, {:.2f} rad), scans show {}, which fits them within {:.3f} m instead "
         "of {:.3f} m: {}",
         motion, seen.motion.x, seen.motion.theta, likeliest.shown, best, fit, likeliest.cause);
}

void lidar_sees_the_robot_drive_forward(const Context& context) {
  Bench bench = with_lidar(context);
  const Witnesses seen = watch(bench, {bench.cruise(), 0.0, 0.0}, 1.0 / bench.cruise());
  expect_best_fit(seen, "driving forward");
}

void lidar_sees_the_robot_turn_left(const Context& context) {
  Bench bench = with_lidar(context);
  const Witnesses seen = watch(bench, {0.0, 0.0, bench.turning()}, 0.6 / bench.turning());
  expect_best_fit(seen, "turning left");
}

constexpr Check kLidarChecks[] = {
    {"scan_has_the_profiles_beams", scan_has_the_profiles_beams},
    {"scan_limits_are_the_profiles", scan_limits_are_the_profiles},
    {"scan_ranges_are_valid", scan_ranges_are_valid},
    {"scan_angles_cover_the_turn", scan_angles_cover_the_turn},
    {"scan_times_fit_the_turn", scan_times_fit_the_turn},
    {"scan_turns_as_the_device_does", scan_turns_as_the_device_does},
    {"lidar_sees_the_robot_drive_forward", lidar_sees_the_robot_drive_forward},
    {"lidar_sees_the_robot_turn_left", lidar_sees_the_robot_turn_left},
};

}  // namespace

std::span<const Check> lidar_checks() { return kLidarChecks; }

}  // namespace threewe::backend::conformance
