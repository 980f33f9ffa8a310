// Finding a place in a known map: where it is, when it is no guess, and when it would be one.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "draw.hpp"
#include "slam/branch_and_bound_cases.hpp"
#include "slam/global_localizer.hpp"
#include "slam/prior_map.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::slam {
namespace {

using testing::Place;
using testing::place_of;

// One scan, and all the time that the search takes.
std::optional<Pose2D> look(GlobalLocalizer& finder, Time stamp, const Pose2D& odom_from_base,
                           const std::vector<map::Beam>& beams) {
  const std::optional<Pose2D> place = finder.look(stamp, odom_from_base, beams);
  while (finder.searching()) finder.go_on(1'000'000);
  return place;
}

bool occupied(const map::OccupancyGrid& grid, map::Cell c) { return grid.at(c) >= 65; }

// The same as PriorMap::compare, step by step along every beam.
Resemblance compare_slowly(const map::OccupancyGrid& grid, const Pose2D& pose, std::span<const map::Beam> beams) {
  Resemblance sum;
  for (const map::Beam& beam : beams) {
    const Vec2 from = pose * beam.origin;
    const Vec2 ray = rotate(beam.direction, pose.theta);
    const map::Cell end = grid.cell(from + beam.range * ray);
    bool near = false;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) near = near || occupied(grid, {end.x + dx, end.y + dy});
    }
    const bool known = near || (grid.at(end) >= 0 && grid.at(end) <= 25);
    if (beam.hit && grid.contains(end) && known) {
      ++sum.hits;
      sum.on_surface += near ? 1 : 0;
    }
    bool through = false;
    for (int step = 0; 0.0005 * step < beam.range - 0.25; ++step) {
      through = through || occupied(grid, grid.cell(from + (0.0005 * step) * ray));
    }
    sum.through_walls += through ? 1 : 0;
  }
  return sum;
}

TEST_CASE("what a scan has to do with a map is what every step along its beams says") {
  long grazed = 0;
  long through = 0;
  for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    map::OccupancyGrid grid{60, 50, 0.05, draw.point(-3.0, 3.0), {}};
    for (int i = 0; i < grid.width * grid.height; ++i) {
      const int kind = draw.whole(0, 99);
      grid.data.push_back(kind < 3 ? std::int8_t{100} : kind < 90 ? std::int8_t{0} : std::int8_t{-1});
    }
    const PriorMap known(grid);
    const Pose2D pose{grid.origin.x + draw(0.2, 2.8), grid.origin.y + draw(0.2, 2.3), draw(-3.0, 3.0)};
    std::vector<map::Beam> beams;
    for (int i = 0; i < 90; ++i)
      beams.push_back({{0.1, 0.0}, rotate({1.0, 0.0}, i * 0.07), draw(0.3, 3.0), i % 7 != 0});
    const Resemblance fast = known.compare(pose, beams);
    const Resemblance slow = compare_slowly(grid, pose, beams);
    CHECK(fast.hits == slow.hits);
    CHECK(fast.on_surface == slow.on_surface);
    if (fast.beams == 0) continue;                    // it begins where nothing is known
    CHECK(fast.through_walls >= slow.through_walls);  // corners are between the steps
    grazed += fast.through_walls - slow.through_walls;
    through += slow.through_walls;
  }
  CHECK(through > static_cast<long>(cases(1000)));
  CHECK(grazed < through / 50);
}

TEST_CASE("a robot that wakes up in a mapped place finds itself within three scans, and nowhere else") {
  std::uint64_t found = 0;
  for (std::uint64_t seed = 0; seed < cases(12); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Place place = place_of(scene::generate(seed), draw, 40);
    const auto known = std::make_shared<const PriorMap>(place.map.grid());
    for (int i = 0; i < 5; ++i) {
      const Pose2D truth = place.random_pose(draw);
      GlobalLocalizer finder(known);
      std::optional<Pose2D> result;
      for (int scan = 0; scan < 4 && !result; ++scan) {
        result = look(finder, scan * 100ms, {}, place.look(draw, truth));
        if (scan < 2) CHECK_FALSE(result);
      }
      if (!result) continue;
      ++found;
      CHECK(distance(result->position(), truth.position()) < 0.1);
      CHECK(std::fabs(wrap_angle(result->theta - truth.theta)) < 0.03);
    }
  }
  MESSAGE(found, " of ", 5 * cases(12), " found");
  CHECK(6 * found >= 5 * 5 * cases(12));
}

TEST_CASE("a robot that drives on while it searches finds where it has come to, and so does its copy") {
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Place place = place_of(scene::generate(seed), draw, 40);
    const auto known = std::make_shared<const PriorMap>(place.map.grid());
    const Pose2D start = place.random_pose(draw);
    const Pose2D map_from_odom = start * inverse(Pose2D{3.0, -2.0, 1.0});
    GlobalLocalizer finder(known);
    std::optional<Pose2D> found;
    int searching = 0;
    for (int scan = 0; scan < 100 && !found; ++scan) {
      const Pose2D truth{start.x, start.y, wrap_angle(start.theta + 0.02 * scan)};  // it turns
      const std::vector<map::Beam> beams = place.look(draw, truth);
      const Pose2D odom_from_base = inverse(map_from_odom) * truth;
      GlobalLocalizer copy = finder;
      found = finder.look(scan * 100ms, odom_from_base, beams);
      CHECK(copy.look(scan * 100ms, odom_from_base, beams) == found);
      for (int tick = 0; tick < 5; ++tick) finder.go_on(100'000), copy.go_on(100'000);
      CHECK(copy.searching() == finder.searching());
      searching += finder.searching() ? 1 : 0;
      if (found) CHECK(distance(found->position(), truth.position()) < 0.1);
      finder = copy;
    }
    CHECK(found);
    CHECK(searching > 0);
  }
}

TEST_CASE("in another place it finds nothing") {
  Draw draw(7);
  const auto known = std::make_shared<const PriorMap>(place_of(scene::Scene::load("office_v2"), draw, 60).map.grid());
  const Place other = place_of(scene::Scene::load("warehouse_v1"), draw, 30);
  for (std::uint64_t i = 0; i < cases(15); ++i) {
    CAPTURE(i);
    const Pose2D truth = other.random_pose(draw);
    GlobalLocalizer finder(known);
    for (int scan = 0; scan < 12; ++scan) CHECK_FALSE(look(finder, scan * 100ms, {}, other.look(draw, truth)));
  }
}

// Beams around a pose, and the map of what stands in a rectangle of 8 m x 5 m.
struct Room {
  Place place;
  std::shared_ptr<const PriorMap> known;

  explicit Room(std::vector<scene::Segment> furniture) {
    const Vec2 corners[] = {{-4, -2.5}, {4, -2.5}, {4, 2.5}, {-4, 2.5}};
    for (int i = 0; i < 4; ++i) furniture.push_back({corners[i], corners[(i + 1) % 4]});
    for (const scene::Segment& s : furniture) {  // each is seen from one side
      place.slice.segments.push_back(s);
      place.slice.segments.push_back({s.b, s.a});
    }
    Draw draw(1);
    for (int x = -3; x <= 3; ++x) {
      const Pose2D pose{1.0 * x, 0.3, 0.0};
      std::vector<map::Beam> beams = place.look(draw, pose);
      for (map::Beam& b : beams) b.origin = pose.position();
      for (int again = 0; again < 4; ++again) place.map.insert(beams);
    }
    known = std::make_shared<const PriorMap>(place.map.grid());
  }
};

TEST_CASE("a room that looks the same from both ends is no place to be sure in") {
  Draw draw(2);
  const Pose2D truth{1.5, 0.4, 0.7};
  const Room bare({});
  GlobalLocalizer unsure(bare.known);
  for (int scan = 0; scan < 100; ++scan) CHECK_FALSE(look(unsure, scan * 100ms, {}, bare.place.look(draw, truth)));

  const Room furnished({{{-4, 1}, {-2.5, 1}}, {{-2.5, 1}, {-2.5, 2.5}}});
  GlobalLocalizer sure(furnished.known);
  std::optional<Pose2D> found;
  for (int scan = 0; scan < 4 && !found; ++scan) {
    found = look(sure, scan * 100ms, {}, furnished.place.look(draw, truth));
  }
  REQUIRE(found);
  CHECK(distance(found->position(), truth.position()) < 0.1);
}

TEST_CASE("what one look cannot tell apart, a drive can") {
  // a lidar that sees 2.4 m far, beside the long wall: the ends of the room are out of sight
  Draw draw(3);
  const Room room({{{-4, 1}, {-2.5, 1}}, {{-2.5, 1}, {-2.5, 2.5}}});
  const Pose2D start{0.5, -0.5, 0.0};
  const Pose2D map_from_odom = start * inverse(Pose2D{7.0, 1.0, 2.0});
  GlobalLocalizer finder(room.known);
  std::optional<Pose2D> found;
  double driven = 0.0;
  for (int scan = 0; scan < 200 && !found; ++scan) {
    if (scan > 30) driven += 0.03;
    const Pose2D truth{start.x - driven, start.y, 0.0};
    found = look(finder, scan * 100ms, inverse(map_from_odom) * truth, room.place.look(draw, truth, 2.4));
    if (driven == 0.0) CHECK_FALSE(found);
    if (found) CHECK(distance(found->position(), truth.position()) < 0.1);
  }
  CHECK(found);
}

}  // namespace
}  // namespace threewe::slam
