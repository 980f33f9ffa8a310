// What it costs to look for people in one scan: three who walk past the robot in office_v2, seen ten times a second.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "perception/people_tracker.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

namespace {

using namespace threewe;

// One turn: the office, and three pairs of legs.
LaserScan look(const scene::Slice& office, double t) {
  LaserScan scan;
  scan.angle_min = -exact::kPi;
  scan.angle_increment = 2.0 * exact::kPi / 360.0;
  scan.time_increment = -0.1 / 360.0;
  scan.range_min = 0.02;
  scan.range_max = 12.0;
  for (int i = 0; i < 360; ++i) {
    const double angle = scan.angle_min + i * scan.angle_increment;
    double range = scene::cast_ray(office, {}, angle, scan.range_max);
    for (int person = 0; person < 6; ++person) {
      const int row = person / 2;
      const Vec2 leg{1.5 * std::sin(0.5 * t + row), 1.0 + 0.5 * row + 0.2 * (person % 2)};
      const Vec2 d{std::cos(angle), std::sin(angle)};
      const double aside = cross(d, leg);
      if (dot(d, leg) > 0.0 && std::fabs(aside) < 0.062)
        range = std::min(range, dot(d, leg) - std::sqrt(0.062 * 0.062 - aside * aside));
    }
    scan.ranges.push_back(static_cast<float>(range));
  }
  return scan;
}

void BM_people_tracker(benchmark::State& state) {
  const scene::Slice office = scene::Scene::load("office_v2").at_height(0.135);
  std::vector<LaserScan> scans;
  for (int i = 0; i < 200; ++i) scans.push_back(look(office, 0.1 * i));
  perception::PeopleTracker tracker;
  Time now{};
  std::size_t next = 0;
  const auto see = [&] {
    tracker.update(scans[next], now, now + 100ms, {}, {});
    now += 100ms;
    next = (next + 1) % scans.size();
  };
  for (int i = 0; i < 40; ++i) see();
  const std::size_t people = tracker.people(now).size();
  for (auto _ : state) see();
  state.counters["people"] = static_cast<double>(people);
}
BENCHMARK(BM_people_tracker)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
