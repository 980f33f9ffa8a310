// Whether what sensors deliver is as new as their stamps say.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "backend/conformance_bench.hpp"
#include "core/exact.hpp"

namespace threewe::backend::conformance {

namespace {

/// What a stamp may be off by [s]. A robot that turns at 1 rad/s then misplaces what it sees by 0.1 rad.
constexpr double kMostOff = 0.1;
constexpr double kStep = 0.02;                // [s] between the delays that are tried
constexpr int kSteps = 30;                    // of them each way
constexpr double kFarthest = kSteps * kStep;  // [s]

/// The heading over time that a sensor shows: unwrapped, linear between its samples.
struct Headings {
  std::vector<double> times;
  std::vector<double> values;

  void add(double time, double value) {
    times.push_back(time);
    values.push_back(value);
  }
  bool covers(double time) const { return !times.empty() && times.front() <= time && time <= times.back(); }
  double at(double time) const {
    const auto next = std::ranges::upper_bound(times, time);
    const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(next - times.begin(), 1, std::ssize(times) - 1));
    const double share = (time - times[i - 1]) / (times[i] - times[i - 1]);
    return values[i - 1] + share * (values[i] - values[i - 1]);
  }
};

Headings headings_of_odometry(Bench& bench) {
  Headings headings;
  for (const Sample& sample : bench.of(SensorType::odometry)) {
    const double theta = std::get<Odometry>(sample.data).pose.theta;
    const double last = headings.values.empty() ? theta : headings.values.back();
    headings.add(to_seconds(sample.measured), last + wrap_angle(theta - last));
  }
  expect(headings.times.size() >= 2, "{} odometry samples arrived", headings.times.size());
  return headings;
}

Headings headings_of_gyro(Bench& bench) {
  Headings headings;
  double heading = 0.0;
  for (const Sample& sample : bench.of(SensorType::imu)) {
    const double time = to_seconds(sample.measured);
    const double rate = std::get<IMUData>(sample.data).angular_velocity[2];
    if (!headings.times.empty()) heading += rate * (time - headings.times.back());
    headings.add(time, heading);
  }
  expect(headings.times.size() >= 2, "{} IMU readings arrived", headings.times.size());
  return headings;
}

/// Turns left, right and back, so that errors of scale cancel where a delay does not.
void swing(Bench& bench) {
  const double turn = bench.turning();
  bench.drive({0.0, 0.0, turn}, from_seconds(0.6 / turn));
  bench.drive({0.0, 0.0, -turn}, from_seconds(1.2 / turn));
  bench.drive_and_stop({0.0, 0.0, turn}, from_seconds(0.6 / turn));
}

/// The delay [s], of those that are tried, whose `misfit` is the least.
template <typename Misfit>
double best_delay(Misfit misfit) {
  double best = 0.0;
  double least = misfit(0.0);
  for (int step = 1; step <= kSteps; ++step) {
    for (const double signed_delay : {step * kStep, -step * kStep}) {
      const double other = misfit(signed_delay);
      if (other >= least) continue;
      least = other;
      best = signed_delay;
    }
  }
  return best;
}

/// How long after a command a robot of this profile is half on its way to a turn [s].
double answer_time(const RobotProfile& profile, double turn) {
  Duration lag = profile.command_latency + profile.body.motor_lag + kControlPeriod;
  if (profile.body.traction) lag += profile.body.traction->turning_lag;
  return to_seconds(lag) + 0.5 * turn / profile.hardware_limits.angular_acceleration;
}

/// A steady turn, drawn back to where it began, begins when the robot answered.
void odometry_answers_the_command_in_time(const Context& context) {
  constexpr double kMostLate = 0.15;  // [s]
  Bench bench = context.connected();
  bench.drive({}, 500ms);
  const double commanded = to_seconds(bench.now());
  const double resting = headings_of_odometry(bench).values.back();
  bench.drive({0.0, 0.0, bench.turning()}, 2s);
  const Headings seen = headings_of_odometry(bench);
  const double end = seen.times.back();
  const double rate = (seen.at(end) - seen.at(end - 0.5)) / 0.5;
  applies_if(rate > 0.3 * bench.turning(), "odometry does not show the turn: see odometry_turns_left");
  const double answered = end - (seen.at(end) - resting) / rate - commanded;
  const double expected = answer_time(bench.profile(), bench.turning());
  expect(answered <= expected + kMostLate,
         "odometry shows a turn {:.2f} s after its command; by the profile (command_latency, motor_lag, "
         "angular_acceleration) the robot answers after {:.2f} s. Is odometry late, yet stamped as it arrives?",
         answered, expected);
}

void imu_and_odometry_are_of_one_time(const Context& context) {
  constexpr double kExplained = 0.1;  // what is left of a turn's variance where a delay is all that differs
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::imu), "the robot has no IMU");
  bench.drive({}, 1s);
  swing(bench);
  const Headings odometry = headings_of_odometry(bench);
  const Headings gyro = headings_of_gyro(bench);
  const double begin = std::max(odometry.times.front(), gyro.times.front()) + kFarthest;
  const double end = std::min(odometry.times.back(), gyro.times.back()) - kFarthest;
  expect(begin < end, "odometry and IMU have no second in common");
  const auto spread = [&](auto value) {  // about the mean, for a bias is no delay
    double sum = 0.0;
    double squares = 0.0;
    const int count = static_cast<int>((end - begin) / kStep) + 1;
    for (int step = 0; step < count; ++step) {
      const double t = begin + step * kStep;
      sum += value(t);
      squares += value(t) * value(t);
    }
    return squares / count - (sum / count) * (sum / count);
  };
  const auto misfit_by = [&](double by) { return spread([&](double t) { return gyro.at(t + by) - odometry.at(t); }); };
  const double delay = best_delay(misfit_by);
  applies_if(misfit_by(delay) < kExplained * spread([&](double t) { return odometry.at(t); }),
             "gyro and odometry show different turns: see gyro_agrees_with_odometry");
  expect(std::abs(delay) <= kMostOff,
         "the gyro shows each turn {:.2f} s {} than odometry does. Is {} late, yet stamped "
         "as it arrives?",
         std::abs(delay), delay > 0.0 ? "later" : "earlier", delay > 0.0 ? "the IMU" : "odometry");
}

/// Where a scan's beams hit something, in the lidar's frame, and when each was measured [s].
struct TimedHits {
  std::vector<Vec2> points;
  std::vector<double> times;
};

TimedHits timed_hits(const Sample& sample) {
  const auto& scan = std::get<LaserScan>(sample.data);
  TimedHits hits;
  for (std::size_t i = 0; i < scan.ranges.size(); i += 2) {  // half of the beams say enough
    if (!hits_something(scan, i)) continue;
    hits.points.push_back(point_of(scan, i));
    hits.times.push_back(to_seconds(sample.measured) + static_cast<double>(i) * scan.time_increment);
  }
  return hits;
}

/// How badly the scans of a swing fit the one at rest before it, placed by the odometry of `by` seconds later.
double misfit_after(double by, std::span<const TimedHits> scans, const std::vector<Vec2>& before,
                    const Headings& odometry, double resting, const Pose2D& base_from_lidar) {
  std::vector<Vec2> placed;
  for (const TimedHits& scan : scans) {
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const double turned = odometry.at(scan.times[i] + by) - resting;
      placed.push_back(Pose2D{0.0, 0.0, turned} * (base_from_lidar * scan.points[i]));
    }
  }
  return misfit(before, placed, {});
}

void lidar_and_odometry_are_of_one_time(const Context& context) {
  constexpr std::size_t kScans = 6;
  constexpr double kExplained = 0.05;  // [m], what is worse has another cause than a delay
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::lidar), "the robot has no lidar");
  expect(bench.profile().lidar.has_value(), "features() lists a lidar that the profile lacks");
  const Pose2D mount = bench.profile().lidar->base_from_lidar;
  bench.drive({}, 1s);
  const std::vector<Vec2> before = hits(bench.next_scan(), mount);
  applies_if(before.size() >= 20, "fewer than 20 beams hit something here");
  const double resting = headings_of_odometry(bench).values.back();
  const double begin = to_seconds(bench.now());
  swing(bench);

  const Headings odometry = headings_of_odometry(bench);
  std::vector<TimedHits> scans;
  for (const Sample& sample : bench.of(SensorType::lidar)) {
    const double measured = to_seconds(sample.measured);
    const double moving = 2.4 / bench.turning();
    if (measured > begin + 0.2 && measured < begin + moving) scans.push_back(timed_hits(sample));
  }
  applies_if(scans.size() >= 2, "fewer than two scans arrived during a turn");
  std::vector<TimedHits> some;
  for (std::size_t i = 0; i < kScans; ++i) some.push_back(scans[i * (scans.size() - 1) / (kScans - 1)]);
  const auto misfit_by = [&](double by) { return misfit_after(by, some, before, odometry, resting, mount); };
  const double delay = best_delay([&](double by) { return misfit_by(-by); });
  const double explained = misfit_by(-delay);
  applies_if(explained <= kExplained, "scans and odometry show different turns: see lidar_sees_the_robot_turn_left");
  if (std::abs(delay) <= kMostOff || misfit_by(0.0) < explained + 0.01) return;  // a round place looks alike
  throw Failure(
      fmt::format("scans show each turn {:.2f} s {} than odometry does. Is {} late, yet stamped as it arrives "
                  "(`measured` is the time of beam 0)?",
                  std::abs(delay), delay > 0.0 ? "later" : "earlier", delay > 0.0 ? "the lidar" : "odometry"));
}

/// Fails where more than a fifth of the samples, while the robot turns, hold what the one before held.
template <typename Data, typename Same>
void expect_new(Bench& bench, SensorType type, Same same) {
  const std::vector<Sample> samples = bench.of(type);
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    repeated += same(std::get<Data>(samples[i - 1].data), std::get<Data>(samples[i].data)) ? 1U : 0U;
  }
  expect(5 * repeated <= samples.size(),
         "sensor '{}': {} of {} samples taken of a turning robot hold the same as the one before, to the bit. Is each "
         "delivered again under a new stamp?",
         bench.features().sensors[samples.empty() ? 0 : samples.front().sensor].name, repeated, samples.size());
}

void each_sample_is_new(const Context& context) {
  Bench bench = context.connected();
  bench.drive({0.0, 0.0, bench.turning()}, 1s);
  bench.forget();
  bench.drive({0.0, 0.0, bench.turning()}, 1500ms);
  expect_new<Odometry>(bench, SensorType::odometry,
                       [](const Odometry& a, const Odometry& b) { return a.pose == b.pose; });
  expect_new<LaserScan>(bench, SensorType::lidar, [](const LaserScan& a, const LaserScan& b) {
    std::size_t hit = 0;
    for (std::size_t i = 0; i < a.ranges.size(); ++i) hit += hits_something(a, i) ? 1U : 0U;
    return hit >= 20 && a.ranges == b.ranges;
  });
}

constexpr Check kDelayChecks[] = {
    {"each_sample_is_new", each_sample_is_new},
    {"odometry_answers_the_command_in_time", odometry_answers_the_command_in_time},
    {"imu_and_odometry_are_of_one_time", imu_and_odometry_are_of_one_time},
    {"lidar_and_odometry_are_of_one_time", lidar_and_odometry_are_of_one_time},
};

}  // namespace

std::span<const Check> delay_checks() { return kDelayChecks; }

}  // namespace threewe::backend::conformance
