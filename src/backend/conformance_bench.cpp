#include "backend/conformance_bench.hpp"

#include <algorithm>

#include "threewe/core/exact.hpp"

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
  const std::vector<Sample> found = of(SensorType::odometry);
  expect(!found.empty(), "no odometry has arrived");
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
  throw Failure("no scan arrived within 2 s");
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

std::vector<Vec2> hits(const LaserScan& scan, const Pose2D& base_from_lidar) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (range <= 0.0 || range >= scan.range_max - kRounding) continue;
    const auto [sin, cos] = exact::sincos(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
    points.push_back(base_from_lidar * Vec2{range * cos, range * sin});
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
