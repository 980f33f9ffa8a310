// VLN: instructions are true, lead where the path leads, and can be followed by their text alone.
#include "task/vln.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>

#include "draw.hpp"
#include "scene/scene_tables.hpp"
#include "task/interpreter.hpp"
#include "task/small_house.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/language/command.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::task {
namespace {

using scene::Scene;

constexpr std::uint32_t kEpisodes = 40;  // of each scene

const RobotProfile& robot() {
  static const RobotProfile profile = load_profile("3we_standard_v2");
  return profile;
}

std::shared_ptr<const scene::SceneTables> tables_of(Scene scene) {
  return std::make_shared<const scene::SceneTables>(std::make_shared<const Scene>(std::move(scene)),
                                                    robot().body.footprint, robot().body.height);
}

struct Sampled {
  Vln vln;
  std::vector<VlnEpisode> episodes;

  explicit Sampled(Scene scene) : vln(tables_of(std::move(scene))) {
    for (std::uint32_t i = 0; i < kEpisodes; ++i) episodes.push_back(vln.sample(7, i));
  }
};

// Episodes of every scene that is shipped, and of some that are generated; made once.
const std::map<std::string, Sampled>& everywhere() {
  static const std::map<std::string, Sampled> kAll = [] {
    std::map<std::string, Sampled> all;
    for (const std::string& name : scene::scene_names()) all.emplace(name, Sampled(Scene::load(name)));
    for (std::uint64_t seed = 10; seed < 14; ++seed) {
      Scene scene = scene::generate(seed, {.difficulty = 0.3 * static_cast<double>(seed - 10)});
      const std::string name = scene.name;
      all.emplace(name, Sampled(std::move(scene)));
    }
    return all;
  }();
  return kAll;
}

// Whether somebody with a text, and a map made of the scene alone, ends up within a metre of an episode's end.
bool succeeds(const SemanticMap& map, const std::string& text, const Vln& vln, const VlnEpisode& episode) {
  const auto reading = follow(text, map, episode.start);
  return reading && vln.distance(episode.ending, reading->end) <= kPathEndReach;
}

std::string with_sides_swapped(const std::string& text) {
  std::string swapped;
  for (const std::string& word : language::words_of(text)) {
    swapped += (word == "left" ? "right" : word == "right" ? "left" : word) + " ";
  }
  return swapped;
}

TEST_CASE("episodes keep their bounds, and their paths are shortest paths") {
  std::set<std::string> texts;
  for (const auto& [name, sampled] : everywhere()) {
    CAPTURE(name);
    const Vln& vln = sampled.vln;
    std::set<std::size_t> endings;
    for (const VlnEpisode& e : sampled.episodes) {
      CAPTURE(e.instruction);
      texts.insert(e.instruction);
      endings.insert(e.ending);
      CHECK(e.geodesic >= kShortestVlnPath);
      CHECK(e.geodesic <= kLongestVlnPath);
      CHECK(e.geodesic == vln.distance(e.ending, e.start.position()));
      CHECK(vln.tables().clearance(e.start) >= 0.05);
      CHECK(vln.tables().clearance({e.end.x, e.end.y, 1.0}) >= 0.05);
      CHECK(vln.distance(e.ending, e.end) == 0.0);
      REQUIRE(e.path.size() >= 2);
      CHECK(e.path.size() <= kMostPathPoints);
      CHECK(e.path.front() == e.start.position());
      CHECK(e.path.back() == e.end);
      double length = 0.0;
      for (std::size_t i = 1; i < e.path.size(); ++i) {
        length += distance(e.path[i - 1], e.path[i]);
        CHECK(vln.tables().obstacles().clearance(e.path[i]) > 0.07);
      }
      CHECK(length <= 1.05 * e.geodesic + 0.05);
      CHECK(length >= 0.98 * e.geodesic - 0.05);

      const auto tokens = vln.language().tokens(e.instruction);
      const std::size_t count = language::words_of(e.instruction).size();
      CHECK(count <= language::kMostTokens);
      for (std::size_t i = 0; i < tokens.size(); ++i) {
        CHECK((i < count ? tokens[i] > language::kUnknownWord : tokens[i] == language::kPadding));
      }
    }
    CHECK(endings.size() >= 8);
  }
  CHECK(texts.size() >= 0.98 * static_cast<double>(kEpisodes * everywhere().size()));
}

TEST_CASE("instructions are commands: routes to follow") {
  const language::Lexicon lexicon = language::Lexicon::load();
  for (const auto& [name, sampled] : everywhere()) {
    for (const VlnEpisode& e : sampled.episodes) {
      CAPTURE(e.instruction);
      const language::Reading reading = language::read(e.instruction, lexicon);
      REQUIRE(reading.outcome == language::ReadingOutcome::understood);
      CHECK(reading.steps.front().skill == language::Skill::follow);
    }
  }
}

TEST_CASE("a follower that has only the text and the map arrives; with another's text it does not") {
  int right = 0;
  int shuffled = 0;
  int swapped = 0;
  int with_sides = 0;
  int all = 0;
  for (const auto& [name, sampled] : everywhere()) {
    CAPTURE(name);
    const MappedScene own(sampled.vln.tables().scene(), robot().body.footprint, robot().body.height);
    for (std::size_t i = 0; i < sampled.episodes.size(); ++i) {
      const VlnEpisode& e = sampled.episodes[i];
      const std::string& other = sampled.episodes[(i + 1) % sampled.episodes.size()].instruction;
      ++all;
      right += succeeds(own.map, e.instruction, sampled.vln, e) ? 1 : 0;
      shuffled += succeeds(own.map, other, sampled.vln, e) ? 1 : 0;
      const std::string mirrored = with_sides_swapped(e.instruction);
      if (language::words_of(mirrored) == language::words_of(e.instruction)) continue;
      ++with_sides;
      swapped += succeeds(own.map, mirrored, sampled.vln, e) ? 1 : 0;
    }
  }
  MESSAGE(right, " of ", all, " followed; ", shuffled, " with another's text; of ", with_sides,
          " that name a side, with left and right swapped ", swapped);
  CHECK(right >= 0.98 * all);
  CHECK(shuffled <= 0.30 * all);
  CHECK(swapped <= 0.30 * with_sides);
}

// What a path does where an instruction says "left" or "right", from the path's own points.
TEST_CASE("what is said of left and right is true of the path") {
  int turns = 0;
  int passes = 0;
  for (const auto& [name, sampled] : everywhere()) {
    CAPTURE(name);
    const SemanticMap& map = sampled.vln.map();
    for (const VlnEpisode& e : sampled.episodes) {
      CAPTURE(e.instruction);
      const Instruction said = parse(e.instruction, map);
      // the first turn: which way the first metre goes
      if (said[0].kind == Clause::Kind::turn && said[0].side != Side::ahead) {
        const Vec2 way = e.path[std::min<std::size_t>(4, e.path.size() - 1)] - e.path[0];
        const Vec2 in_robot = rotate((1.0 / norm(way)) * way, -e.start.theta);
        ++turns;
        if (said[0].side == Side::left) CHECK(in_robot.y > 0.1);
        if (said[0].side == Side::right) CHECK(in_robot.y < -0.1);
        if (said[0].side == Side::behind) CHECK(in_robot.x < -0.1);
      }
      // things passed: somewhere the path goes by such a thing on that side
      const std::vector<Vec2> points = points_along(e.path, 0.05);
      for (const Clause& clause : said) {
        if (clause.kind != Clause::Kind::pass) continue;
        ++passes;
        bool passed = false;
        for (const Landmark& thing : map.landmarks()) {
          if (!thing.is_called(clause.thing.noun)) continue;
          for (std::size_t i = 1; i < points.size(); ++i) {
            const Vec2 step = points[i] - points[i - 1];
            const Vec2 to = thing.center - points[i];
            const bool abeam = std::abs(dot(step, to)) < 0.5 * norm(step) * norm(to) && norm(to) < 2.0;
            passed = passed || (abeam && (cross(step, to) > 0.0) == (clause.side == Side::left));
          }
        }
        CHECK(passed);
      }
    }
  }
  MESSAGE(turns, " turns and ", passes, " things passed");
  CHECK(turns > 100);
  CHECK(passes > 100);
}

TEST_CASE("an episode is a function of seed and index alone") {
  const Sampled& office = everywhere().at("office_v2");
  const Vln again(tables_of(Scene::load("office_v2")));
  for (std::uint32_t i = 0; i < kEpisodes; ++i) CHECK(again.sample(7, i) == office.episodes[i]);
  CHECK_FALSE(again.sample(8, 0) == office.episodes[0]);
  std::set<std::uint64_t> seeds;
  for (const VlnEpisode& e : office.episodes) seeds.insert(e.seed);
  CHECK(seeds.size() == kEpisodes);
}

TEST_CASE("reward is progress along the shortest path, and STOP is right within a metre of the end") {
  const Sampled& house = everywhere().at("apartment_v1");
  const Vln& vln = house.vln;
  const std::array<float, 3> drive = {1.0F, 0.0F, 0.0F};
  const std::array<float, 3> stand = {0.0F, 0.0F, 0.0F};
  for (const VlnEpisode& e : house.episodes) {
    CAPTURE(e.instruction);
    VlnState state = vln.begin(e);
    double sum = 0.0;
    for (const Vec2 point : e.path) sum += vln.step(e, state, point, drive, 100ms).reward;
    CHECK(sum == doctest::Approx(e.geodesic));
    CHECK(ndtw(state.score, e.path) > 0.95);
    StopTaskStep step;
    for (int i = 0; i < 5; ++i) {
      CHECK_FALSE(step.terminated);
      step = vln.step(e, state, e.end, stand, 100ms);
    }
    CHECK(step == StopTaskStep{.reward = 10.0, .terminated = true, .success = true});

    // half way there it is wrong, unless that is within a metre
    VlnState early = vln.begin(e);
    const Vec2 there = e.path[e.path.size() / 2];
    for (int i = 0; i < 5; ++i) step = vln.step(e, early, there, stand, 100ms);
    CHECK(step.terminated);
    CHECK(step.success == (vln.distance(e.ending, there) <= kPathEndReach));
  }
}

TEST_CASE("a scene without rooms has no instructions, and says so") {
  Scene empty = small_house();
  empty.rooms.clear();
  std::string message;
  try {
    const Vln vln(tables_of(empty));
  } catch (const ConfigError& error) {
    message = error.what();
  }
  CHECK(message ==
        "scene 'house' has no instructions: named rooms, ways between them and paths of 3 to 20 m are needed");
}

}  // namespace
}  // namespace threewe::task
