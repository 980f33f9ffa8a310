// ObjectNav: episodes keep their promises, and success is what a picture shows.
#include "task/object_nav.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "core/exact.hpp"
#include "draw.hpp"
#include "scene/scene_tables.hpp"
#include "task/slow_sight.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::task {
namespace {

using scene::Scene;
using scene::SceneTables;
using scene::Solid;

const RobotProfile& robot() {
  static const RobotProfile profile = load_profile("3we_standard_v2");
  return profile;
}

std::shared_ptr<const SceneTables> tables_of(Scene scene) {
  return std::make_shared<const SceneTables>(std::make_shared<const Scene>(std::move(scene)), robot().body.footprint,
                                             robot().body.height);
}

// In every scene that is shipped, and in some that are generated; made once.
const std::map<std::string, ObjectNav>& everywhere() {
  static const std::map<std::string, ObjectNav> kAll = [] {
    std::map<std::string, ObjectNav> all;
    for (const std::string& name : scene::scene_names())
      all.emplace(name, ObjectNav(tables_of(Scene::load(name)), robot()));
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      Scene scene = scene::generate(seed, {.difficulty = 0.3 * static_cast<double>(seed), .size = {12.0, 9.0}});
      const std::string name = scene.name;
      all.emplace(name, ObjectNav(tables_of(std::move(scene)), robot()));
    }
    return all;
  }();
  return kAll;
}

Eye eye_at(const Pose2D& base) { return {base * robot().camera->base_from_camera, robot().camera->mount_height}; }

std::vector<Solid> solids_of(const Scene& scene, std::size_t object) {
  std::vector<Solid> solids = scene.solids();
  std::erase_if(solids, [&](const Solid& s) { return s.object != static_cast<int>(object); });
  return solids;
}

// The ids of a frame, by the ray tracer.
std::vector<std::int16_t> slow_ids(const Scene& scene, const Pose2D& base) {
  const std::vector<Solid> solids = scene.solids();
  std::vector<std::int16_t> ids;
  for (const int i : slow_picture(robot().camera->intrinsics(), eye_at(base), solids)) {
    const int object = i < 0 ? -1 : solids[static_cast<std::size_t>(i)].object;
    ids.push_back(static_cast<std::int16_t>(object < 0 ? 2 : kFirstObjectId + object));
  }
  return ids;
}

// As many ids as a frame would have of each object nearby, in no order.
std::vector<std::int16_t> ids_near(const Scene& scene, const Pose2D& base) {
  const std::vector<Solid> all = scene.solids();
  std::vector<std::int16_t> ids(1, 2);
  for (std::size_t k = 0; k < scene.objects.size(); ++k) {
    if (distance(scene.objects[k].pose.position(), base.position()) > 3.0) continue;
    std::vector<Solid> others = all;
    std::erase_if(others, [&](const Solid& s) { return s.object == static_cast<int>(k); });
    const int seen = visible_pixels(robot().camera->intrinsics(), eye_at(base), solids_of(scene, k), others);
    ids.insert(ids.end(), static_cast<std::size_t>(seen),
               static_cast<std::int16_t>(kFirstObjectId + static_cast<int>(k)));
  }
  return ids;
}

double footprint_distance(std::span<const Solid> solids, Vec2 p) {
  double nearest = 1e9;
  for (const Solid& solid : solids) nearest = std::min(nearest, distance_to(solid, p));
  return nearest;
}

TEST_CASE("episodes start where nothing of the kind is near or in view") {
  for (const auto& [name, nav] : everywhere()) {
    CAPTURE(name);
    const Scene& scene = nav.tables().scene();
    const std::vector<Solid> all = scene.solids();
    for (std::uint32_t i = 0; i < cases(12); ++i) {
      CAPTURE(i);
      const ObjectNavEpisode episode = nav.sample(5, i);
      CHECK(std::ranges::find(nav.goals(), episode.goal) != nav.goals().end());
      CHECK(nav.tables().clearance(episode.start) >= 0.05);
      CHECK(episode.geodesic == nav.distance(episode.goal, episode.start.position()));
      CHECK(episode.geodesic < 60.0);
      CHECK(nav.begin(episode).distance == episode.geodesic);
      double straight = 1e9;
      for (std::size_t k = 0; k < scene.objects.size(); ++k) {
        if (scene.objects[k].category != kObjectGoals[episode.goal]) continue;
        const std::vector<Solid> solids = solids_of(scene, k);
        straight = std::min(straight, footprint_distance(solids, episode.start.position()));
        std::vector<Solid> others = all;
        std::erase_if(others, [&](const Solid& s) { return s.object == static_cast<int>(k); });
        CHECK(visible_pixels(robot().camera->intrinsics(), eye_at(episode.start), solids, others) < kGoalPixels);
      }
      // no path is shorter than the straight line, and it ends within reach
      CHECK(episode.geodesic + kGoalReach >= straight - 0.1);
    }
  }
}

TEST_CASE("episodes in sight start where the camera shows something of the kind") {
  for (const auto& [name, nav] : everywhere()) {
    CAPTURE(name);
    const Scene& scene = nav.tables().scene();
    const std::vector<Solid> all = scene.solids();
    for (std::uint32_t i = 0; i < cases(12); ++i) {
      CAPTURE(i);
      const ObjectNavEpisode episode = nav.sample_in_sight(5, i);
      CHECK(episode == nav.sample_in_sight(5, i));
      CHECK(nav.tables().clearance(episode.start) >= 0.05);
      CHECK(episode.geodesic == nav.distance(episode.goal, episode.start.position()));
      double nearest = 1e9;
      std::set<std::size_t> shown;
      for (std::size_t k = 0; k < scene.objects.size(); ++k) {
        const auto* const kind = std::ranges::find(kObjectGoals, scene.objects[k].category);
        if (kind == kObjectGoals.end()) continue;
        const auto goal = static_cast<std::size_t>(kind - kObjectGoals.begin());
        const std::vector<Solid> solids = solids_of(scene, k);
        const double away = footprint_distance(solids, episode.start.position());
        if (goal == episode.goal) nearest = std::min(nearest, away);
        if (away > kSightFarthest || std::ranges::find(nav.goals(), goal) == nav.goals().end()) continue;
        std::vector<Solid> others = all;
        std::erase_if(others, [&](const Solid& s) { return s.object == static_cast<int>(k); });
        const CameraIntrinsics camera = robot().camera->intrinsics();
        const int seen = visible_pixels(camera, eye_at(episode.start), solids, others);
        const int silhouette = visible_pixels(camera, eye_at(episode.start), solids, {});
        if (seen >= kGoalPixels && seen >= kGoalShare * silhouette) shown.insert(goal);
      }
      CHECK(nearest >= kSightNearest);
      CHECK(nearest <= kSightFarthest);
      CHECK(shown.contains(episode.goal));
      const std::vector<std::size_t> kinds = nav.in_sight(episode.start);
      CHECK(std::set(kinds.begin(), kinds.end()) == shown);
      const std::string_view category = kObjectGoals.at(episode.goal);
      CHECK(nav.sample_in_sight(6, i, category).goal == episode.goal);
    }
  }
}

TEST_CASE("starts are 3 m by the shortest path from every instance's nearest reachable point") {
  const ObjectNav& nav = everywhere().at("apartment_v1");
  const scene::GridFrame& frame = nav.tables().passable().frame;
  for (std::uint32_t i = 0; i < 60; ++i) {
    CAPTURE(i);
    const ObjectNavEpisode episode = nav.sample(9, i);
    const scene::GeodesicField from_start = nav.tables().geodesic_field(episode.start.position());
    const Scene& scene = nav.tables().scene();
    for (std::size_t k = 0; k < scene.objects.size(); ++k) {
      if (scene.objects[k].category != kObjectGoals[episode.goal]) continue;
      const std::vector<Solid> solids = solids_of(scene, k);
      double nearest = 1e9;
      Vec2 point;
      for (std::size_t cell = 0; cell < frame.size(); ++cell) {
        if (!nav.tables().reachable().cells[cell]) continue;
        const Vec2 middle = frame.center(frame.cell(cell));
        const double d = footprint_distance(solids, middle);
        if (d < nearest) {
          nearest = d;
          point = middle;
        }
      }
      CHECK(from_start.length_from(point) >= kGoalDistance - 0.08);  // two ways to solve for one length
    }
  }
}

TEST_CASE("every episode has a way to drive") {
  for (const auto& [name, nav] : everywhere()) {
    CAPTURE(name);
    const scene::CellSet& passable = nav.tables().passable();
    const Scene& scene = nav.tables().scene();
    for (std::uint32_t i = 0; i < cases(400); ++i) {
      CAPTURE(i);
      const ObjectNavEpisode episode = nav.sample(2, i);
      CHECK(episode.geodesic >= kShortestSearch);
      if (i >= cases(10)) continue;
      // no place within reach is nearer, whatever the camera shows there
      const scene::GeodesicField from_start = nav.tables().geodesic_field(episode.start.position(), 3.0);
      for (std::size_t k = 0; k < scene.objects.size(); ++k) {
        if (scene.objects[k].category != kObjectGoals[episode.goal]) continue;
        const std::vector<Solid> solids = solids_of(scene, k);
        double nearest = 1e9;
        for (std::size_t cell = 0; cell < passable.frame.size(); ++cell) {
          const Vec2 middle = passable.frame.center(passable.frame.cell(cell));
          if (!passable.cells[cell] || footprint_distance(solids, middle) > kGoalReach) continue;
          nearest = std::min(nearest, from_start.length_from(middle));
        }
        CHECK(nearest >= kShortestSearch);
      }
    }
  }
}

TEST_CASE("an episode is a function of seed and index alone, and every kind is as likely") {
  const ObjectNav& nav = everywhere().at("office_v2");
  const ObjectNav again(tables_of(Scene::load("office_v2")), robot());
  std::map<std::size_t, int> count;
  std::set<std::pair<double, double>> starts;
  constexpr int kEpisodes = 2000;
  for (std::uint32_t i = 0; i < kEpisodes; ++i) {
    const ObjectNavEpisode episode = nav.sample(3, i);
    if (i < 50) CHECK(again.sample(3, i) == episode);
    ++count[episode.goal];
    starts.emplace(episode.start.x, episode.start.y);
  }
  CHECK_FALSE(nav.sample(3, 1) == nav.sample(4, 1));
  CHECK(starts.size() > kEpisodes / 2);
  CHECK(count.size() == nav.goals().size());
  const double expected = static_cast<double>(kEpisodes) / static_cast<double>(nav.goals().size());
  for (const auto& [goal, n] : count) CHECK(std::abs(n - expected) < 5.0 * exact::sqrt(expected));
}

TEST_CASE("where the path ends the robot can turn so that STOP is right") {
  for (const auto& [name, nav] : everywhere()) {
    CAPTURE(name);
    for (std::uint32_t i = 0; i < 5; ++i) {
      CAPTURE(i);
      const ObjectNavEpisode episode = nav.sample(1, i);
      // downhill, as far as it goes
      Vec2 place = episode.start.position();
      double left = episode.geodesic;
      for (int turn = 0; turn < 32 && left > 0.02;) {
        const Vec2 next = place + rotate({0.05, 0.0}, wrap_angle(turn * exact::kPi / 16.0));
        const double there = nav.distance(episode.goal, next);
        const bool better = there < left - 0.01;
        turn = better ? 0 : turn + 1;
        if (better) {
          place = next;
          left = there;
        }
      }
      REQUIRE(left < 0.12);
      bool any = false;
      for (int k = 0; k < 36 && !any; ++k) {
        const Pose2D pose{place.x, place.y, wrap_angle(k * exact::kPi / 18.0)};
        const std::vector<std::int16_t> ids = ids_near(nav.tables().scene(), pose);
        any = nav.is_success(episode.goal, pose, [&] { return std::span(ids); });
      }
      CHECK(any);
    }
  }
}

// A room with a chair 0.9 m ahead of the start, and whatever else is wanted.
Scene room_with(const std::string& objects) {
  return Scene::parse(
      "name: room\ndescription: a room\nstarts: [[2, 2, 0]]\n"
      "walls: [{a: [0, 0], b: [12, 0]}, {a: [12, 0], b: [12, 6]}, {a: [12, 6], b: [0, 6]}, {a: [0, 6], b: [0, 0]}]\n"
      "rooms: [{name: hall, min: [0, 0], max: [12, 6], floor: wood, anchor: [2, 2]}]\n"
      "objects:\n  - {category: chair, shape: tub, pose: [3.2, 2, 3.1416]}\n" +
          objects,
      "room.yaml");
}

TEST_CASE("success takes nearness, pixels and a share of the silhouette") {
  const ObjectNav nav(tables_of(room_with("")), robot());
  const std::size_t chair = object_goal("chair");
  const Pose2D there{0.0, 0.0, 0.0};  // 0.87 m from the chair's front, at (1.2, 0) in the scene's frame
  const std::size_t count = 640UL * 480UL;
  int looks = 0;
  const auto frame_with = [&](int pixels) {
    return [&looks, pixels, ids = std::vector<std::int16_t>(count, 2)]() mutable {
      ++looks;
      std::fill_n(ids.begin(), pixels, kFirstObjectId);
      return std::span<const std::int16_t>(ids);
    };
  };
  const int silhouette =
      visible_pixels(robot().camera->intrinsics(), eye_at(there), solids_of(nav.tables().scene(), 0), {});
  const int tenth = (silhouette + 9) / 10;
  REQUIRE(tenth > kGoalPixels);
  CHECK(nav.found(chair, there, frame_with(tenth)) == std::vector<std::size_t>{0});
  CHECK_FALSE(nav.is_success(chair, there, frame_with(tenth - 1)));
  CHECK(looks == 2);
  CHECK_FALSE(nav.is_success(chair, {-0.2, 0.0, 0.0}, frame_with(100000)));  // 1.07 m away
  CHECK_FALSE(nav.is_success(object_goal("plant"), there, frame_with(100000)));
  CHECK(looks == 2);  // nobody looks when nothing of the kind is near

  // turned away, so that a tenth of what is left of the silhouette would be few pixels: then 200 are asked for
  const std::vector<Solid> solids = solids_of(nav.tables().scene(), 0);
  Pose2D aside = there;
  while (visible_pixels(robot().camera->intrinsics(), eye_at(aside), solids, {}) >= 10 * kGoalPixels) {
    aside.theta += 0.005;
  }
  CHECK(nav.is_success(chair, aside, frame_with(kGoalPixels)));
  CHECK_FALSE(nav.is_success(chair, aside, frame_with(kGoalPixels - 1)));
}

TEST_CASE("STOP ends an episode, right or wrong; the picture is drawn then alone") {
  const ObjectNav nav(tables_of(room_with("")), robot());
  const ObjectNavEpisode episode = nav.sample(0, 0);
  int looks = 0;
  const auto ids_at = [&](const Pose2D& pose) {
    return [&looks, ids = slow_ids(nav.tables().scene(), pose)] {
      ++looks;
      return std::span<const std::int16_t>(ids);
    };
  };
  StopTaskState state = nav.begin(episode);
  const std::array<float, 3> drive = {1.0F, 0.0F, 0.0F};
  const std::array<float, 3> stand = {0.0F, 0.0F, 0.0F};
  const Pose2D there{0.0, 0.0, 0.0};
  const auto look = ids_at(there);
  StopTaskStep step = nav.step(episode, state, there, drive, 100ms, look);
  CHECK(step.reward == doctest::Approx(episode.geodesic - nav.distance(episode.goal, there.position())));
  for (int i = 0; i < 5; ++i) {
    CHECK_FALSE(step.terminated);
    CHECK(looks == 0);
    step = nav.step(episode, state, there, stand, 100ms, look);
  }
  CHECK(step.terminated);
  CHECK(step.success);
  CHECK(step.reward == 10.0);
  CHECK(looks == 1);
}

TEST_CASE("what cannot be a goal is refused, with the nearest right name") {
  const auto message = [](auto&& act) -> std::string {
    try {
      act();
    } catch (const ThreeweError& error) {
      return error.what();
    }
    return {};
  };
  CHECK(message([] { object_goal("chiar"); }) == "unknown object goal 'chiar'; did you mean 'chair'?");
  const ObjectNav nav(tables_of(room_with("")), robot());
  CHECK(message([&] { nav.sample(0, 0, "bed"); }) == "in scene 'room' no bed can be looked for; goals there: chair");
  CHECK(message([&] { nav.sample(0, 0, "couhc"); }) == "unknown object goal 'couhc'; did you mean 'couch'?");
  CHECK(message([] {
          Scene empty = room_with("");
          empty.objects.clear();
          ObjectNav(tables_of(std::move(empty)), robot());
        }).starts_with("in scene 'room' nothing can be looked for; wanted: one of chair, desk,"));
  RobotProfile blind = robot();
  blind.camera.reset();
  CHECK(message([&] { ObjectNav(tables_of(room_with("")), blind); }) ==
        "ObjectNav needs a camera, and '3we_standard_v2' has none");
  CHECK_THROWS_AS(ObjectNav(tables_of(room_with("")), blind), HardwareError);
}

TEST_CASE("a goal is coded as one of ten") {
  for (std::size_t i = 0; i < kObjectGoals.size(); ++i) {
    const auto hot = one_hot(i);
    for (std::size_t k = 0; k < hot.size(); ++k) CHECK(hot[k] == (k == i ? 1.0F : 0.0F));
    CHECK(object_goal(kObjectGoals[i]) == i);
  }
}

}  // namespace
}  // namespace threewe::task
