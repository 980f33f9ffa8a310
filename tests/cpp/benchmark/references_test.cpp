// References know nothing beforehand, go through nothing, and are hard to beat.
#include <doctest/doctest.h>

#include <limits>
#include <memory>
#include <string>

#include "benchmark/nearest_frontier.hpp"
#include "benchmark/optimistic_replanning.hpp"
#include "draw.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::benchmark {
namespace {

using scene::Scene, scene::SceneTables;

std::shared_ptr<const SceneTables> tables_of(Scene scene, const RobotProfile& profile) {
  return std::make_shared<const SceneTables>(std::make_shared<const Scene>(std::move(scene)), profile.body.footprint,
                                             profile.body.height);
}

// A hall of 12 x 8 m, from -2 to 10 and from -4 to 4, with more walls in it.
std::shared_ptr<const SceneTables> hall(const std::string& walls, const RobotProfile& profile) {
  const std::string text =
      "name: hall\ndescription: a hall\nstarts: [[2, 4]]\nwalls:\n  - {a: [0, 0], b: [12, 0], thickness: 0.1}\n"
      "  - {a: [12, 0], b: [12, 8], thickness: 0.1}\n  - {a: [12, 8], b: [0, 8], thickness: 0.1}\n"
      "  - {a: [0, 8], b: [0, 0], thickness: 0.1}\n" +
      walls;
  return tables_of(Scene::parse(text, "hall.yaml"), profile);
}

TEST_CASE("where nothing is in the way the optimist drives straight, at the speed limit") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const auto tables = hall("", profile);
  const ReferenceDrive drive = optimistic_replanning(*tables, profile, {}, {6.0, 2.5});
  CHECK(drive.reached);
  CHECK(drive.length == doctest::Approx(6.5).epsilon(0.002));
  CHECK(drive.duration == doctest::Approx(drive.length / profile.operating_limits.linear));
}

TEST_CASE("a wall that is seen beforehand costs the optimist nothing, one that is hidden a detour") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  // the goal is behind a wall whose southern end is nearer; both ends are in sight
  const auto open = hall("  - {a: [6, 2], b: [6, 7], thickness: 0.1}\n", profile);
  const ReferenceDrive seen = optimistic_replanning(*open, profile, {}, {8.0, 0.0});
  CHECK(seen.length < 1.03 * open->geodesic({0.0, 0.0}, {8.0, 0.0}));

  // a dead end: from outside nobody can tell that its back is closed
  const auto closed = hall(
      "  - {a: [4, 3.5], b: [7, 3.5], thickness: 0.1}\n  - {a: [7, 3.5], b: [7, 4.5], thickness: 0.1}\n"
      "  - {a: [7, 4.5], b: [4, 4.5], thickness: 0.1}\n",
      profile);
  const double shortest = closed->geodesic({0.0, 0.0}, {8.0, 0.0});
  const ReferenceDrive hidden = optimistic_replanning(*closed, profile, {}, {8.0, 0.0});
  CHECK(hidden.reached);
  CHECK(hidden.length < 1.2 * shortest);  // its back is seen from the start
}

TEST_CASE("nobody gets through a wall, and the optimist finds that out") {
  const RobotProfile profile = load_profile("turtlebot_like");
  const auto tables = hall("  - {a: [6, 0], b: [6, 8], thickness: 0.1}\n", profile);
  const ReferenceDrive drive = optimistic_replanning(*tables, profile, {}, {8.0, 0.0});
  CHECK_FALSE(drive.reached);
  CHECK(drive.length < 60.0);
}

TEST_CASE("a place outside of the building is refused by name") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const auto tables = hall("", profile);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Vec2 outside : {Vec2{100.0, 100.0}, Vec2{-8.0, 3.0}, Vec2{kNan, 0.0}}) {
    CHECK_THROWS_AS(optimistic_replanning(*tables, profile, {}, outside), ContractError);
    CHECK_THROWS_AS(optimistic_replanning(*tables, profile, {outside.x, outside.y, 0.0}, {6.0, 2.5}), ContractError);
    CHECK_THROWS_AS(nearest_frontier(tables, profile, {outside.x, outside.y, 0.0}), ContractError);
  }
  CHECK_THROWS_WITH(optimistic_replanning(*tables, profile, {}, {20.0, 0.0}),
                    doctest::Contains("goal: (20, 0) is outside of scene 'hall', which spans"));
}

TEST_CASE("in drawn buildings the optimist arrives, no shorter than the truth and seldom much longer") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  double shortest = 0.0;
  double driven = 0.0;
  for (std::uint64_t seed = 0; seed < cases(12); ++seed) {
    CAPTURE(seed);
    const auto tables = tables_of(scene::generate(seed, {}), profile);
    const scene::Episode episode = scene::sample_episode(*tables, seed, 0);
    const ReferenceDrive drive = optimistic_replanning(*tables, profile, episode.start, episode.goal);
    CHECK(drive.reached);
    CHECK(drive.length > 0.98 * episode.geodesic);
    const ReferenceDrive again = optimistic_replanning(*tables, profile, episode.start, episode.goal);
    CHECK(again.length == drive.length);
    shortest += episode.geodesic;
    driven += drive.length;
  }
  CHECK(driven < 1.35 * shortest);
}

TEST_CASE("the nearest frontier leads through a whole building") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    CAPTURE(seed);
    const auto tables = tables_of(scene::generate(seed, {}), profile);
    const ReferenceExploration exploration = nearest_frontier(tables, profile, tables->sample_free_pose(seed));
    CHECK(exploration.coverage > 0.95);
    CHECK(exploration.length < 300.0);
  }
  const auto empty = hall("", profile);
  const ReferenceExploration look = nearest_frontier(empty, profile, {});
  CHECK(look.coverage > 0.97);
  CHECK(look.length < 12.0);
}

TEST_CASE("without a lidar there is no reference") {
  const RobotProfile profile = load_profile("3we_base_v2");
  const auto tables = hall("", profile);
  CHECK_THROWS_WITH_AS(optimistic_replanning(*tables, profile, {}, {1.0, 0.0}),
                       "robot '3we_base_v2' has no sensor 'lidar', which the reference needs", HardwareError);
}

}  // namespace
}  // namespace threewe::benchmark
