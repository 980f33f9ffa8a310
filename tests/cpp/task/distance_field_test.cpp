// Fields against the exact ones they are made of.
#include "task/distance_field.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "draw.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"

namespace threewe::task {
namespace {

TEST_CASE("lengths are within 1 % or 3 cm of the exact ones, wherever a robot can be") {
  for (const char* name : {"office_v2", "cluttered_v1", "apartment_v1"}) {
    CAPTURE(name);
    const scene::SceneTables tables(std::make_shared<const scene::Scene>(scene::Scene::load(name)),
                                    Footprint::rectangle(0.25, 0.22), 0.15);
    const scene::GridFrame& frame = tables.reachable().frame;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      CAPTURE(seed);
      const Vec2 target = tables.sample_free_pose(seed).position();
      const DistanceField field(tables, target);
      const scene::GeodesicField exact = tables.geodesic_field(target);
      Draw draw(seed);

      for (std::size_t i = 0; i < frame.size(); ++i) {
        if (!tables.reachable().cells[i] || draw.whole(0, 19) != 0) continue;
        const Vec2 middle = frame.center(frame.cell(i));
        const Vec2 point{middle.x + draw(-0.025, 0.025), middle.y + draw(-0.025, 0.025)};
        const double want = exact.length_from(point);
        REQUIRE(std::isfinite(field.length_from(point)));
        CHECK(std::fabs(field.length_from(point) - want) <= std::max(0.01 * want, 0.03));
      }
    }
  }
}

TEST_CASE("no way and no place are infinitely far") {
  const scene::SceneTables tables(std::make_shared<const scene::Scene>(scene::Scene::load("office_v2")),
                                  Footprint::rectangle(0.25, 0.22), 0.15);
  const DistanceField field(tables, {2.0, 1.0});
  CHECK(std::isinf(field.length_from({1000.0, 0.0})));
  CHECK(std::isinf(field.length_from({-1000.0, 0.0})));
  CHECK(field.length_from({2.0, 1.0}) < 0.06);  // between four nodes
}

}  // namespace
}  // namespace threewe::task
