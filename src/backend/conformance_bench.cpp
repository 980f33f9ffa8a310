#include "backend/conformance_bench.hpp"

#include <algorithm>

#include "core/exact.hpp"

namespace threewe::backend::conformance {

namespace {
constexpr Duration kValidity = 200ms;  // as the runtime renews it
constexpr Duration kComeToRest = 1s;   // longer than any braking the profiles allow
constexpr double kRounding = 1e-4;     // [m], of a range kept as a float
}  // namespace

Bench::Bench(std::unique_ptr<World> world) : world_(std::move(world)) {
  expect(world_ != nullptr, "the factory made no world");
  expect(world_->robot_count() > 0, "the world has no robot");
}

void Bench::drive(const Velocity& velocity, Duration duration) {
  for (const Time end = now() + duration; now() < end;) {
    port().command(velocity, now() + kValidity);
    advance(std::min(now() + kControlPeriod, end));
    poll();
  }
}

void Bench::drive_and_stop(const Velocity& velocity, Duration duration) {
  drive(velocity, duration);
  drive({}, kComeToRest);
}

void Bench::wait(Duration duration) {
  for (const Time end = now() + duration; now() < end;) {
    advance(std::min(now() + kControlPeriod, end));
    poll();
  }
}

void Bench::advance(Time t) {
  world_->advance_to(t);
  expect(now() >= t, "advance_to({} s) ended at {} s", to_seconds(t), to_seconds(now()));
}

void Bench::poll() {
  for (Sample& sample : port().poll()) samples_.push_back(std::move(sample));
}

std::vector<Sample> Bench::of_sensor(std::size_t sensor) const {
  std::vector<Sample> found;
  std::copy_if(samples_.begin(), samples_.end(), std::back_inserter(found),
               [sensor](const Sample& sample) { return sample.sensor == sensor; });
  return found;
}

std::vector<Sample> Bench::of(SensorType type) {
  const auto& sensors = features().sensors;
  const auto sensor = std::find_if(sensors.begin(), sensors.end(), [type](const auto& s) { return s.type == type; });
  if (sensor == sensors.end()) return {};
  std::vector<Sample> found = of_sensor(static_cast<std::size_t>(sensor - sensors.begin()));
  for (const Sample& sample : found) {
    expect(sample.data.index() == static_cast<std::size_t>(type), "sensor '{}' delivered another kind of data",
           sensor->name);
  }
  return found;
}

bool Bench::has(SensorType type) { return features().has(type); }

Odometry Bench::odometry() {
  const Time begin = now();
  while (of(SensorType::odometry).empty() && now() < begin + 1s) drive({}, kControlPeriod);
  const std::vector<Sample> found = of(SensorType::odometry);
  if (found.empty()) throw Failure("no odometry has arrived");
  return std::get<Odometry>(found.back().data);
}

LaserScan Bench::next_scan() {
  const Time begin = now();
  while (now() < begin + 2s) {
    drive({}, kControlPeriod);
    const std::vector<Sample> scans = of(SensorType::lidar);
    if (scans.empty()) continue;
    const auto& scan = std::get<LaserScan>(scans.back().data);
    const double span = scan.time_increment * static_cast<double>(scan.ranges.size());
    if (std::min(scans.back().measured, scans.back().measured + from_seconds(span)) >= begin) return scan;
  }
  fail_without_new(SensorType::lidar, begin);
}

void Bench::fail_without_new(SensorType type, Time begin) {
  const std::vector<Sample> samples = of(type);
  expect(!samples.empty(), "no {} sample arrived within 2 s", to_string(type));
  throw Failure(
      fmt::format("{} samples arrive, but none that was measured in the 2 s from {:.2f} s on: the newest is "
                  "stamped {:.2f} s",
                  to_string(type), to_seconds(begin), to_seconds(samples.back().measured)));
}

double Bench::cruise() { return std::min(0.3, profile().operating_limits.linear); }
double Bench::turning() { return std::min(0.8, profile().operating_limits.angular); }

Bench Context::connected() const { return connected(options.seed); }

Bench Context::connected(std::uint64_t seed) const {
  WorldOptions seeded = options;
  seeded.seed = seed;
  Bench bench(make(seeded));
  bench.port().connect();
  return bench;
}

bool hits_something(const LaserScan& scan, std::size_t i) {
  const auto range = static_cast<double>(scan.ranges[i]);
  return range > 0.0 && range < scan.range_max - kRounding;
}

Vec2 point_of(const LaserScan& scan, std::size_t i) {
  const auto [sin, cos] = exact::sincos(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
  return static_cast<double>(scan.ranges[i]) * Vec2{cos, sin};
}

std::vector<Vec2> hits(const LaserScan& scan, const Pose2D& base_from_lidar) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (hits_something(scan, i)) points.push_back(base_from_lidar * point_of(scan, i));
  }
  return points;
}

double misfit(const std::vector<Vec2>& before, const std::vector<Vec2>& after, const Pose2D& before_from_after) {
  double sum = 0.0;
  for (const Vec2 point : after) {
    const Vec2 moved = before_from_after * point;
    double nearest = 0.3;
    for (const Vec2 other : before) nearest = std::min(nearest, distance(moved, other));
    sum += nearest;
  }
  return sum / static_cast<double>(after.size());
}

}  // namespace threewe::backend::conformance
