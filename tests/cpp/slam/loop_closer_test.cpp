// Found again, or refused: in generated scenes, against the truth.
#include "slam/loop_closer.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/branch_and_bound_cases.hpp"
#include "slam/tiny_world.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::slam {
namespace {

using testing::Place;
using testing::place_of;

PoseBelief about(const Pose2D& truth, Draw& draw, double metres, double radians) {
  const auto off = [&](double deviation) { return deviation * normal_quantile(draw(0.01, 0.99)); };
  PoseBelief belief;
  belief.pose = {truth.x + off(metres), truth.y + off(metres), wrap_angle(truth.theta + off(radians))};
  belief.covariance.diagonal() << metres * metres, metres * metres, radians * radians;
  return belief;
}

TEST_CASE("a robot that comes back is found where it is, or not at all") {
  int tried = 0;
  int found = 0;
  for (std::uint64_t seed = 0; seed < cases(24); ++seed) {
    Draw draw(seed);
    const scene::Scene scene = scene::generate(seed);
    const Place place = place_of(scene, draw, 25, 0.10);
    const LoopCloser closer(place.map);
    for (int i = 0; i < 10; ++i) {
      CAPTURE(seed);
      CAPTURE(i);
      const Pose2D truth = place.random_pose(draw);
      const double sigma = i < 5 ? 0.1 : 1.0;
      const auto match = closer.find(place.look(draw, truth), 1, about(truth, draw, sigma, 0.1 * sigma), 0.0);
      ++tried;
      if (!match) continue;
      ++found;
      CHECK(distance(match->map_from_base.position(), truth.position()) < 0.08);
      CHECK(std::fabs(wrap_angle(match->map_from_base.theta - truth.theta)) < 0.02);
      CHECK(match->score >= 0.55);
      CHECK(match->agreement >= 0.8);
    }
  }
  MESSAGE(found << " of " << tried << " found");
  CHECK(found > tried * 3 / 4);
}

TEST_CASE("what was seen elsewhere is not found here") {
  int taken = 0;
  for (std::uint64_t seed = 0; seed < cases(24); ++seed) {
    Draw draw(seed);
    const Place here = place_of(scene::generate(seed), draw, 25, 0.10);
    const Place elsewhere = place_of(scene::generate(seed + 1000), draw, 25, 0.10);
    const LoopCloser closer(here.map);
    for (int i = 0; i < 10; ++i) {
      const Pose2D pose = here.random_pose(draw);
      const std::vector<map::Beam> view = elsewhere.look(draw, elsewhere.random_pose(draw));
      if (closer.find(view, 1, about(pose, draw, 0.5, 0.1), 0.0)) ++taken;
    }
  }
  CHECK(taken == 0);
}

TEST_CASE("a corridor's walls do not tell how far along it the robot is, a side room does") {
  using threewe::testing::TinyWall;
  const auto look = [](const std::vector<TinyWall>& walls, const Pose2D& pose) {
    std::vector<map::Beam> beams;
    for (int i = 0; i < 360; ++i) {
      const double angle = i * exact::kPi / 180.0;
      const double range = threewe::testing::tiny_range(walls, pose.position(), pose.theta + angle, 12.0);
      beams.push_back({{}, rotate({1.0, 0.0}, angle), range, range < 12.0});
    }
    return beams;
  };
  for (const bool room : {false, true}) {
    std::vector<TinyWall> walls = {{{-40, -1}, {40, -1}}, {{-40, 1}, {0, 1}}, {{4, 1}, {40, 1}}};
    if (room) {
      walls.insert(walls.end(), {{{0, 1}, {0, 4}}, {{0, 4}, {4, 4}}, {{4, 4}, {4, 1}}});
    } else {
      walls.push_back({{0, 1}, {4, 1}});
    }
    map::LogOddsMap map({.resolution = 0.10, .free_range = 4.0});
    for (double x = -8.0; x <= 8.0; x += 0.5) {
      std::vector<map::Beam> beams = look(walls, {x, 0, 0});
      for (map::Beam& beam : beams) beam.origin = {x, 0};
      map.insert(beams);
    }
    const LoopCloser closer(std::move(map));
    for (std::uint64_t seed = 0; seed < cases(20); ++seed) {
      CAPTURE(room);
      CAPTURE(seed);
      Draw draw(seed);
      const Pose2D truth{draw(0.5, 3.5), draw(-0.2, 0.2), draw(-3.0, 3.0)};
      const auto match = closer.find(look(walls, truth), 1, about(truth, draw, 0.5, 0.02), 0.0);
      CHECK(match.has_value() == room);
      if (match) CHECK(distance(match->map_from_base.position(), truth.position()) < 0.05);
    }
  }
}

}  // namespace
}  // namespace threewe::slam
