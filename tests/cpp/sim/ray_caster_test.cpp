// The ray caster against its slow, obvious twin that tries every shape, on every vector target of this machine.
#include "sim/ray_caster.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "core/exact.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "sim/ray_caster_visibility.hpp"

namespace threewe::sim {
namespace {

using scene::Circle;
using scene::Segment;
using scene::Slice;

constexpr double kPi = exact::kPi;
constexpr double kTolerance = 1e-4;  // [m]
constexpr double kGraze = 1e-5;      // [rad]

void add_box(Slice& slice, Vec2 middle, double length, double width, double angle) {
  const Pose2D pose{middle.x, middle.y, wrap_angle(angle)};
  const Vec2 half{0.5 * length, 0.5 * width};
  const Vec2 corners[4] = {pose * Vec2{-half.x, -half.y}, pose * Vec2{half.x, -half.y}, pose * half,
                           pose * Vec2{-half.x, half.y}};
  for (int i = 0; i < 4; ++i) slice.segments.push_back({corners[i], corners[(i + 1) % 4], -1});
}

// Outer walls, inner walls with doorways, furniture at any angle, table legs.
Slice office(Draw& draw, double size) {
  Slice slice;
  add_box(slice, {size / 2, 0.0}, size, 0.2, 0.0);
  add_box(slice, {size / 2, size}, size, 0.2, 0.0);
  add_box(slice, {0.0, size / 2}, 0.2, size, 0.0);
  add_box(slice, {size, size / 2}, 0.2, size, 0.0);
  for (int i = draw.whole(0, 6); i > 0; --i) {
    const double door = draw(1.0, size - 2.0);
    const double at = draw(1.0, size - 1.0);
    const bool along_x = draw.whole(0, 1) == 0;
    for (const auto& [from, to] : {std::pair{0.0, door}, std::pair{door + 0.9, size}}) {
      const Vec2 middle = along_x ? Vec2{0.5 * (from + to), at} : Vec2{at, 0.5 * (from + to)};
      add_box(slice, middle, to - from, 0.1, along_x ? 0.0 : kPi / 2);
    }
  }
  for (int i = draw.whole(5, 40); i > 0; --i) {
    const double angle = draw.whole(0, 1) == 0 ? 0.0 : draw(-kPi, kPi);
    add_box(slice, draw.point(0.0, size), draw(0.02, 1.5), draw(0.02, 0.8), angle);
  }
  for (int i = draw.whole(0, 20); i > 0; --i) slice.circles.push_back({draw.point(0.0, size), draw(0.01, 0.4), -1});
  return slice;
}

// What no scene should contain but some will: specks, slivers, coinciding and collinear faces, stars, single faces.
Slice oddities(Draw& draw, double size) {
  Slice slice;
  for (int i = 0; i < 8; ++i)
    add_box(slice, draw.point(0.0, size), draw(1e-6, 1e-3), draw(1e-6, 1e-3), draw(-kPi, kPi));
  for (int i = 0; i < 4; ++i) add_box(slice, draw.point(0.0, size), draw(1.0, 5.0), 1e-5, draw(-kPi, kPi));
  for (int i = 0; i < 4; ++i) {
    const Vec2 middle = draw.point(0.0, size);
    add_box(slice, middle, 1.0, 0.5, 0.0);
    add_box(slice, middle, 1.0, 0.5, 0.0);                    // the same again
    add_box(slice, middle + Vec2{1.0, 0.0}, 1.0, 0.5, 0.0);   // side by side
    add_box(slice, middle + Vec2{0.25, 0.5}, 0.5, 0.5, 0.0);  // on top of half of it
  }
  for (int i = 0; i < 10; ++i) {
    const Vec2 a = draw.point(0.0, size);
    const Vec2 step{draw(-0.5, 0.5), draw(-0.5, 0.5)};
    slice.segments.push_back({a, a, -1});
    for (int k = 0; k < 3; ++k) slice.segments.push_back({a + k * step, a + (k + 1) * step, -1});
  }
  Vec2 corners[10];  // not convex
  const Vec2 middle = draw.point(0.0, size);
  for (int k = 0; k < 10; ++k) {
    const auto [s, c] = exact::sincos(k * kPi / 5);
    corners[k] = middle + (k % 2 ? 0.4 : 1.0) * Vec2{c, s};
  }
  for (int k = 0; k < 10; ++k) slice.segments.push_back({corners[k], corners[(k + 1) % 10], -1});
  slice.circles.push_back({draw.point(0.0, size), 0.0, -1});
  slice.circles.push_back({draw.point(0.0, size), 1e-4, -1});
  slice.circles.push_back({draw.point(0.0, size), 2.0, -1});
  return slice;
}

struct Sweep {
  Pose2D begin;
  Pose2D end;
  double angle_min;
  double angle_increment;
  int count;
};

std::vector<float> cast(const RayCaster& caster, const Sweep& sweep, const MovingShapes& moving = {}) {
  std::vector<float> ranges(static_cast<std::size_t>(sweep.count));
  caster.cast_rolling(sweep.begin, sweep.end, sweep.angle_min, sweep.angle_increment, ranges, moving);
  return ranges;
}

// Counts beams that differ from the twin. A beam that grazes an end may have any range of the twin's nearby.
struct Comparison {
  int beams = 0;
  int grazing = 0;
  int wrong = 0;
  double worst = 0.0;
  std::string first_wrong;

  void compare(const Slice& slice, const Sweep& sweep, double range_max, const std::vector<float>& ranges) {
    for (int i = 0; i < sweep.count; ++i) {
      const Pose2D pose = interpolate(sweep.begin, sweep.end, static_cast<double>(i) / sweep.count);
      const double turn = wrap_angle(sweep.end.theta - sweep.begin.theta);
      const double angle = sweep.begin.theta + i * (turn / sweep.count) + sweep.angle_min + i * sweep.angle_increment;
      const double range = static_cast<double>(ranges[static_cast<std::size_t>(i)]);
      const double truth = cast_ray(slice, pose.position(), angle, range_max);
      ++beams;
      if (std::fabs(range - truth) <= kTolerance) {
        worst = std::max(worst, std::fabs(range - truth));
        continue;
      }
      double low = truth;
      double high = truth;
      for (int k = -20; k <= 20; ++k) {
        const double near = cast_ray(slice, pose.position(), angle + k * (kGraze / 20), range_max);
        low = std::min(low, near);
        high = std::max(high, near);
      }
      if (grazes(slice, pose.position(), angle) && range >= low - kTolerance && range <= high + kTolerance) {
        ++grazing;
        continue;
      }
      ++wrong;
      if (first_wrong.empty()) {
        first_wrong = "beam " + std::to_string(i) + ": " + std::to_string(range) + " m, truly " + std::to_string(truth);
      }
    }
  }

  static bool grazes(const Slice& slice, Vec2 origin, double angle) {
    const auto near = [&](Vec2 point) {
      const Vec2 d = point - origin;
      return std::fabs(wrap_angle(std::atan2(d.y, d.x) - angle)) <= kGraze;
    };
    const auto touches = [&](const Circle& circle) {
      const Vec2 d = circle.center - origin;
      const double half = std::asin(std::min(1.0, circle.radius / norm(d)));
      return std::fabs(std::fabs(wrap_angle(std::atan2(d.y, d.x) - angle)) - half) <= kGraze;
    };
    return std::ranges::any_of(slice.segments, [&](const Segment& s) { return near(s.a) || near(s.b); }) ||
           std::ranges::any_of(slice.circles, touches);
  }
};

// One pose and a sweep on the way, of whole turns and of parts, either way round.
Sweep random_sweep(Draw& draw, double size) {
  Sweep sweep{};
  const Vec2 position = draw.point(0.0, size);
  sweep.begin = {position.x, position.y, draw(-kPi, kPi)};
  sweep.end = sweep.begin;
  const int kind = draw.whole(0, 3);
  sweep.count = kind == 0 ? 64 : kind == 1 ? 360 : kind == 2 ? 45 : draw.whole(1, 500);
  const double fan = kind == 2 ? 2 * kPi / 10 : kind == 3 ? draw(0.1, 2 * kPi) : 2 * kPi;
  sweep.angle_increment = (draw.whole(0, 1) ? 1 : -1) * fan / sweep.count;
  sweep.angle_min = draw(-kPi, kPi);
  return sweep;
}

void set_in_motion(Sweep& sweep, Draw& draw) {
  const double seconds = 0.1 * std::fabs(sweep.count * sweep.angle_increment) / (2 * kPi);
  const Velocity velocity{draw(-1.2, 1.2), draw(-1.2, 1.2), draw(-3.0, 3.0)};
  sweep.end = interpolate(sweep.begin, integrate(sweep.begin, velocity, seconds), 1.0);
}

TEST_CASE("one pose in random offices") {
  Comparison comparison;
  for (std::uint64_t seed = 0; seed < cases(150); ++seed) {
    Draw draw(seed);
    const double size = draw(4.0, 30.0);
    const Slice slice = office(draw, size);
    const double range_max = draw(2.0, 30.0);
    const RayCaster caster(slice, range_max);
    for (int k = 0; k < 20; ++k) {
      const Sweep sweep = random_sweep(draw, size);
      comparison.compare(slice, sweep, range_max, cast(caster, sweep));
      INFO("seed ", seed, ", pose ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
  MESSAGE(comparison.beams, " beams, ", comparison.grazing, " grazing, worst error ", comparison.worst, " m");
}

TEST_CASE("on the way through random offices, each beam from its own origin") {
  Comparison comparison;
  for (std::uint64_t seed = 1000; seed < 1100; ++seed) {
    Draw draw(seed);
    const double size = draw(4.0, 20.0);
    const Slice slice = office(draw, size);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 20; ++k) {
      Sweep sweep = random_sweep(draw, size);
      set_in_motion(sweep, draw);
      comparison.compare(slice, sweep, 12.0, cast(caster, sweep));
      INFO("seed ", seed, ", pose ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
  MESSAGE(comparison.beams, " beams, ", comparison.grazing, " grazing, worst error ", comparison.worst, " m");
}

TEST_CASE("within reach ranges are the same to the bit, and none beyond it comes nearer") {
  std::size_t within = 0;
  for (std::uint64_t seed = 4000; seed < 4100; ++seed) {
    Draw draw(seed);
    const double size = draw(4.0, 30.0);
    const Slice slice = seed % 4 == 0 ? oddities(draw, size) : office(draw, size);
    const RayCaster caster(slice, 30.0);
    for (int k = 0; k < 20; ++k) {
      Sweep sweep = random_sweep(draw, size);
      if (k % 2 == 0) set_in_motion(sweep, draw);
      const std::vector<float> all = cast(caster, sweep);
      const double reach = draw(0.0, 5.0);
      std::vector<float> near(all.size());
      caster.cast_rolling(sweep.begin, sweep.end, sweep.angle_min, sweep.angle_increment, near, {}, reach);
      for (std::size_t i = 0; i < all.size(); ++i) {
        INFO("seed ", seed, ", sweep ", k, ", beam ", i);
        const bool in_reach = static_cast<double>(all[i]) <= reach;
        within += in_reach ? 1 : 0;
        REQUIRE((in_reach ? near[i] == all[i] : static_cast<double>(near[i]) > reach));
      }
    }
  }
  CHECK(within > 10'000);
}

TEST_CASE("clearance is the distance to the nearest shape, or a little less, and nothing is hit within it") {
  std::size_t found = 0;
  for (std::uint64_t seed = 4200; seed < 4300; ++seed) {
    Draw draw(seed);
    const double size = draw(4.0, 30.0);
    const Slice slice = office(draw, size);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 50; ++k) {
      INFO("seed ", seed, ", point ", k);
      const Pose2D sensor = draw.pose(-1.0, size + 1.0);
      const double most = draw(0.05, 3.0);
      double nearest = most;
      for (const Segment& segment : slice.segments)
        nearest = std::min(nearest, distance_to_segment(sensor.position(), segment.a, segment.b));
      for (const Circle& circle : slice.circles)
        nearest = std::min(nearest, distance(sensor.position(), circle.center) - circle.radius);
      const double clearance = caster.clearance(sensor.position(), most);
      // inside a solid, its own faces are seen from no cell
      std::vector<float> ranges(90);
      caster.cast(sensor, 0.0, 2.0 * kPi / 90.0, ranges);
      REQUIRE(clearance <= static_cast<double>(*std::ranges::min_element(ranges)) + kTolerance);
      if (clearance > nearest) continue;
      found += clearance < most ? 1 : 0;
      REQUIRE(clearance >= nearest - 1e-3);
    }
  }
  CHECK(found > 1000);
}

TEST_CASE("degenerate shapes") {
  Comparison comparison;
  for (std::uint64_t seed = 2000; seed < 2150; ++seed) {
    Draw draw(seed);
    const Slice slice = oddities(draw, 8.0);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 10; ++k) {
      Sweep sweep = random_sweep(draw, 8.0);
      if (k % 2) set_in_motion(sweep, draw);
      comparison.compare(slice, sweep, 12.0, cast(caster, sweep));
      INFO("seed ", seed, ", pose ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
  MESSAGE(comparison.beams, " beams, ", comparison.grazing, " grazing, worst error ", comparison.worst, " m");
}

TEST_CASE("close to a wall, along a wall, and exactly at corners") {
  Comparison comparison;
  for (std::uint64_t seed = 3000; seed < 3100; ++seed) {
    Draw draw(seed);
    const Slice slice = office(draw, 10.0);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 20; ++k) {
      Sweep sweep = random_sweep(draw, 10.0);
      const auto last = static_cast<int>(slice.segments.size()) - 1;
      const Segment& wall = slice.segments[static_cast<std::size_t>(draw.whole(0, last))];
      const Vec2 along = wall.b - wall.a;
      const Vec2 out = (1.0 / norm(along)) * Vec2{along.y, -along.x};
      const double gap = std::exp(draw(std::log(1e-3), std::log(0.3)));
      const Vec2 beside = wall.a + draw(0.0, 1.0) * along + gap * out;
      sweep.begin.x = sweep.end.x = k % 2 ? beside.x : sweep.begin.x;
      sweep.begin.y = sweep.end.y = k % 2 ? beside.y : sweep.begin.y;
      if (k % 4 < 2) {  // beam 0 at a corner, or along the wall
        const Vec2 target = (k % 2 ? beside + along : wall.a) - sweep.begin.position();
        sweep.angle_min = exact::atan2(target.y, target.x) - sweep.begin.theta;
      }
      if (k % 8 > 5) set_in_motion(sweep, draw);
      comparison.compare(slice, sweep, 12.0, cast(caster, sweep));
      INFO("seed ", seed, ", pose ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
  MESSAGE(comparison.beams, " beams, ", comparison.grazing, " grazing, worst error ", comparison.worst, " m");
}

// Single precision alone would be off by millimetres here.
TEST_CASE("far along a wall that is seen almost edge-on") {
  const Pose2D corridor{3.0, 4.0, 0.7};  // at an angle: along an axis nothing cancels
  Slice slice;
  add_box(slice, corridor * Vec2{0.0, -0.5}, 60.0, 1.0, 0.7);
  add_box(slice, corridor * Vec2{0.0, 2.5}, 60.0, 1.0, 0.7);
  add_box(slice, corridor * Vec2{31.0, 1.0}, 1.0, 10.0, 0.7);
  slice.circles.push_back({corridor * Vec2{0.0, -50.0}, 49.9, -1});
  const RayCaster caster(slice, 30.0);
  Comparison comparison;
  for (std::uint64_t seed = 3500; seed < 3900; ++seed) {
    Draw draw(seed);
    const double gap = draw(0.01, 0.5);
    Sweep sweep{corridor * Pose2D{draw(-20.0, 20.0), gap, 0.0}, {}, 0.0, 0.0, 200};
    sweep.end = sweep.begin;
    if (seed % 4 > 1) sweep.end.x += draw(0.0, 0.01), sweep.end.y += draw(0.0, 0.01);
    sweep.angle_min = -gap / draw(5.0, 15.0);
    sweep.angle_increment = -sweep.angle_min / 150;
    if (seed % 2) sweep.angle_min = kPi - sweep.angle_min, sweep.angle_increment = -sweep.angle_increment;
    comparison.compare(slice, sweep, 30.0, cast(caster, sweep));
    INFO("seed ", seed, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }
  MESSAGE(comparison.beams, " beams, worst error ", comparison.worst, " m");
}

TEST_CASE("people and robots that move are met like anything else") {
  Comparison comparison;
  for (std::uint64_t seed = 4000; seed < 4100; ++seed) {
    Draw draw(seed);
    const Slice slice = office(draw, 10.0);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 10; ++k) {
      Slice others;
      for (int i = draw.whole(0, 40); i > 0; --i)
        others.circles.push_back({draw.point(0.0, 10.0), draw(0.05, 0.3), -1});
      for (int i = draw.whole(0, 9); i > 0; --i) add_box(others, draw.point(0.0, 10.0), 0.25, 0.22, draw(-kPi, kPi));
      Slice all = slice;
      all.segments.insert(all.segments.end(), others.segments.begin(), others.segments.end());
      all.circles.insert(all.circles.end(), others.circles.begin(), others.circles.end());
      Sweep sweep = random_sweep(draw, 10.0);
      if (k % 2) set_in_motion(sweep, draw);
      comparison.compare(all, sweep, 12.0, cast(caster, sweep, {others.segments, others.circles}));
      INFO("seed ", seed, ", pose ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
}

TEST_CASE("from outside the walls, and where there is nothing at all") {
  Draw draw(5000);
  const Slice slice = office(draw, 10.0);
  const RayCaster caster(slice, 12.0);
  Comparison comparison;
  for (int k = 0; k < 100; ++k) {
    Sweep sweep = random_sweep(draw, 10.0);
    sweep.begin.x = sweep.end.x = sweep.begin.x * 3.0 - 10.0;
    sweep.begin.y = sweep.end.y = sweep.begin.y * 3.0 - 10.0;
    if (k % 2) sweep.end.x += 5.0;  // in through one wall, and perhaps out again
    comparison.compare(slice, sweep, 12.0, cast(caster, sweep));
    INFO("pose ", k, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }

  const RayCaster empty(Slice{}, 12.0);
  std::vector<float> ranges(360);
  empty.cast({1.0, 2.0, 3.0}, 0.0, 2 * kPi / 360, ranges);
  CHECK(std::ranges::count(ranges, 12.0F) == 360);
  empty.cast({}, 0.0, 0.1, {});
}

TEST_CASE("no return is exactly the greatest range") {
  Slice slice;
  slice.circles.push_back({{5.0, 0.0}, 1.0, -1});
  const RayCaster caster(slice, 6.7);
  std::vector<float> ranges(4);
  caster.cast({}, 0.0, kPi / 2, ranges);
  CHECK(ranges[0] == doctest::Approx(4.0F));
  for (std::size_t i = 1; i < 4; ++i) CHECK(ranges[i] == static_cast<float>(6.7));
}

TEST_CASE("clockwise is counter-clockwise read backwards, to rounding") {
  Draw draw(6000);
  const Slice slice = office(draw, 10.0);
  const RayCaster caster(slice, 12.0);
  for (int k = 0; k < 50; ++k) {
    const Vec2 p = draw.point(0.0, 10.0);
    const double angle = draw(-kPi, kPi);
    std::vector<float> left(360);
    std::vector<float> right(360);
    caster.cast({p.x, p.y, 0.3}, angle, 2 * kPi / 360, left);
    caster.cast({p.x, p.y, 0.3}, angle + 359 * (2 * kPi / 360), -2 * kPi / 360, right);
    int different = 0;
    for (std::size_t i = 0; i < 360; ++i) different += std::fabs(left[i] - right[359 - i]) > 1e-4F ? 1 : 0;
    CHECK(different <= 1);
  }
}

TEST_CASE("sweeps that join make the scan of one") {
  Draw draw(7000);
  const Slice slice = office(draw, 10.0);
  const RayCaster caster(slice, 12.0);
  for (int k = 0; k < 50; ++k) {
    Sweep whole = random_sweep(draw, 10.0);
    whole.count = 450;
    whole.angle_increment = -2 * kPi / 450;
    set_in_motion(whole, draw);
    const auto expected = cast(caster, whole);
    int different = 0;
    for (int part = 0; part < 10; ++part) {
      Sweep sweep = whole;
      sweep.begin = interpolate(whole.begin, whole.end, 0.1 * part);
      sweep.end = interpolate(whole.begin, whole.end, 0.1 * (part + 1));
      sweep.angle_min = whole.angle_min + 45 * part * whole.angle_increment;
      sweep.count = 45;
      const auto ranges = cast(caster, sweep);
      for (std::size_t i = 0; i < 45; ++i) {
        different += std::fabs(ranges[i] - expected[45 * static_cast<std::size_t>(part) + i]) > 1e-4F ? 1 : 0;
      }
    }
    CHECK(different <= 1);
  }
}

// Everything that the kernel does, in bits.
std::vector<float> all_kinds_of_ranges() {
  std::vector<float> all;
  for (std::uint64_t seed = 8000; seed < 8040; ++seed) {
    Draw draw(seed);
    const Slice slice = seed % 4 ? office(draw, 10.0) : oddities(draw, 10.0);
    const RayCaster caster(slice, 12.0);
    for (int k = 0; k < 20; ++k) {
      Slice others;
      others.circles.push_back({draw.point(0.0, 10.0), 0.25, -1});
      add_box(others, draw.point(0.0, 10.0), 0.25, 0.22, draw(-kPi, kPi));
      Sweep sweep = random_sweep(draw, 10.0);
      if (k % 2) set_in_motion(sweep, draw);
      const auto ranges = cast(caster, sweep, {others.segments, others.circles});
      all.insert(all.end(), ranges.begin(), ranges.end());
    }
  }
  return all;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST_CASE("the same bits on every target") {
  const auto expected = all_kinds_of_ranges();
  const auto targets = available_targets();
  for (const std::string& target : targets) {
    force_target(target);
    REQUIRE(active_target() == target);
    CAPTURE(target);
    CHECK(same_bits(all_kinds_of_ranges(), expected));
    force_target("");
  }
  if (targets.size() < 2) MESSAGE("not shown: this machine has one target only");
  MESSAGE(targets.size(), " targets executed");
}

TEST_CASE("the same bits on every thread") {
  const auto expected = all_kinds_of_ranges();
  std::vector<std::vector<float>> results(3);
  std::vector<std::thread> threads;
  for (auto& result : results) threads.emplace_back([&result] { result = all_kinds_of_ranges(); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) CHECK(same_bits(result, expected));
}

TEST_CASE("nothing that can be seen is missing from a cell's set") {
  std::size_t listed = 0;
  std::size_t possible = 0;
  for (std::uint64_t seed = 9000; seed < 9040; ++seed) {
    Draw draw(seed);
    const Slice slice = seed % 4 ? office(draw, 8.0) : oddities(draw, 8.0);
    const CellGrid grid = covering_grid(slice);
    const auto sets = potentially_visible_sets(slice, grid, 12.0);
    for (int cell = 0; cell < grid.count(); ++cell) {
      const VisibleSet& set = sets[static_cast<std::size_t>(cell)];
      listed += set.segments.size();
      possible += slice.segments.size();
      Slice seen;
      for (const int i : set.segments) seen.segments.push_back(slice.segments[static_cast<std::size_t>(i)]);
      for (const int i : set.circles) seen.circles.push_back(slice.circles[static_cast<std::size_t>(i)]);
      for (int k = 0; k < 60; ++k) {
        // anywhere in the cell, often at its very edge; any direction, often at a corner
        const auto place = [&] { return k % 3 ? draw(-0.5, 0.5) : 0.5 * draw.whole(-1, 1); };
        const Vec2 origin = grid.center(cell) + CellGrid::kSize * Vec2{place(), place()};
        const auto last = static_cast<int>(slice.segments.size()) - 1;
        const Vec2 corner = slice.segments[static_cast<std::size_t>(draw.whole(0, last))].a - origin;
        const double angle = k % 2 ? draw(-kPi, kPi) : exact::atan2(corner.y, corner.x) + draw(-1e-9, 1e-9);
        CAPTURE(seed);
        CAPTURE(cell);
        REQUIRE(cast_ray(seen, origin, angle, 12.0) == cast_ray(slice, origin, angle, 12.0));
      }
    }
  }
  MESSAGE("sets hold ", 100.0 * static_cast<double>(listed) / static_cast<double>(possible), " % of all segments");
}

TEST_CASE("what a wall hides is left out") {
  Slice slice;
  add_box(slice, {5.0, 5.0}, 0.2, 10.0, 0.0);  // a wall from bottom to top
  add_box(slice, {9.0, 5.0}, 0.5, 0.5, 0.3);   // a box on the right
  slice.circles.push_back({{8.0, 3.0}, 0.3, -1});
  add_box(slice, {1.0, 5.0}, 0.5, 0.5, 0.3);  // a box on the left
  const CellGrid grid = covering_grid(slice);
  const auto sets = potentially_visible_sets(slice, grid, 20.0);
  const VisibleSet& left = sets[static_cast<std::size_t>(grid.cell({3.0, 5.0}))];
  CHECK(left.circles.empty());
  for (const int i : left.segments) CHECK((i < 4 || i >= 8));
  CHECK(std::ranges::count_if(left.segments, [](int i) { return i < 4; }) == 1);  // one face of the wall
  CHECK(std::ranges::count_if(left.segments, [](int i) { return i >= 8; }) >= 1);
}

}  // namespace
}  // namespace threewe::sim
