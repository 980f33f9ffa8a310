// Distances against brute force, and what costs mean.
#include "map/costmap.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/targets.hpp"
#include "draw.hpp"

namespace threewe::map {
namespace {

OccupancyGrid random_grid(std::mt19937_64& bits) {
  OccupancyGrid grid;
  grid.width = 1 + static_cast<int>(bits() % 60);
  grid.height = 1 + static_cast<int>(bits() % 60);
  grid.origin = {-1.0, -2.0};
  grid.data.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  const auto density = bits() % 20;
  for (std::int8_t& v : grid.data) {
    v = bits() % 100 < density ? OccupancyGrid::kOccupied
                               : (bits() % 3 == 0 ? OccupancyGrid::kUnknown : OccupancyGrid::kFree);
  }
  return grid;
}

// Whether each tile is dearer by the weight for blind ones if and only if, tile by tile, none near has a wall.
bool is_dear_where_blind(const Costmap& costmap, const OccupancyGrid& grid) {
  constexpr int kTile = Costmap::kTile;
  std::map<std::pair<int, int>, int> hits;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.data[grid.index({x, y})] != OccupancyGrid::kOccupied) continue;
      const Cell c = costmap.cell(grid.center({x, y}));
      ++hits[{c.x / kTile, c.y / kTile}];
    }
  }
  Costmap seeing{Costmap::Settings{}};
  seeing.update(grid, {}, {});
  for (int y = 0; y < costmap.height(); ++y) {
    for (int x = 0; x < costmap.width(); ++x) {
      const bool sees = std::ranges::any_of(hits, [&](const auto& tile) {
        const double away = std::hypot(tile.first.first - x / kTile, tile.first.second - y / kTile);
        return tile.second >= 6 && away * kTile * costmap.resolution() <= costmap.settings().sight;
      });
      const Costmap::Weight least = seeing.weight({x, y});
      const int more = sees || least == Costmap::kLethal ? 0 : costmap.settings().blind_weight;
      if (costmap.weight({x, y}) != least + more) return false;
    }
  }
  return true;
}

TEST_CASE("squared distances are those of brute force, with any vectors") {
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const int width = draw.whole(1, 100);
    const int height = draw.whole(1, 45);
    std::vector<std::uint8_t> occupied(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const int density = draw.whole(1, 60);
    for (auto& o : occupied) o = draw.whole(0, 999) < density ? static_cast<std::uint8_t>(draw.whole(1, 8)) : 0;
    const Cell low{draw.whole(0, width), draw.whole(0, height)};
    const Region region{low, {draw.whole(low.x, width), draw.whole(low.y, height)}};

    std::vector<std::uint8_t> expected;
    for (int y = region.low.y; y < region.high.y; ++y) {
      for (int x = region.low.x; x < region.high.x; ++x) {
        int nearest = kMaxDistance * kMaxDistance;
        for (int v = std::max(0, y - kMaxDistance); v < std::min(height, y + kMaxDistance); ++v) {
          for (int u = std::max(0, x - kMaxDistance); u < std::min(width, x + kMaxDistance); ++u) {
            if (occupied[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)] !=
                0) {
              nearest = std::min(nearest, (u - x) * (u - x) + (v - y) * (v - y));
            }
          }
        }
        expected.push_back(static_cast<std::uint8_t>(nearest));
      }
    }
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      std::vector<std::uint8_t> squared;
      squared_distances(occupied, width, height, region, squared);
      REQUIRE(squared == expected);
    }
    force_target("");
  }
}

TEST_CASE("cells are lethal within the radius, dear near it, and unknown ones a little dearer than free ones") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const OccupancyGrid grid = random_grid(bits);
    const Costmap::Settings settings{.unknown_radius = seed % 2 == 0 ? 0.0 : 0.2};
    Costmap costmap(settings);
    costmap.update(grid, {}, {});
    for (int y = 0; y < costmap.height(); ++y) {
      for (int x = 0; x < costmap.width(); ++x) {
        const Cell c{x, y};
        const double d = costmap.clearance(c);
        const bool unknown = grid.at(grid.cell(costmap.center(c))) == OccupancyGrid::kUnknown;
        const double lethal =
            unknown ? std::max(settings.lethal_radius, settings.unknown_radius) : settings.lethal_radius;
        REQUIRE((costmap.weight(c) == Costmap::kLethal) == (d < lethal));
        REQUIRE(costmap.unknown(c) == unknown);
        if (d < lethal) continue;
        const int extra = unknown ? settings.unknown_weight : 0;
        REQUIRE(costmap.weight(c) >= Costmap::kFree + extra);
        REQUIRE(costmap.weight(c) <= Costmap::kFree + settings.near_weight + extra);
        if (d >= settings.caution_radius) REQUIRE(costmap.weight(c) == Costmap::kFree + extra);
      }
    }
  }
}

TEST_CASE("a costmap holds what it is asked to, however far, in the raster of the map") {
  OccupancyGrid grid;
  grid.width = grid.height = 10;
  grid.data.assign(100, OccupancyGrid::kFree);
  Costmap costmap;
  const std::vector<Vec2> far = {{-7.0, 3.0}, {9.0, -4.0}};
  costmap.update(grid, {}, far);
  for (const Vec2 p : far) CHECK(costmap.contains(costmap.cell(p)));
  const Vec2 middle = grid.center({3, 4});
  CHECK(distance(costmap.center(costmap.cell(middle)), middle) < 1e-9);
}

TEST_CASE("points seen by the lidar count as occupied; the robot's own place stays open") {
  OccupancyGrid grid;
  grid.width = grid.height = 40;
  grid.data.assign(1600, OccupancyGrid::kFree);
  Costmap costmap;
  const std::vector<Vec2> seen = {{1.0, 1.0}};
  costmap.update(grid, seen, {});
  CHECK(costmap.weight(costmap.cell({1.0, 1.0})) == Costmap::kLethal);
  CHECK(costmap.weight(costmap.cell({1.08, 1.0})) == Costmap::kLethal);
  CHECK(costmap.line_cost({0.5, 1.0}, {1.5, 1.0}) == std::numeric_limits<double>::infinity());

  costmap.open_around({1.08, 1.0}, 0.2);
  CHECK(costmap.weight(costmap.cell({1.08, 1.0})) != Costmap::kLethal);
  CHECK(costmap.weight(costmap.cell({1.0, 1.0})) == Costmap::kLethal);
}

TEST_CASE("a robot close to a wall is not led through a slit in it") {
  OccupancyGrid grid;
  grid.width = grid.height = 40;
  grid.data.assign(1600, OccupancyGrid::kFree);
  for (int y = 0; y < 40; ++y) {
    if (y != 20) grid.data[grid.index({20, y})] = OccupancyGrid::kOccupied;
  }
  Costmap costmap;
  costmap.update(grid, {}, {});
  const Vec2 robot = grid.center({18, 20});
  const Vec2 beyond = grid.center({23, 20});
  costmap.open_around(robot, 0.28);
  CHECK(std::isfinite(costmap.line_cost(robot, grid.center({16, 20}))));
  CHECK_FALSE(std::isfinite(costmap.line_cost(robot, beyond)));
}

// Everything that a costmap tells.
void require_same(const Costmap& a, const Costmap& b) {
  REQUIRE(a.width() == b.width());
  REQUIRE(a.height() == b.height());
  REQUIRE(a.low() == b.low());
  REQUIRE(a.center({0, 0}) == b.center({0, 0}));
  REQUIRE(a.weights() == b.weights());
  REQUIRE(a.unknown() == b.unknown());
  bool same = true;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) same = same && a.clearance({x, y}) == b.clearance({x, y});
  }
  REQUIRE(same);
}

// The weights of a tile, and of the first row and column of the next ones; outside lethal.
std::vector<Costmap::Weight> closed_tile(const Costmap& costmap, Cell low) {
  std::vector<Costmap::Weight> weights;
  for (int y = low.y; y <= low.y + Costmap::kTile; ++y) {
    for (int x = low.x; x <= low.x + Costmap::kTile; ++x) {
      weights.push_back(costmap.contains({x, y}) ? costmap.weight({x, y}) : Costmap::kLethal);
    }
  }
  return weights;
}

TEST_CASE("a costmap that follows changes is that of an update from scratch, to the bit, and equal stamps do not lie") {
  std::uint64_t kept = 0;
  for (std::uint64_t seed = 0; seed < cases(120); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    OccupancyGrid grid;
    Costmap::Settings settings;
    if (seed % 3 == 0) settings.sight = 2.0, settings.blind_weight = 6;
    Costmap costmap(settings);
    std::vector<Zone> zones;
    std::map<std::uint64_t, std::vector<Costmap::Weight>> tiles;  // what each stamp stood for
    for (int round = 0; round < 25; ++round) {
      CAPTURE(round);
      // the map grows or is another one; most of the time a few cells change
      std::optional<Region> changed;
      if (grid.data.empty() || bits() % 8 == 0) {
        grid = random_grid(bits);
        grid.origin = {0.05 * static_cast<double>(bits() % 200) - 5.0, 0.05 * static_cast<double>(bits() % 200) - 5.0};
      } else {
        Region region{{grid.width, grid.height}, {0, 0}};
        for (auto i = bits() % 6; i > 0; --i) {
          const Cell c{static_cast<int>(bits() % static_cast<unsigned>(grid.width)),
                       static_cast<int>(bits() % static_cast<unsigned>(grid.height))};
          const std::array<std::int8_t, 4> values = {-1, 0, 64, 65};
          grid.data[grid.index(c)] = values[bits() % 4];
          region = {{std::min(region.low.x, c.x), std::min(region.low.y, c.y)},
                    {std::max(region.high.x, c.x + 1), std::max(region.high.y, c.y + 1)}};
        }
        if (bits() % 2 == 0) changed = region;
      }
      const auto point = [&] {
        return Vec2{0.01 * static_cast<double>(bits() % 1000) - 5.0, 0.01 * static_cast<double>(bits() % 1000) - 5.0};
      };
      std::vector<Vec2> seen(bits() % 4);
      for (Vec2& p : seen) p = point();
      std::vector<Vec2> include(bits() % 5 == 0 ? 1 : 0);
      for (Vec2& p : include) p = 2.0 * point();

      if (seed % 2 == 0 && bits() % 5 == 0) {
        zones.resize(bits() % 3);
        for (Zone& zone : zones) {
          zone = {{point(), point(), point()}, {}};
          if (bits() % 2 == 0) zone.speed_limit = 0.01 * static_cast<double>(1 + bits() % 60);
        }
        costmap.set_zones(zones, 0.5);
      }
      costmap.update(grid, seen, include, 3, changed);
      Costmap fresh(settings);
      fresh.set_zones(zones, 0.5);
      fresh.update(grid, seen, include, 3);
      require_same(costmap, fresh);
      if (bits() % 2 == 0) {
        const Vec2 robot = point();
        costmap.open_around(robot, 0.3);
        fresh.open_around(robot, 0.3);
        require_same(costmap, fresh);
      }
      for (int y = 0; y < costmap.height(); y += Costmap::kTile) {
        for (int x = 0; x < costmap.width(); x += Costmap::kTile) {
          const auto [known, is_new] = tiles.try_emplace(costmap.stamp({x, y}), closed_tile(costmap, {x, y}));
          REQUIRE(known->second == closed_tile(costmap, {x, y}));
          kept += is_new ? 0 : 1;
        }
      }
    }
  }
  CHECK(kept > cases(3000));
}

TEST_CASE("a tile without a wall in sight is dearer, whatever came and went before") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    OccupancyGrid grid;
    grid.origin = {draw(-9.0, 9.0), draw(-9.0, 9.0)};
    grid.width = draw.whole(1, 400);
    grid.height = draw.whole(1, 400);
    grid.data.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                     OccupancyGrid::kFree);
    Costmap::Settings settings;
    settings.sight = draw(1.0, 12.0);
    settings.blind_weight = draw.whole(1, 20);
    Costmap costmap(settings);
    for (int step = 0; step < 4; ++step) {
      for (int spot = draw.whole(0, 3); spot > 0; --spot) {
        const Cell at{draw.whole(0, grid.width - 1), draw.whole(0, grid.height - 1)};
        const std::int8_t value = draw.whole(0, 1) == 0 ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
        const int end = std::min(at.x + draw.whole(1, 12), grid.width);
        for (int x = at.x; x < end; ++x) grid.data[grid.index({x, at.y})] = value;
      }
      costmap.update(grid, {}, {});
      CHECK(is_dear_where_blind(costmap, grid));
    }
  }
}

TEST_CASE("a zone to keep out of is an obstacle, one with a limit is dearer, and gone it is as if it had never been") {
  OccupancyGrid grid;
  grid.width = grid.height = 100;
  grid.data.assign(10000, OccupancyGrid::kFree);
  Costmap plain;
  plain.update(grid, {}, {});
  const Zone closed{{{1.0, 1.0}, {2.0, 1.0}, {2.0, 2.0}, {1.0, 2.0}}};
  const Zone slow{{{3.0, 3.0}, {4.0, 3.0}, {4.0, 4.0}, {3.0, 4.0}}, 0.125};
  Costmap costmap;
  costmap.set_zones({closed, slow}, 0.5);
  costmap.update(grid, {}, {});
  const Costmap::Settings settings;
  for (int y = 0; y < costmap.height(); ++y) {
    for (int x = 0; x < costmap.width(); ++x) {
      const Cell c{x, y};
      const Vec2 middle = costmap.center(c);
      if (closed.distance_to(middle) < settings.lethal_radius - 0.05) REQUIRE(costmap.weight(c) == Costmap::kLethal);
      if (closed.distance_to(middle) > settings.lethal_radius + 0.05) REQUIRE(costmap.weight(c) != Costmap::kLethal);
      if (slow.contains(middle)) REQUIRE(costmap.weight(c) == plain.weight(c) + 3 * Costmap::kFree);
      if (closed.distance_to(middle) < settings.caution_radius + 0.05 || slow.contains(middle)) continue;
      REQUIRE(costmap.weight(c) == plain.weight(c));
    }
  }
  costmap.set_zones({}, 0.5);
  costmap.update(grid, {}, {}, 20, Region{});
  require_same(costmap, plain);
}

TEST_CASE("tiles far from a change keep their stamps, also when the map grows") {
  OccupancyGrid grid;
  grid.width = grid.height = 320;
  grid.origin = {-3.2, -6.4};
  grid.data.assign(std::size_t{320} * 320, OccupancyGrid::kFree);
  Costmap costmap;
  costmap.update(grid, {}, {});
  const auto stamp_at = [&](Vec2 point) { return costmap.stamp(costmap.cell(point)); };
  const std::vector<Vec2> places = {{0.0, 0.0}, {5.0, 5.0}, {8.0, -1.0}};
  std::vector<std::uint64_t> stamps;
  for (const Vec2 p : places) stamps.push_back(stamp_at(p));

  grid.data[grid.index(grid.cell({0.1, 0.1}))] = OccupancyGrid::kOccupied;
  costmap.update(grid, {}, std::vector<Vec2>{{-20.0, -20.0}});
  CHECK(stamp_at(places[0]) != stamps[0]);
  CHECK(stamp_at(places[1]) == stamps[1]);
  CHECK(stamp_at(places[2]) == stamps[2]);
}

TEST_CASE("a straight line through free space costs its length") {
  OccupancyGrid grid;
  grid.width = grid.height = 80;
  grid.data.assign(6400, OccupancyGrid::kFree);
  Costmap costmap;
  costmap.update(grid, {}, {});
  CHECK(costmap.line_cost({0.5, 0.5}, {3.5, 2.5}) ==
        doctest::Approx(Costmap::kFree * distance({0.5, 0.5}, {3.5, 2.5})));
}

}  // namespace
}  // namespace threewe::map
