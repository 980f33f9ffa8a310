#include "semantics/semantic_map.hpp"

#include <cmath>

#include <doctest/doctest.h>

#include "threewe/core/errors.hpp"

using namespace threewe;
using semantics::SemanticMap;

namespace {

const std::vector<std::string> kLabels = {"background", "chair", "plant"};

// A plant or chair at a bearing and distance.
vision::Detection seen(std::size_t kind, double bearing, double distance) {
  vision::Detection detection;
  detection.kind = kind;
  detection.scores = {0.1F, kind == 1 ? 0.8F : 0.1F, kind == 2 ? 0.8F : 0.1F};
  detection.confidence = 0.8F;
  detection.cells = 20;
  detection.bearing = bearing;
  detection.distance = distance;
  detection.colors[4] = 1.0F;
  return detection;
}

map::OccupancyGrid free_floor() {
  map::OccupancyGrid grid;
  grid.width = grid.height = 200;
  grid.origin = {-5.0, -5.0};
  grid.data.assign(40000, map::OccupancyGrid::kFree);
  return grid;
}

// Looks six times on a straight way, every 0.3 m; `detect(i, x)` is what look i shows, x [m] from where it began.
template <class Detect>
void look_on_the_way(SemanticMap& map, const Detect& detect) {
  const auto grid = free_floor();
  const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
  for (int i = 0; i < 6; ++i) {
    const double x = 0.3 * i;
    const std::vector<vision::Detection> views = detect(i, x);
    map.update({from_seconds(i), {x, 0.0, 0.0}, views, camera}, grid);
  }
}

}  // namespace

TEST_CASE("what is seen from several poses is one thing, where it is; a second of another kind is another") {
  SemanticMap map(kLabels);
  look_on_the_way(map, [](int, double x) {
    return std::vector{seen(2, 0.0, 3.0 - x), seen(1, std::atan2(1.0, 2.5 - x), 2.5 - x)};
  });
  const auto things = map.things();
  REQUIRE(things.size() == 2);
  const auto plants = map.find({.kind = "plant", .color = "", .place = ""});
  REQUIRE(plants.size() == 1);
  CHECK(norm(plants[0].position - Vec2{3.0, 0.0}) < 0.1);
  CHECK(plants[0].views == 6);
  CHECK(plants[0].kinds[2] > 0.75);
  CHECK(map.find({.kind = "chair", .color = "blue", .place = ""}).empty());
  CHECK_THROWS_AS((void)map.find({.kind = "chiar", .color = "", .place = ""}), ContractError);
}

TEST_CASE("a thing has the colors of all that is seen of it, not of the most alone") {
  SemanticMap map(kLabels);
  look_on_the_way(map, [](int i, double x) {
    auto detection = seen(1, 0.0, 3.0 - x);
    detection.colors = {};
    detection.colors[2] = i % 2 == 0 ? 0.6F : 0.5F;
    detection.colors[8] = 1.0F - detection.colors[2];
    return std::vector{detection};
  });
  REQUIRE(map.things().size() == 1);
  const auto colors = map.things()[0].colors;
  CHECK(colors[2] > 0.5);
  CHECK(colors[2] < 0.6);
  CHECK(std::abs(colors[2] + colors[8] - 1.0) < 1e-6);
}

TEST_CASE("views from one side say the same once more, views from around a thing say more") {
  const auto probability = [](double bearing_step, int views) {
    SemanticMap map(kLabels);
    const auto grid = free_floor();
    const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
    for (int i = 0; i < views; ++i) {  // on an arc of 2 m around (3, 0), by turns nearer and farther
      const double angle = bearing_step * i;
      const double range = i % 2 == 0 ? 2.0 : 2.3;
      const Pose2D from{3.0 - range * std::cos(angle), -range * std::sin(angle), angle};
      const std::vector views_of_it{seen(2, 0.0, range)};
      map.update({from_seconds(i), from, views_of_it, camera}, grid);
    }
    REQUIRE(map.things().size() == 1);
    return map.things()[0].kinds[2];
  };
  const double once = probability(0.0, 2);
  CHECK(probability(0.0, 6) < once + 0.1);
  CHECK(probability(1.0, 6) > probability(0.0, 6) + 0.1);
  CHECK(probability(1.0, 6) > 0.85);
  CHECK(probability(0.0, 60) < 0.95);  // however often
}

TEST_CASE("one large thing that is seen at both ends is one, two small ones as far apart are two") {
  for (const double radius : {0.3, 1.2}) {
    CAPTURE(radius);
    SemanticMap map(kLabels, {0.0, radius, 0.0});
    const auto grid = free_floor();
    const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
    for (int i = 0; i < 4; ++i) {
      const double x = 0.3 * i;
      const std::vector views{seen(1, std::atan2(0.4, 2.0 - x), 2.0 - x), seen(1, std::atan2(-0.4, 2.0 - x), 2.0 - x)};
      map.update({from_seconds(i), {x, 0.0, 0.0}, views, camera}, grid);
    }
    const auto things = map.things();
    REQUIRE(things.size() == (radius < 1.0 ? 2 : 1));
    if (radius > 1.0) CHECK(norm(things[0].position - Vec2{2.0, 0.0}) < 0.25);
  }
}

TEST_CASE("what is gone is forgotten, unless something stands in between") {
  for (const bool hidden : {false, true}) {
    CAPTURE(hidden);
    SemanticMap map(kLabels);
    auto grid = free_floor();
    const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
    for (int i = 0; i < 2; ++i) {
      const std::vector views{seen(2, 0.0, 2.0 - 0.3 * i)};
      map.update({from_seconds(i), {0.3 * i, 0.0, 0.0}, views, camera}, grid);
    }
    REQUIRE(map.things().size() == 1);
    if (hidden) {
      for (int y = -10; y <= 10; ++y) grid.data[grid.index(grid.cell({1.0, 0.05 * y}))] = map::OccupancyGrid::kOccupied;
    }
    for (int i = 0; i < 10; ++i) map.update({from_seconds(10 + i), {0.3, 0.0, 0.0}, {}, camera}, grid);
    CHECK(map.things().size() == (hidden ? 1 : 0));
  }
}

TEST_CASE(
    "a thing is where its surface is by the lidar's map or the depth image, where that agrees with how it looks") {
  const CameraIntrinsics camera = make_intrinsics(64, 48, 1.57);
  enum class Range : std::uint8_t { none, lidar, depth, far };
  for (const Range by : {Range::none, Range::lidar, Range::depth, Range::far}) {
    CAPTURE(static_cast<int>(by));
    SemanticMap map(kLabels, {0.0, 0.0, 0.3});
    auto grid = free_floor();
    const double wall = by == Range::far ? 4.5 : 1.8;  // of a plant of radius 0.3 m whose centre is 2.01 m away
    if (by == Range::lidar || by == Range::far) {
      for (int y = -40; y <= 40; ++y)
        grid.data[grid.index(grid.cell({wall + 0.02, 0.05 * y}))] = map::OccupancyGrid::kOccupied;
    }
    std::vector<float> depth;
    if (by == Range::depth) depth.assign(std::size_t{64} * 48, 1.8F);
    vision::Detection plant = seen(2, 0.0, 2.4);  // it seems farther away than it is
    plant.x_min = 20, plant.x_max = 44, plant.y_min = 10, plant.y_max = 40;
    const std::vector views{plant};
    for (int i = 0; i < 2; ++i) {
      const Pose2D from{0.0, 0.3 * i, 0.0};
      map.update({from_seconds(i), from, views, camera, depth, 0.003}, grid);
    }
    REQUIRE(map.things().size() == 1);
    const auto thing = map.things().front();
    const bool ranged = by == Range::lidar || by == Range::depth;
    CHECK(thing.position.x == doctest::Approx(ranged ? 2.01 : 2.4).epsilon(0.03));
    CHECK(thing.covariance[0] < (ranged ? 0.01 : 0.2));
    CHECK((thing.covariance[0] < thing.covariance[2]) == ranged);
  }
}

TEST_CASE("a closed loop moves things by how lately they were seen, and turns their covariances") {
  SemanticMap map(kLabels);
  const auto grid = free_floor();
  const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
  const auto look = [&](double second, std::size_t kind, const Pose2D& from) {
    const std::vector views{seen(kind, 0.0, 2.0)};
    map.update({from_seconds(second), from, views, camera}, grid);
  };
  for (const double shift : {0.0, 0.3}) {
    look(1.0 + shift, 1, {-4.0, -3.0 + shift, 0.0});
    look(50.0 + shift, 1, {-4.0, 3.0 + shift, 0.0});
    look(100.0 + shift, 2, {shift, 0.0, 0.0});
  }
  const auto before = map.things();
  REQUIRE(before.size() == 3);
  const double turn = 0.5;
  map.move({0.3, 0.0, 0.0}, {0.8, 0.2, turn}, from_seconds(100.3));
  const auto after = map.things();
  CHECK(norm(after[0].position - before[0].position) < 0.1);  // of before the loop
  const double half = norm(after[1].position - before[1].position);
  CHECK(half > 0.5);
  const Pose2D correction = Pose2D{0.8, 0.2, turn} * inverse(Pose2D{0.3, 0.0, 0.0});
  CHECK(norm(after[2].position - correction * before[2].position) < 1e-9);
  CHECK(half < norm(correction * before[1].position - before[1].position));

  const auto& c = after[2].covariance;  // along the new line of sight as it was along the old one
  const Vec2 along{std::cos(turn), std::sin(turn)};
  CHECK(c[0] * along.x * along.x + 2.0 * c[1] * along.x * along.y + c[2] * along.y * along.y ==
        doctest::Approx(before[2].covariance[0]));
  CHECK(c[0] * c[2] - c[1] * c[1] == doctest::Approx(before[2].covariance[0] * before[2].covariance[2] -
                                                     before[2].covariance[1] * before[2].covariance[1]));

  // what was seen before the last correction was put right by it
  map.move({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, from_seconds(140.0));
  CHECK(norm(map.things()[2].position - after[2].position) < 1e-2);
}

TEST_CASE("a place has a name, holds what is in it, and is named by the nearest name where it is unknown") {
  SemanticMap map(kLabels);
  map.name_place({.name = "kitchen", .polygon = {{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {0.0, 2.0}}});
  map.name_place({.name = "post", .polygon = {{5.0, 0.0}}});
  CHECK(SemanticMap::contains(map.place("kitchen"), {1.0, 1.9}));
  CHECK_FALSE(SemanticMap::contains(map.place("kitchen"), {1.0, 2.1}));
  CHECK(SemanticMap::contains(map.place("post"), {6.0, 0.0}));
  CHECK(SemanticMap::center(map.place("kitchen")) == Vec2{1.0, 1.0});
  CHECK_THROWS_WITH_AS((void)map.place("kichen"), doctest::Contains("kitchen"), ContractError);
  CHECK_THROWS_AS(map.name_place({.name = "start", .polygon = {{0.0, 0.0}}}), ContractError);
  CHECK_THROWS_AS(map.name_place({.name = "line", .polygon = {{0.0, 0.0}, {1.0, 0.0}}}), ContractError);
}
