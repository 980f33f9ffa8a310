// Episodes and free poses: valid, spread out, and the same for the same seed.
#include "scene/episodes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>

#include "core/exact.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

const SceneTables& office() {
  static const SceneTables tables(std::make_shared<const Scene>(Scene::load("office_v2")),
                                  Footprint::rectangle(0.25, 0.22), 0.2);
  return tables;
}

TEST_CASE("episodes keep their bounds") {
  constexpr std::uint32_t kEpisodes = 200;
  int detours = 0;
  std::set<std::uint64_t> seeds;
  for (std::uint32_t i = 0; i < kEpisodes; ++i) {
    CAPTURE(i);
    const Episode episode = sample_episode(office(), 11, i);
    const Vec2 start = episode.start.position();
    CHECK(episode.geodesic >= kShortestEpisode);
    CHECK(episode.geodesic <= kLongestEpisode);
    CHECK(episode.geodesic >= distance(start, episode.goal));
    for (const double heading : {episode.start.theta, 0.0, 1.0, 2.0}) {
      CHECK(office().clearance({start.x, start.y, heading}) >= 0.05);
      CHECK(office().clearance({episode.goal.x, episode.goal.y, heading}) >= 0.05);
    }
    if (i < 20) CHECK(office().geodesic(start, episode.goal) == doctest::Approx(episode.geodesic).epsilon(0.01));
    detours += episode.geodesic > kDetour * distance(start, episode.goal) ? 1 : 0;
    seeds.insert(episode.seed);
  }
  CHECK(seeds.size() == kEpisodes);
  // 20 % of 200, within four standard deviations of a binomial
  CHECK(detours > 40 - 23);
  CHECK(detours < 40 + 23);
}

TEST_CASE("an episode is a function of seed and index alone") {
  const Episode episode = sample_episode(office(), 3, 5);
  CHECK(sample_episode(office(), 3, 5) == episode);
  CHECK_FALSE(sample_episode(office(), 3, 6) == episode);
  CHECK_FALSE(sample_episode(office(), 4, 5) == episode);
  const SceneTables again(std::make_shared<const Scene>(Scene::load("office_v2")), Footprint::rectangle(0.25, 0.22),
                          0.2);
  CHECK(sample_episode(again, 3, 5) == episode);
}

TEST_CASE("free poses are free, reachable and uniform") {
  constexpr std::uint64_t kPoses = 20000;
  std::map<std::string, double> expected;
  const GridFrame& frame = office().passable().frame;
  for (const std::size_t i : office().roomy()) {
    const Room* room = office().scene().room_at(frame.center(frame.cell(i)));
    expected[room ? room->name : ""] += static_cast<double>(kPoses) / static_cast<double>(office().roomy().size());
  }
  std::map<std::string, double> drawn;
  std::array<double, 8> headings{};
  for (std::uint64_t seed = 0; seed < kPoses; ++seed) {
    const Pose2D pose = office().sample_free_pose(seed);
    if (seed < 500) {
      CAPTURE(seed);
      CHECK(office().clearance(pose) >= 0.05);
      CHECK(office().reachable()[frame.cell(pose.position())]);
    }
    const Room* room = office().scene().room_at(pose.position());
    drawn[room ? room->name : ""] += 1.0;
    headings[static_cast<std::size_t>((pose.theta / exact::kPi + 1.0) * 3.9999)] += 1.0;
  }

  // chi-squared over rooms and eighths of a turn: 0.1 % of fair samples exceed these
  double rooms = 0.0;
  for (const auto& [name, count] : expected) rooms += (drawn[name] - count) * (drawn[name] - count) / count;
  CHECK(rooms < 29.6);
  double turns = 0.0;
  for (const double count : headings) turns += (count - kPoses / 8.0) * (count - kPoses / 8.0) / (kPoses / 8.0);
  CHECK(turns < 24.3);
  CHECK(office().sample_free_pose(9) == office().sample_free_pose(9));
}

TEST_CASE("a hall without detours still has episodes, and one without distances has none") {
  const auto hall = [](const std::string& size) {
    return SceneTables(std::make_shared<const Scene>(Scene::parse(
                           "name: hall\ndescription: empty\nstarts: [[0, 0]]\nwalls:\n  - {a: [-1, -1], b: [" + size +
                               ", -1]}\n  - {a: [" + size + ", -1], b: [" + size + ", 1]}\n  - {a: [" + size +
                               ", 1], b: [-1, 1]}\n  - {a: [-1, 1], b: [-1, -1]}\n",
                           "hall.yaml")),
                       Footprint::rectangle(0.25, 0.22), 0.2);
  };
  const SceneTables long_hall = hall("4");
  for (std::uint32_t i = 0; i < 20; ++i) {
    const Episode episode = sample_episode(long_hall, 1, i);
    CHECK(episode.geodesic == doctest::Approx(distance(episode.start.position(), episode.goal)).epsilon(1e-3));
  }
  CHECK_THROWS_WITH_AS(sample_episode(hall("0.4"), 1, 0), doctest::Contains("no two places"), ConfigError);
}

TEST_CASE("a robot that is too large for a scene is told so") {
  const auto corridor = std::make_shared<const Scene>(Scene::load("corridor_v1"));
  CHECK_THROWS_WITH_AS(SceneTables(corridor, Footprint::rectangle(2.2, 2.2), 0.5),
                       doctest::Contains("no room for a robot"), ConfigError);
}

}  // namespace
}  // namespace threewe::scene
