// Coverage counts what is reachable, was crossed by a ray, and is marked free: nothing else.
#include "scene/coverage.hpp"
#include "core/exact.hpp"
#include "scene/scene_tables.hpp"

#include <doctest/doctest.h>

#include <memory>

namespace threewe::scene {
namespace {

// Two rooms of 4 x 4 m without a way between them, the start in the middle of the western one.
std::shared_ptr<const SceneTables> two_rooms(const std::string& doors, const std::string& objects = "") {
  const std::string text =
      "name: rooms\ndescription: two\nstarts: [[2, 2]]\nwalls:\n  - {a: [0, 0], b: [8, 0], thickness: 0.1}\n"
      "  - {a: [8, 0], b: [8, 4], thickness: 0.1}\n  - {a: [8, 4], b: [0, 4], thickness: 0.1}\n"
      "  - {a: [0, 4], b: [0, 0], thickness: 0.1}\n  - {a: [4, 0], b: [4, 4], thickness: 0.1" +
      doors + "}\n" + objects;
  return std::make_shared<const SceneTables>(std::make_shared<const Scene>(Scene::parse(text, "rooms.yaml")),
                                             Footprint::rectangle(0.25, 0.22), 0.2);
}

std::size_t count(const CellSet& set) {
  std::size_t cells = 0;
  for (const auto c : set.cells) cells += c;
  return cells;
}

TEST_CASE("what cannot be reached does not count") {
  // 3.9 x 3.9 m inside the walls; the rounded corners of a disc reach nearly everything
  const CoverageMeter closed(two_rooms(""), 0.15);
  CHECK(static_cast<double>(count(closed.reachable_cells())) * kCellSize * kCellSize ==
        doctest::Approx(3.9 * 3.9).epsilon(0.01));
  const CoverageMeter open(two_rooms(", doors: [{name: d, at: 2, width: 1}]"), 0.15);
  CHECK(static_cast<double>(count(open.reachable_cells())) * kCellSize * kCellSize ==
        doctest::Approx(2 * 3.9 * 3.9 + 0.1).epsilon(0.01));
}

TEST_CASE("one look in an empty room sees nearly all of it, one through a door part of the next") {
  CoverageMeter closed(two_rooms(""), 0.15);
  CHECK(closed.crossed() == 0.0);
  closed.observe({0.0, 0.0, 0.0});
  CHECK(closed.crossed() > 0.99);

  CoverageMeter open(two_rooms(", doors: [{name: d, at: 2, width: 1}]"), 0.15);
  open.observe({0.0, 0.0, 0.3});
  CHECK(open.crossed() > 0.6);
  CHECK(open.crossed() < 0.8);
  open.observe({4.0, 0.0, -0.7});
  CHECK(open.crossed() > 0.99);
}

TEST_CASE("a crossed cell lies on a free straight line within 8 m") {
  const auto tables = std::make_shared<const SceneTables>(std::make_shared<const Scene>(Scene::load("corridor_v1")),
                                                          Footprint::rectangle(0.25, 0.22), 0.2);
  CoverageMeter meter(tables, 0.15);
  const Vec2 lidar{10.0, 0.6};
  meter.observe({lidar.x, lidar.y, 0.0});
  const Slice slice = tables->scene().at_height(0.15);
  const CellSet& crossed = meter.crossed_cells();
  std::size_t cells = 0;
  for (std::size_t i = 0; i < crossed.cells.size(); ++i) {
    if (!crossed.cells[i]) continue;
    ++cells;
    // some point of the cell is seen: try a lattice of them
    const Vec2 middle = crossed.frame.center(crossed.frame.cell(i));
    bool seen = false;
    for (int k = 0; k < 121 && !seen; ++k) {
      const Vec2 p = middle + Vec2{(k % 11 - 5) * 0.0052, (k / 11 - 5) * 0.0052};
      const double range = distance(lidar, p);
      const double angle = exact::atan2(p.y - lidar.y, p.x - lidar.x);
      seen = range <= 8.02 && cast_ray(slice, lidar, angle, 9.0) >= range - 0.03;
    }
    CHECK(seen);
  }
  CHECK(cells > 2000);
}

TEST_CASE("a map counts where it marks free within 10 cm, not further away") {
  CoverageMeter meter(two_rooms(""), 0.15);
  meter.observe({0.0, 0.0, 0.0});
  CHECK(meter.coverage([](Vec2) { return true; }) == meter.crossed());
  CHECK(meter.coverage([](Vec2) { return false; }) == 0.0);
  // a map that knows the half of the room with y > 0 counts for 10 cm more
  const double half = meter.coverage([](Vec2 p) { return p.y > 0.0; });
  CHECK(half == doctest::Approx((1.95 + 0.10) / 3.9).epsilon(0.02));
}

TEST_CASE("a map that knows what was never seen earns nothing for it") {
  CoverageMeter meter(two_rooms(", doors: [{name: d, at: 2, width: 1}]"), 0.15);
  meter.observe({-1.5, -1.5, 0.0});
  CHECK(meter.coverage([](Vec2) { return true; }) < 0.65);
}

}  // namespace
}  // namespace threewe::scene
