// Generated scenes are places like the others: hundreds of them, of all sizes.
#include "threewe/scene/generator.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>

#include "core/rng.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

const Footprint kWidest = Footprint::rectangle(0.28, 0.31);

// Options of all kinds, from a seed.
GeneratorOptions some_options(std::uint64_t seed) {
  const RngKey key{.seed = seed, .stream = Stream::sampler};
  return {.difficulty = uniform(key, 0), .size = {uniform(key, 1, 0, 6.0, 22.0), uniform(key, 1, 1, 6.0, 16.0)}};
}

// From room to room through every doorway: the slow way to see that all hang together.
bool rooms_are_connected(const Scene& scene) {
  std::vector<bool> reached(scene.rooms.size(), false);
  reached.front() = true;
  for (bool grown = true; grown;) {
    grown = false;
    for (const Door& door : scene.doors) {
      std::vector<std::size_t> beside;
      for (const Vec2 step : {Vec2{0.2, 0.0}, {-0.2, 0.0}, {0.0, 0.2}, {0.0, -0.2}}) {
        const Room* room = scene.room_at(door.center + step);
        if (room != nullptr) beside.push_back(static_cast<std::size_t>(room - scene.rooms.data()));
      }
      const bool any = std::ranges::any_of(beside, [&](std::size_t i) { return reached[i]; });
      for (const std::size_t i : beside) {
        if (any && !reached[i]) reached[i] = grown = true;
      }
    }
  }
  return std::ranges::all_of(reached, [](bool r) { return r; });
}

TEST_CASE("a generated scene is a place where robots can work") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    const Scene scene = generate(seed, some_options(seed));
    CHECK(rooms_are_connected(scene));

    const SceneTables tables(std::make_shared<const Scene>(scene), kWidest, 0.2);
    CHECK(tables.clearance({0.0, 0.0, 0.0}) > 0.1);
    CHECK(tables.clearance({2.0, 1.0, 0.0}) > 0.1);
    const GeodesicField from_start = tables.geodesic_field({0.0, 0.0});
    CHECK(from_start.length_from({2.0, 1.0}) < 3.0);
    for (const Room& room : scene.rooms) {
      CAPTURE(room.name);
      CHECK(scene.room_at(room.anchor) == &room);
      CHECK(from_start.length_from(room.anchor) < 100.0);
    }
  }
}

// The reader refuses overlapping walls, rooms and furniture, doors that do not fit, blocked anchors.
TEST_CASE("a building of one room is one, too") {
  std::size_t lone = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const Scene scene = generate(seed, {.difficulty = 1.0, .size = {7.0, 6.5}});
    lone += scene.rooms.size() == 1 ? 1U : 0U;
    for (const Room& room : scene.rooms) CHECK(scene.room_at(room.anchor) == &room);
  }
  CHECK(lone > 0);
}

TEST_CASE("a generated scene passes every check of the reader, and reads back equal") {
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    CAPTURE(seed);
    const Scene scene = generate(seed, some_options(seed));
    CHECK(Scene::parse(to_yaml(scene), "generated.yaml") == scene);
  }
}

TEST_CASE("a generated scene is a pure function of seed and options") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CHECK(generate(seed) == generate(seed));
    CHECK_FALSE(generate(seed) == generate(seed + 1));
  }
}

TEST_CASE("difficulty adds furniture") {
  std::size_t easy = 0;
  std::size_t hard = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    easy += generate(seed, {.difficulty = 0.0}).objects.size();
    hard += generate(seed, {.difficulty = 1.0}).objects.size();
  }
  CHECK(easy > 40 * 5);
  CHECK(hard > easy + easy / 2);
}

TEST_CASE("options out of their range are refused") {
  CHECK_THROWS_WITH_AS(generate(1, {.difficulty = 1.5}), "difficulty 1.5 is outside [0, 1]", ConfigError);
  CHECK_THROWS_WITH_AS(generate(1, {.size = {3.0, 10.0}}), "a side of 3 m is outside [6, 40]", ConfigError);
}

}  // namespace
}  // namespace threewe::scene
