// A robot that drifts goes round a block: its map before and after the loop has closed.
#include "slam/online_map.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/tiny_world.hpp"

namespace threewe::slam {
namespace {

using threewe::testing::add_box;
using threewe::testing::tiny_range;
using threewe::testing::TinyWall;

/// A corridor around a block, with cabinets along it. The robot drives in its middle and takes itself to be 2 mm
/// farther along x with each metre.
class Block {
 public:
  explicit Block(std::uint64_t seed) : draw_(seed) {
    add_box(walls_, {-1, -1}, {13, 9});
    add_box(walls_, {1, 1}, {11, 7});
    for (int i = 0; i < 6; ++i) {
      const Vec2 corner{draw_(1.0, 10.0), i % 2 == 0 ? -1.0 : 8.6};
      add_box(walls_, corner, corner + Vec2{draw_(0.3, 1.0), 0.4});
    }
  }

  /// The next scan, 10 cm or a sixteenth of a turn on.
  FrontEndScan next() {
    const Pose2D step = turning_ > 0 ? Pose2D{0.0, 0.0, exact::kPi / 8.0} : Pose2D{0.1, 0.0, 0.0};
    if (turning_ > 0) {
      --turning_;
    } else if (++straight_ >= (side_ % 2 == 0 ? 120 : 80)) {
      straight_ = 0;
      ++side_;
      turning_ = 4;
    }
    truth_ = truth_ * step;
    believed = believed * Pose2D{step.x, step.y, wrap_angle(step.theta + draw_(-2e-4, 2e-4))};
    believed.x += 0.002 * norm(step.position());
    return look();
  }

  /// [m] from the truth.
  double error() const { return distance(believed.position(), truth_.position()); }
  double driven() const {
    const int done = side_ / 2;
    return 0.1 * straight_ + 20.0 * done + 12.0 * (side_ % 2);
  }

  /// The share of the occupied cells that are 0.1 m from any wall.
  double astray(const map::OccupancyGrid& grid) const {
    int occupied = 0;
    int off = 0;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        if (grid.at({x, y}) < map::OccupancyGrid::kOccupiedThreshold) continue;
        ++occupied;
        if (from_walls(grid.center({x, y})) > 0.1) ++off;
      }
    }
    return occupied > 0 ? static_cast<double>(off) / occupied : 1.0;
  }

  Pose2D believed;

 private:
  FrontEndScan look() {
    FrontEndScan point{from_seconds(static_cast<double>(++scans_)), believed, Matrix3::Zero(), {}, 0.0};
    for (int i = 0; i < 180; ++i) {
      const double angle = (2 * i - 180) * exact::kPi / 180.0;
      const double range = tiny_range(walls_, truth_.position(), truth_.theta + angle, 8.0);
      const bool hit = range < 8.0;
      point.beams.push_back({{}, rotate({1.0, 0.0}, angle), range + (hit ? draw_(-0.015, 0.015) : 0.0), hit});
    }
    return point;
  }

  double from_walls(Vec2 p) const {
    double nearest = 1e9;
    for (const TinyWall& wall : walls_) {
      const Vec2 d = wall.b - wall.a;
      const double t = std::clamp(dot(p - wall.a, d) / dot(d, d), 0.0, 1.0);
      nearest = std::min(nearest, distance(p, wall.a + t * d));
    }
    return nearest;
  }

  Draw draw_;
  std::vector<TinyWall> walls_;
  Pose2D truth_;
  int scans_ = 0;
  int straight_ = 0;
  int side_ = 0;
  int turning_ = 0;
};

TEST_CASE("where a loop has closed, map and robot are where they should be") {
  for (std::uint64_t seed = 0; seed < cases(4); ++seed) {
    CAPTURE(seed);
    Block block(seed);
    OnlineMap map;
    int redrawn = 0;
    double before = 0.0;
    double largest_step = 0.0;
    while (block.driven() < 60.0) {
      const std::uint64_t version = map.map().version();
      map.insert(block.next());
      CHECK(map.map().version() == version + 1);
      const auto new_from_old = map.redraw();
      if (!new_from_old) continue;
      CHECK(map.map().version() == version + 2);
      if (redrawn++ == 0) before = block.error();
      largest_step =
          std::max(largest_step, norm((*new_from_old * block.believed).position() - block.believed.position()));
      block.believed = *new_from_old * block.believed;
    }
    CHECK(redrawn >= 1);
    CHECK(redrawn <= 6);
    CHECK(before > 0.07);
    CHECK(largest_step > 0.05);
    CHECK(block.error() < 0.06);
    CHECK(block.astray(map.map().grid()) < 0.02);

    // the same without closing loops: all walls of the second round beside those of the first
    Block again(seed);
    OnlineMap plain{map::LogOddsMap(), reference_params()};
    while (again.driven() < 60.0) {
      plain.insert(again.next());
      CHECK_FALSE(plain.redraw());
    }
    CHECK(again.error() > 0.09);
    CHECK(again.astray(plain.map().grid()) > 0.02);
  }
}

TEST_CASE("a copy goes on with the same bits, also in the middle of a drawing") {
  Block block(7);
  OnlineMap map;
  std::vector<OnlineMap> copies;
  std::vector<Block> blocks;
  while (block.driven() < 50.0) {
    map.insert(block.next());
    if (const auto new_from_old = map.redraw()) block.believed = *new_from_old * block.believed;
    if (map.map().version() % 12 != 0 || block.driven() < 36.0) continue;
    copies.push_back(map);
    blocks.push_back(block);
  }
  CHECK(copies.size() > 10);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    CAPTURE(i);
    while (blocks[i].driven() < 50.0) {
      copies[i].insert(blocks[i].next());
      if (const auto new_from_old = copies[i].redraw()) blocks[i].believed = *new_from_old * blocks[i].believed;
    }
    CHECK(copies[i].map().version() == map.map().version());
    CHECK(copies[i].map().grid() == map.map().grid());
    CHECK(copies[i].map().hits() == map.map().hits());
    CHECK(blocks[i].believed == block.believed);
  }
}

TEST_CASE("who was carried off draws no loop from where it was to where it is") {
  Block block(3);
  OnlineMap map;
  while (block.driven() < 15.0) {
    map.insert(block.next());
    CHECK_FALSE(map.redraw());
  }
  const map::OccupancyGrid before = map.map().grid();
  const Pose2D found = block.believed;
  map.break_off();
  while (block.driven() < 60.0) {
    map.insert(block.next());
    (void)map.redraw();
  }
  CHECK(distance(found.position(), block.believed.position()) > 1.0);
  CHECK(before.width <= map.map().grid().width);
}

}  // namespace
}  // namespace threewe::slam
