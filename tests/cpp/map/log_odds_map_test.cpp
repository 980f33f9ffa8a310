// The map against a slow twin that keeps a set of cells, and what a user sees of it.
#include "map/log_odds_map.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::map {
namespace {

Vec2 unit(double angle) {
  const auto [s, c] = exact::sincos(angle);
  return {c, s};
}

Beam beam(Vec2 origin, double angle, double range, bool hit = true) { return {origin, unit(angle), range, hit}; }

std::vector<Beam> random_scan(Draw& draw) {
  const Vec2 origin{draw(-6, 6), draw(-6, 6)};
  std::vector<Beam> beams;
  const int n = draw.whole(1, 40);
  beams.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) beams.push_back(beam(origin, draw(-3.1, 3.1), draw(0.05, 12.0), draw(0, 1) < 0.8));
  return beams;
}

using CellName = std::pair<long, long>;  // counted from the map's origin

CellName name(Vec2 p) { return {static_cast<long>(std::floor(p.x / 0.05)), static_cast<long>(std::floor(p.y / 0.05))}; }

// The evidence of scans, told by points set densely along every beam. Points very near to a border between cells tell
// nothing, since rounding decides there.
struct SlowMap {
  std::map<CellName, int> evidence;
  std::set<CellName> unsure;

  void insert(const std::vector<Beam>& beams, double bias) {
    std::set<CellName> hit;
    std::set<CellName> passed;
    for (const Beam& b : beams) {
      const double length = std::max(b.range - (b.hit ? bias : 0.0), 0.0);
      const Vec2 end = b.origin + (b.range - (b.hit ? bias : 0.0)) * b.direction;
      if (b.hit) hit.insert(name(end));
      const double seen = std::min(length, 8.0);
      const int steps = static_cast<int>(seen / 0.0005) + 1;
      for (int i = 0; i <= steps; ++i) {
        passed.insert(name(b.origin + (seen * i / steps) * b.direction));
        doubt(b.origin + (seen * i / steps) * b.direction);
      }
    }
    for (const CellName& c : hit) add(c, 25);
    for (const CellName& c : passed) {
      if (!hit.contains(c)) add(c, -11);
    }
  }

 private:
  void add(const CellName& c, int by) {
    int& value = evidence[c];
    value += by;
    if (value == 0) value = by > 0 ? 1 : -1;
    value = std::clamp(value, -50, 75);
  }
  // near a corner of four cells the line may visit a neighbour for less than a step
  void doubt(Vec2 p) {
    const double fx = p.x / 0.05 - std::floor(p.x / 0.05);
    const double fy = p.y / 0.05 - std::floor(p.y / 0.05);
    const bool edge_x = std::min(fx, 1 - fx) < 0.02;
    const bool edge_y = std::min(fy, 1 - fy) < 0.02;
    if (!edge_x || !edge_y) return;
    const auto [x, y] = name(p);
    for (long dy = -1; dy <= 1; ++dy) {
      for (long dx = -1; dx <= 1; ++dx) unsure.insert({x + dx, y + dy});
    }
  }
};

TEST_CASE("every cell has the evidence that scans give it, cell by cell as a slow twin counts it") {
  std::uint64_t compared = 0;
  for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    LogOddsMap map;
    SlowMap slow;
    const double bias = draw(-0.03, 0.03);
    const int scans = draw.whole(1, 4);
    for (int i = 0; i < scans; ++i) {
      const std::vector<Beam> beams = random_scan(draw);
      map.insert(beams, bias);
      slow.insert(beams, bias);
    }
    const OccupancyGrid& grid = map.grid();
    int wrong = 0;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const CellName c = name(grid.center({x, y}));
        if (slow.unsure.contains(c)) continue;
        const auto found = slow.evidence.find(c);
        const int expected = found == slow.evidence.end() ? 0 : found->second;
        wrong += map.log_odds({x, y}) == expected ? 0 : 1;
        ++compared;
      }
    }
    CHECK(wrong == 0);
  }
  CHECK(compared > cases(1'000'000));
}

TEST_CASE("the exported grid says the same as the evidence") {
  Draw draw(1);
  LogOddsMap map;
  for (int i = 0; i < 30; ++i) map.insert(random_scan(draw));
  const OccupancyGrid& grid = map.grid();
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const double evidence = map.log_odds({x, y});
      const int expected =
          evidence == 0 ? -1 : static_cast<int>(std::floor(100.0 / (1.0 + exact::exp(-0.1 * evidence)) + 0.5));
      REQUIRE(grid.at({x, y}) == expected);
    }
  }
  CHECK(map.version() == 30);
}

TEST_CASE("one look tells free from occupied, in the words of ROS") {
  LogOddsMap map;
  map.insert(std::vector{beam({0.01, 0.01}, 0.0, 2.0)});
  const OccupancyGrid& grid = map.grid();
  CHECK(grid.at(grid.cell({2.01, 0.01})) >= OccupancyGrid::kOccupiedThreshold);
  CHECK(grid.at(grid.cell({1.0, 0.01})) <= OccupancyGrid::kFreeThreshold);
  CHECK(grid.at(grid.cell({1.0, 0.01})) >= 0);
  CHECK(grid.at(grid.cell({1.0, 0.5})) == OccupancyGrid::kUnknown);
  CHECK(grid.at(grid.cell({2.3, 0.01})) == OccupancyGrid::kUnknown);
}

TEST_CASE("a cell that one beam hits is not cleared by another beam of the same scan") {
  LogOddsMap map;
  map.insert(std::vector{beam({0.01, 0.01}, 0.0, 1.0), beam({0.01, 0.02}, 0.0, 2.0)});
  CHECK(map.log_odds(map.grid().cell({1.01, 0.01})) > 0);
}

TEST_CASE("what leaves is forgotten, surface and all") {
  LogOddsMap map;
  for (int i = 0; i < 20; ++i) map.insert(std::vector{beam({0.01, 0.01}, 0.0, 1.0)});
  const Cell gone = map.grid().cell({1.01, 0.01});
  CHECK(map.log_odds(gone) == 75);
  for (int i = 0; i < 20; ++i) map.insert(std::vector{beam({0.01, 0.01}, 0.0, 2.0)});
  CHECK(map.log_odds(gone) == -50);
  CHECK(map.hits()[map.grid().index(gone)].count == 0);
}

TEST_CASE("growing keeps what was known where it was") {
  LogOddsMap map;
  map.insert(std::vector{beam({0.01, 0.01}, 0.3, 1.0)});
  const Vec2 place = Vec2{0.01, 0.01} + unit(0.3);
  const auto before = map.grid().at(map.grid().cell(place));
  const CellHits hits = map.hits()[map.grid().index(map.grid().cell(place))];
  const int width = map.grid().width;
  map.insert(std::vector{beam({-9.0, -7.0}, -2.0, 5.0), beam({12.0, 8.0}, 1.0, 5.0)});
  CHECK(map.grid().width > width);
  CHECK(map.grid().at(map.grid().cell(place)) == before);
  CHECK(map.hits()[map.grid().index(map.grid().cell(place))] == hits);
}

TEST_CASE("the hits of a cell know the surface within a tenth of a millimetre, the bias still in it") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    LogOddsMap map;
    const double angle = draw(-3.1, 3.1);
    const double bias = draw(-0.03, 0.03);
    const double range = draw(0.5, 6.0);
    Vec2 mean;
    const int n = draw.whole(1, 60);
    for (int i = 0; i < n; ++i) {
      const Beam b = beam({0.0, 0.0}, angle, range);
      mean = mean + (1.0 / n) * (b.range * b.direction);
      map.insert(std::vector{b}, bias);
    }
    const Cell c = map.grid().cell((range - bias) * unit(angle));
    const CellHits& h = map.hits()[map.grid().index(c)];
    REQUIRE(h.count == n);
    const Vec2 stored = map.grid().center(c) + (0.05 / (256.0 * h.count)) * Vec2{1.0 * h.sum_x, 1.0 * h.sum_y};
    CHECK(distance(stored, mean) < 2e-4);
    CHECK(h.sum_from_x * unit(angle).x + h.sum_from_y * unit(angle).y < 0.0);
  }
}

TEST_CASE("a map is the same whatever the order of a scan's beams") {
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::vector<Beam> beams = random_scan(draw);
    LogOddsMap a;
    a.insert(beams);
    std::reverse(beams.begin(), beams.end());
    LogOddsMap b;
    b.insert(beams);
    CHECK(a.grid() == b.grid());
    CHECK(a.hits() == b.hits());
  }
}

TEST_CASE("beams from far away are ignored, so that one mad pose costs no gigabytes") {
  LogOddsMap map;
  map.insert(std::vector{beam({0.01, 0.01}, 0.3, 1.0)});
  const OccupancyGrid before = map.grid();
  for (const double far : {5e3, 1e6, 1e9, 1e300}) {
    CAPTURE(far);
    map.insert(std::vector{beam({far, -far}, 1.0, 5.0)});
    CHECK(map.grid() == before);
    CHECK_FALSE(map.grid().contains(map.grid().cell({far, -far})));
    CHECK_FALSE(map.grid().contains(map.grid().cell({-far, far})));
  }
  map.insert(std::vector{beam({300.0, 0.0}, 0.0, 1.0)});
  CHECK(map.grid().width > 6000);
}

TEST_CASE("a map does not begin where no cell can be counted") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double far : {-2e6, 1e9, 1e18, 1e300, kInfinity, -kInfinity, kNan}) {
    CAPTURE(far);
    LogOddsMap map;
    map.insert(std::vector{beam({far, 0.0}, 1.0, 5.0), beam({0.0, far}, 1.0, 5.0), beam({0.0, 0.0}, 1.0, far)});
    CHECK(map.grid().data.empty());
    map.make_room({far, far}, {far + 1.0, far + 1.0});
    map.insert(std::vector{beam({1.0, 1.0}, 0.0, 1.0)});
  }
}

TEST_CASE("hits stay in the map whatever the lidar's bias") {
  for (const double resolution : {0.02, 0.05}) {
    for (const double bias : {-1.0, -0.3, 0.3, 1.0}) {
      for (int k = 0; k < 63; ++k) {
        LogOddsMap map({.resolution = resolution});
        map.insert(std::vector{beam({63.9 * resolution, 63.9 * resolution}, 0.1 * k, 0.05)}, bias);
        std::int64_t hits = 0;
        for (const CellHits& h : map.hits()) hits += h.count;
        CHECK(hits == 1);
      }
    }
  }
  LogOddsMap map;
  for (const double bias : {-1.1, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_THROWS_AS(map.insert(std::vector{beam({0, 0}, 0.0, 1.0)}, bias), ContractError);
  }
}

TEST_CASE("a map in place of another tells what has changed, and where") {
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    LogOddsMap map;
    LogOddsMap other;
    for (int i = draw.whole(0, 5); i >= 0; --i) map.insert(random_scan(draw));
    for (int i = draw.whole(0, 5); i >= 0; --i) other.insert(random_scan(draw));
    const LogOddsMap old = map;
    map.replace(other);
    CHECK(map.grid() == other.grid());
    CHECK(map.hits() == other.hits());
    CHECK(map.version() == old.version() + 1);
    const std::optional<Region> changed = map.changes().since(old.version());
    REQUIRE(changed);
    // the smallest rectangle around all cells that differ
    Region all;
    for (int y = -400; y < 400; ++y) {
      for (int x = -400; x < 400; ++x) {
        const Vec2 place{0.05 * (x + 0.5), 0.05 * (y + 0.5)};
        if (old.grid().at(old.grid().cell(place)) == map.grid().at(map.grid().cell(place))) continue;
        all = united(all, {{x, y}, {x + 1, y + 1}});
      }
    }
    CHECK(*changed == all);
    // and on it goes
    map.insert(random_scan(draw));
    CHECK(map.changes().since(old.version()).has_value());
  }
}

TEST_CASE("hits that fall short of a wall stay where noise reaches over a cell, and are forgotten where it does not") {
  const auto hits_before_wall = [](double range_noise) {
    LogOddsMap map;
    for (int i = 0; i < 20; ++i) {  // one in ten falls short by a cell, as seen by the middle of a fan
      std::vector<Beam> beams;
      for (int k = -20; k <= 20; ++k) {
        const double wall = 1.025 / unit(0.02 * k).x;
        beams.push_back(beam({0.0, 0.0}, 0.02 * k, i % 10 == 5 && k == 0 ? wall - 0.05 : wall));
      }
      map.insert(beams, 0.0, range_noise);
    }
    REQUIRE(map.log_odds(map.grid().cell({0.975, 0.0})) < 0);
    return map.hits()[map.grid().index(map.grid().cell({0.975, 0.0}))].count;
  };
  CHECK(hits_before_wall(0.04) == 2);
  CHECK(hits_before_wall(0.017) == 2);
  CHECK(hits_before_wall(0.016) == 0);
  CHECK(hits_before_wall(0.0) == 0);
}

TEST_CASE("what two versions differ in is where the log of changes says") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    LogOddsMap map;
    std::vector<OccupancyGrid> versions = {map.grid()};
    for (int i = 0; i < 80; ++i) {
      map.insert(random_scan(draw));
      versions.push_back(map.grid());
    }
    const OccupancyGrid& now = map.grid();
    const Cell low = raster_cell(now);
    for (std::size_t v = 0; v < versions.size(); v += 9) {
      const std::optional<Region> changed = map.changes().since(v);
      REQUIRE(changed.has_value() == (v + 64 >= map.version()));
      if (!changed) continue;
      bool same = true;
      for (int y = 0; y < now.height; ++y) {
        for (int x = 0; x < now.width; ++x) {
          const Cell c{x + low.x, y + low.y};
          const bool within =
              c.x >= changed->low.x && c.y >= changed->low.y && c.x < changed->high.x && c.y < changed->high.y;
          const OccupancyGrid& then = versions[v];
          const Cell old{c.x - raster_cell(then).x, c.y - raster_cell(then).y};
          same = same && (within || now.at({x, y}) == (then.data.empty() ? OccupancyGrid::kUnknown : then.at(old)));
        }
      }
      REQUIRE(same);
    }
    CHECK(map.changes().since(map.version()) == Region{});
    CHECK_FALSE(map.changes().since(map.version() + 1));
  }
}

TEST_CASE("a map that was given room beforehand shows the same") {
  for (std::uint64_t seed = 0; seed < cases(50); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    LogOddsMap growing;
    LogOddsMap roomy;
    roomy.make_room({draw(-20, -18), draw(-20, -18)}, {draw(18, 20), draw(18, 20)});
    roomy.make_room({-1e7, 0}, {1e7, 1});  // more than a map may have
    for (int i = 0; i < 10; ++i) {
      const std::vector<Beam> scan = random_scan(draw);
      growing.insert(scan);
      roomy.insert(scan);
    }
    const OccupancyGrid& grid = roomy.grid();
    CHECK(grid.width < 900);
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const Vec2 middle = grid.center({x, y});
        REQUIRE(grid.at({x, y}) == growing.grid().at(growing.grid().cell(middle)));
      }
    }
  }
}

}  // namespace
}  // namespace threewe::map
