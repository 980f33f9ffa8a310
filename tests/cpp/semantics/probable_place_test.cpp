#include "semantics/probable_place.hpp"

#include <doctest/doctest.h>

#include "threewe/core/camera.hpp"

using namespace threewe;
using semantics::SemanticMap;

namespace {

const std::vector<std::string> kLabels = {"background", "refrigerator", "counter", "bed"};

// A map in which something of each kind stands at a place.
SemanticMap map_with(const std::vector<std::pair<std::size_t, Vec2>>& things) {
  SemanticMap map(kLabels);
  map::OccupancyGrid grid;
  grid.width = grid.height = 400;
  grid.origin = {-10.0, -10.0};
  grid.data.assign(160000, map::OccupancyGrid::kFree);
  const CameraIntrinsics camera = make_intrinsics(640, 480, 1.57);
  for (int view = 0; view < 8; ++view) {
    for (const auto& [kind, at] : things) {
      vision::Detection detection;
      detection.kind = kind;
      detection.scores.assign(kLabels.size(), 0.02F);
      detection.scores[kind] = 0.9F;
      detection.confidence = 0.9F;
      detection.cells = 20;
      detection.distance = 3.0 - 0.3 * view;
      detection.colors[0] = 1.0F;
      const std::vector views{detection};
      map.update({from_seconds(view), {at.x - detection.distance, at.y, 0.0}, views, camera}, grid);
    }
  }
  return map;
}

}  // namespace

TEST_CASE("a refrigerator and a counter make a kitchen, one of them does not") {
  const SemanticMap both = map_with({{1, {1.0, 1.0}}, {2, {2.0, 1.5}}});
  const auto kitchen = probable_place(both, "kitchen");
  REQUIRE(kitchen);
  CHECK(kitchen->name == "kitchen");
  CHECK(kitchen->origin == semantics::kSeen);
  REQUIRE(kitchen->polygon.size() == 1);
  CHECK(norm(kitchen->polygon.front() - Vec2{1.5, 1.25}) < 0.6);
  CHECK_FALSE(probable_place(both, "bedroom"));
  CHECK_FALSE(probable_place(both, "bathroom"));  // no things say that

  CHECK_FALSE(probable_place(map_with({{1, {1.0, 1.0}}}), "kitchen"));
  CHECK_FALSE(probable_place(map_with({{1, {1.0, 1.0}}, {2, {7.0, 1.5}}}), "kitchen"));  // far from one another
  CHECK_FALSE(probable_place(map_with({{1, {1.0, 1.0}}, {1, {2.0, 1.5}}}), "kitchen"));  // two say no more than one
  CHECK(probable_place(map_with({{3, {0.0, 4.0}}}), "bedroom"));
  CHECK_FALSE(probable_place(SemanticMap(kLabels), "kitchen"));
}

TEST_CASE("a counter says where a refrigerator is, and a bed does not") {
  const SemanticMap map = map_with({{2, {1.0, 1.0}}, {3, {6.0, 1.0}}});
  const auto refrigerator = semantics::hints(map, "refrigerator");
  CHECK(semantics::share_at(refrigerator, {2.0, 1.5}) > 0.5);
  CHECK(semantics::share_at(refrigerator, {6.0, 1.5}) == 0.0);
  CHECK(semantics::hints(map, "bed").empty());  // nothing else there makes a bedroom
  CHECK(semantics::hints(map, "tree").empty());
}
