// Path lengths agree with a visibility graph around the same obstacles.
#include "scene/geodesic.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "core/exact.hpp"
#include "draw.hpp"
#include "scene/cell_lines.hpp"
#include "scene/occupancy.hpp"
#include "scene/random_solids.hpp"

namespace threewe::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const GridFrame kFrame{{-4.0, -4.0}, 0.05, 160, 160};

CellSet passable_cells(const std::vector<Solid>& solids, double radius) {
  const Obstacles obstacles(solids);
  return cells_with_clearance(obstacles, distance_field(occupied_cells(kFrame, solids)), radius);
}

bool cross_each_other(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  return cross(b - a, c - a) * cross(b - a, d - a) < 0.0 && cross(d - c, a - c) * cross(d - c, b - c) < 0.0;
}

double clearance_of_segment(const Solid& solid, Vec2 a, Vec2 b) {
  if (solid.shape == Solid::Shape::disc) return distance_to_segment(solid.center, a, b) - solid.radius;
  double nearest = std::min(distance_to(solid, a), distance_to(solid, b));
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 c = solid.corners[i];
    nearest = std::min(nearest, distance_to_segment(c, a, b));
    if (cross_each_other(a, b, c, solid.corners[(i + 1) % 4])) return 0.0;
  }
  return nearest;
}

// Shortest paths of a disc among solids, by Dijkstra's algorithm over points close around the solids that see each
// other. Rounded corners are replaced by circumscribed polygons: lengths are at most 0.3 % too long.
class VisibilityGraph {
 public:
  VisibilityGraph(const std::vector<Solid>& solids, double radius) : solids_(solids), radius_(radius) {
    for (const Solid& s : solids) {
      if (s.shape == Solid::Shape::disc) add_arc(s.center, s.radius + radius);
      if (s.shape == Solid::Shape::box) {
        for (const Vec2 corner : s.corners) add_arc(corner, radius);
      }
    }
  }

  double length(Vec2 from, Vec2 to) {
    std::vector<Vec2> points = points_;
    points.insert(points.end(), {from, to});
    std::vector<double> length(points.size(), kInfinity);
    std::vector<char> known(points.size(), 0);
    length[points.size() - 2] = 0.0;
    while (true) {
      std::size_t next = points.size();
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!known[i] && length[i] < kInfinity && (next == points.size() || length[i] < length[next])) next = i;
      }
      if (next == points.size() || next == points.size() - 1) return length.back();
      known[next] = 1;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double through = length[next] + distance(points[next], points[i]);
        if (!known[i] && through < length[i] && sees(points[next], points[i])) length[i] = through;
      }
    }
  }

 private:
  bool sees(Vec2 a, Vec2 b) const {
    return a == b || std::ranges::all_of(
                         solids_, [&](const Solid& s) { return clearance_of_segment(s, a, b) >= radius_ - 1e-9; });
  }

  void add_arc(Vec2 center, double radius) {
    constexpr int kPoints = 32;
    for (int i = 0; i < kPoints; ++i) {
      const Vec2 p = center + rotate({radius / exact::cos(exact::kPi / kPoints), 0.0}, 2.0 * exact::kPi * i / kPoints);
      const bool free =
          std::ranges::all_of(solids_, [&](const Solid& s) { return distance_to(s, p) >= radius_ - 1e-9; });
      if (free) points_.push_back(p);
    }
  }

  const std::vector<Solid>& solids_;
  double radius_;
  std::vector<Vec2> points_;
};

TEST_CASE("lengths are within 2 % of a visibility graph's") {
  double worst = 0.0;
  double sum = 0.0;
  int detours = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const double radius = dice.in(0.08, 0.2);
    const std::vector<Solid> solids = random_solids(dice, 14, 2.0);
    const CellSet passable = passable_cells(solids, radius);
    VisibilityGraph graph(solids, radius);
    // a gap that the disc just fits through may be closed on the grid, but never one that is a cell wider
    VisibilityGraph roomy(solids, radius + kFrame.resolution);

    const Vec2 target{dice.in(-3.0, 3.0), dice.in(-3.0, 3.0)};
    if (!passable[kFrame.cell(target)]) continue;
    const GeodesicField field(passable, target);
    for (int i = 0; i < 12; ++i) {
      const Vec2 from{dice.in(-3.5, 3.5), dice.in(-3.5, 3.5)};
      if (!passable[kFrame.cell(from)]) continue;
      const double length = field.length_from(from);
      const double shortest = graph.length(from, target);
      CHECK(length >= 0.99 * shortest - 0.01);
      if (shortest == kInfinity) continue;
      const double longest = roomy.length(from, target);
      CHECK(length <= 1.02 * longest + 0.01);
      if (longest > 1.01 * shortest || distance(from, target) > 0.999 * shortest) continue;
      ++detours;
      worst = std::max(worst, std::abs(length / shortest - 1.0));
      sum += std::abs(length / shortest - 1.0);
    }
  }
  MESSAGE("worst error ", 100.0 * worst, " %, mean ", 100.0 * sum / detours, " % over ", detours,
          " paths around corners");
  CHECK(detours > 40);
  CHECK(worst <= 0.02);
}

TEST_CASE("along a clear line the length is the distance, from both ends") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const CellSet everywhere(kFrame, 1);
    const Vec2 a{dice.in(-3.9, 3.9), dice.in(-3.9, 3.9)};
    const Vec2 b{dice.in(-3.9, 3.9), dice.in(-3.9, 3.9)};
    if (seed < 20) CHECK(GeodesicField(everywhere, a).length_from(b) == distance(a, b));
    CHECK(walk_line(kFrame, a, b, [](CellIndex) { return true; }));
  }
}

TEST_CASE("the length is the same in both directions, and no shorter than the distance") {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const CellSet passable = passable_cells(random_solids(dice, 14, 3.0), 0.11);
    const Vec2 a{dice.in(-3.5, 3.5), dice.in(-3.5, 3.5)};
    const Vec2 b{dice.in(-3.5, 3.5), dice.in(-3.5, 3.5)};
    const double there = GeodesicField(passable, b).length_from(a);
    const double back = GeodesicField(passable, a).length_from(b);
    CHECK((there < kInfinity) == (back < kInfinity));
    if (there == kInfinity) continue;
    CHECK(there >= distance(a, b));
    CHECK(there == doctest::Approx(back).epsilon(0.01));
  }
}

TEST_CASE("there is no path through a wall, out of the grid, nor from within a wall") {
  const std::vector<Solid> wall = {make_box({0.0, 0.0, 0.5 * exact::kPi}, 9.0, 0.4)};
  const CellSet passable = passable_cells(wall, 0.11);
  const GeodesicField field(passable, {-2.0, 0.0});
  CHECK(field.length_from({-1.0, 1.0}) < 2.0);
  CHECK(field.length_from({1.0, 1.0}) == kInfinity);
  CHECK(field.length_from({0.0, 1.0}) == kInfinity);
  CHECK(field.length_from({-20.0, 1.0}) == kInfinity);
  CHECK(GeodesicField(passable, {0.0, 0.0}).length_from({-1.0, 0.0}) == kInfinity);
}

TEST_CASE("a limit saves work and changes no length below it") {
  Dice dice(7);
  const CellSet passable = passable_cells(random_solids(dice, 20, 3.5), 0.11);
  const GeodesicField all(passable, {3.0, -3.0});
  const GeodesicField some(passable, {3.0, -3.0}, 4.0);
  for (int i = 0; i < 500; ++i) {
    const Vec2 from{dice.in(-3.9, 3.9), dice.in(-3.9, 3.9)};
    const double length = all.length_from(from);
    if (length < 3.9) CHECK(some.length_from(from) == length);
    if (length > 4.2 && length > distance(from, {3.0, -3.0})) CHECK(some.length_from(from) == kInfinity);
  }
}

TEST_CASE("to many targets: the length to the nearest of them") {
  double worst = 0.0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const CellSet passable = passable_cells(random_solids(dice, 14, 3.0), 0.11);
    std::vector<std::size_t> targets;
    std::vector<GeodesicField> fields;
    for (int i = 0; i < 6; ++i) {
      const Vec2 target{dice.in(-3.5, 3.5), dice.in(-3.5, 3.5)};
      targets.push_back(kFrame.index(kFrame.cell(target)));
      if (passable.cells[targets.back()]) fields.emplace_back(passable, kFrame.center(kFrame.cell(targets.back())));
    }
    const GeodesicField to_nearest(passable, targets);
    for (int i = 0; i < 200; ++i) {
      const Vec2 from{dice.in(-3.9, 3.9), dice.in(-3.9, 3.9)};
      double nearest = kInfinity;
      for (const GeodesicField& field : fields) nearest = std::min(nearest, field.length_from(from));
      const double length = to_nearest.length_from(from);
      CHECK((length < kInfinity) == (nearest < kInfinity));
      if (nearest == kInfinity) continue;
      CHECK(std::abs(length - nearest) <= 0.04 + 0.02 * nearest);
      worst = std::max(worst, std::abs(length - nearest));
    }
  }
  MESSAGE("at most ", worst, " m off");
}

TEST_CASE("a path is clear, as long as its length, and ends at the target") {
  double worst = 0.0;
  std::uint64_t paths = 0;
  for (std::uint64_t seed = 0; seed < cases(40); ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const CellSet passable = passable_cells(random_solids(dice, 14, 3.0), 0.11);
    const Vec2 target{dice.in(-3.5, 3.5), dice.in(-3.5, 3.5)};
    const GeodesicField field(passable, target);
    for (int i = 0; i < 40; ++i) {
      const Vec2 from{dice.in(-3.9, 3.9), dice.in(-3.9, 3.9)};
      const std::vector<Vec2> path = field.path_from(from);
      CHECK(path.empty() == (field.length_from(from) == kInfinity));
      if (path.empty() || !passable[kFrame.cell(from)] || !passable[kFrame.cell(target)]) continue;
      CHECK(path.front() == from);
      CHECK(path.back() == target);
      double length = 0.0;
      for (std::size_t k = 1; k < path.size(); ++k) {
        length += distance(path[k - 1], path[k]);
        CHECK(walk_line(kFrame, path[k - 1], path[k], [&](CellIndex c) { return passable.value_or(c, 0) != 0; }));
      }
      CHECK(length <= 1.05 * field.length_from(from) + 0.05);
      worst = std::max(worst, length / field.length_from(from) - 1.0);
      ++paths;
    }
  }
  MESSAGE("at most ", 100.0 * worst, " % longer over ", paths, " paths");
  CHECK(paths > cases(400));
}

}  // namespace
}  // namespace threewe::scene
