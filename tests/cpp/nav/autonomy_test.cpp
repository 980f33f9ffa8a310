// A whole mind, localiser and navigator, that drives a robot with bad sensors through a small world.
#include "nav/autonomy.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "slam/tiny_world.hpp"

namespace threewe::nav {
namespace {

using testing::add_box;
using testing::TinyErrors;
using testing::TinyWall;
using testing::TinyWorld;

// The lidar of the tiny world sits on the base.
RobotProfile profile_named(const std::string& name) {
  RobotProfile profile = load_profile(name);
  profile.lidar->base_from_lidar = {};
  return profile;
}

TinyErrors draw_errors(std::uint64_t seed) {
  const RngKey key{seed, 0, 0, 0, Stream::episode};
  return {uniform(key, 0, 0, 0.985, 1.015),
          uniform(key, 1, 0, 0.85, 0.98),
          uniform(key, 2, 0, -0.0087, 0.0087),
          0.0017,
          0.01,
          uniform(key, 3, 0, -0.03, 0.03)};
}

// Three rooms of 10 x 6 m, doors between them, a box and the four legs of a table.
std::vector<TinyWall> three_rooms() {
  std::vector<TinyWall> walls;
  add_box(walls, {-1, -1}, {9, 5});
  walls.push_back({{3, -1}, {3, 2}});
  walls.push_back({{3, 3}, {3, 5}});
  walls.push_back({{6, 0}, {6, 5}});
  add_box(walls, {1, 2.5}, {1.6, 3.0});
  for (const Vec2 leg : {Vec2{7.2, 2.0}, {7.9, 2.0}, {7.2, 2.7}, {7.9, 2.7}}) {
    add_box(walls, leg, leg + Vec2{0.04, 0.04});
  }
  return walls;
}

double width_of(const RobotProfile& profile) {
  double width = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) width = std::max(width, 2.0 * std::fabs(c.y));
  return width;
}

// A mind and its world, ticking together.
struct Drive {
  RobotProfile profile;
  TinyWorld world;
  std::unique_ptr<slam::Localizer> localizer;
  std::unique_ptr<Navigator> navigator;
  Velocity command;
  double worst_error = 0.0;
  double least_clearance = 1.0;
  bool held = false;  // by somebody: it stays where it is

  Drive(const std::string& name, std::vector<TinyWall> walls, std::uint64_t seed)
      : profile(profile_named(name)),
        world(std::move(walls), {}, draw_errors(seed), seed),
        localizer(slam::make_localizer(profile)),
        navigator(make_navigator(profile)) {}

  Observation see() {
    for (const Sample& sample : world.tick(held ? Velocity{} : command)) localizer->add(sample);
    return {world.now(),
            localizer->estimate(world.now()),
            localizer->map(),
            localizer->map_version(),
            localizer->obstacles(),
            localizer->map_changes(),
            {},
            {},
            command};
  }

  // `meddle` may change what is there, and what is seen of it, before each tick.
  Decision run(const Goal& goal, Duration limit, const std::function<void(Observation&)>& meddle = {}) {
    const Time end = world.now() + limit;
    Observation seen = see();
    navigator->start(goal, seen);
    for (int tick = 0; world.now() < end; ++tick) {
      const Decision decision = navigator->step(seen);
      command = decision.velocity;
      worst_error = std::max(worst_error, distance(seen.pose.map_from_base().position(), world.pose().position()));
      if (tick % 10 == 0) least_clearance = std::min(least_clearance, world.clearance(profile.body.footprint));
      if (decision.reason != Reason::running) return decision;
      const Observation next = see();
      seen.now = next.now;
      seen.pose = next.pose;
      seen.map_version = next.map_version;
      seen.obstacles = next.obstacles;
      seen.commanded = next.commanded;
      if (meddle) meddle(seen);
    }
    return {{}, Reason::timeout};
  }
};

TEST_CASE("both kinematics drive to places through doors, touching nothing, and know where they are") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      CAPTURE(name);
      CAPTURE(seed);
      Drive drive(name, three_rooms(), seed);
      for (const Vec2 goal : {Vec2{8, 3.5}, Vec2{0, 4}}) {
        CHECK(to_string(drive.run(MoveTo{goal}, 120s).reason) == "reached");
        CHECK(distance(drive.world.pose().position(), goal) < 0.2);
      }
      CHECK(drive.least_clearance > 0.01);
      CHECK(drive.worst_error < 0.1);
    }
  }
}

TEST_CASE("a heading is taken where one is asked for") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive drive(name, three_rooms(), 5);
    CHECK(drive.run(MoveTo{{1.0, 1.0}, 2.5}, 60s).reason == Reason::reached);
    CHECK(std::fabs(wrap_angle(drive.world.pose().theta - 2.5)) < 0.1);
  }
}

TEST_CASE("a robot in the only doorway is no proof that there is no path, and the result names it") {
  std::vector<TinyWall> walls;
  add_box(walls, {-1, -1}, {6, 2});
  walls.push_back({{3, -1}, {3, 0.2}});
  walls.push_back({{3, 0.8}, {3, 2}});
  add_box(walls, {2.9, 0.35}, {3.1, 0.65});
  const map::OccupancyGrid empty;
  const std::vector<Peer> peers = {
      {.name = "robot 1", .map_from_base = {3.0, 0.5, 0.0}, .radius = 0.15, .map = &empty}};
  for (const bool known : {true, false}) {
    CAPTURE(known);
    Drive drive("3we_standard_v2", walls, 4);
    const Decision end = drive.run(MoveTo{{5, 0.5}}, 300s, [&](Observation& seen) {
      if (known) seen.peers = peers;
    });
    CHECK(to_string(end.reason) == (known ? "blocked" : "no_path"));
    CHECK((end.detail.find("robot 1 at (3.00, 0.50)") != std::string::npos) == known);
  }
}

TEST_CASE("a goal outside the walls has no path, and one in a closed cupboard neither") {
  Drive drive("3we_standard_v2", three_rooms(), 2);
  CHECK(drive.run(MoveTo{{30, 40}}, 200s).reason == Reason::no_path);

  std::vector<TinyWall> walls = three_rooms();
  add_box(walls, {1.5, -0.5}, {2.7, 0.7});
  Drive other("3we_standard_v2", walls, 2);
  CHECK(other.run(MoveTo{{2.1, 0.1}}, 200s).reason == Reason::no_path);
}

TEST_CASE("a goal in a thin wall is reached within its tolerance") {
  Drive drive("3we_standard_v2", three_rooms(), 3);
  CHECK(drive.run(MoveTo{{3.0, 0.5}}, 60s).reason == Reason::reached);
  CHECK(distance(drive.world.pose().position(), {3.0, 0.5}) < 0.25);
}

TEST_CASE("turning on the spot, more than a full turn too, and driving straight both ways") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive drive(name, three_rooms(), 4);
    CHECK(drive.run(Rotate{-7.0}, 60s).reason == Reason::reached);
    CHECK(std::fabs(wrap_angle(drive.world.pose().theta + 7.0)) < 0.06);
    CHECK(drive.run(Rotate{7.0}, 60s).reason == Reason::reached);
    CHECK(drive.run(MoveForward{1.0}, 60s).reason == Reason::reached);
    CHECK(drive.world.pose().x == doctest::Approx(1.0).epsilon(0.06));
    CHECK(drive.run(MoveForward{-0.8}, 60s).reason == Reason::reached);
    CHECK(std::fabs(drive.world.pose().x - 0.2) < 0.08);
  }
}

TEST_CASE("driving straight at a wall ends blocked, before it") {
  Drive drive("3we_standard_v2", three_rooms(), 6);
  CHECK(drive.run(MoveForward{5.0}, 60s).reason == Reason::blocked);
  CHECK(drive.least_clearance > 0.01);
  CHECK(drive.world.pose().x > 2.5);
}

TEST_CASE("what is as near as something in the way lets it be counts within the tolerance, and not beyond") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive modest(name, three_rooms(), 13);  // the wall is 3 m ahead
    CHECK(modest.run(MoveForward{.distance = 2.97, .tolerance = 0.35}, 60s).reason == Reason::reached);
    Drive strict(name, three_rooms(), 13);
    CHECK(strict.run(MoveForward{.distance = 2.97, .tolerance = 0.05}, 60s).reason == Reason::blocked);
  }
  // a goal is approached more closely where less is tolerated
  Drive drive("3we_standard_v2", three_rooms(), 14);
  CHECK(drive.run(MoveTo{.goal = {1.0, 1.0}, .tolerance = 0.01}, 60s).reason == Reason::reached);
  CHECK(distance(drive.navigator->progress().pose.position(), {1.0, 1.0}) <= 0.01);
  CHECK(drive.run(Rotate{.angle = 1.0, .angle_tolerance = 0.004}, 60s).reason == Reason::reached);
}

TEST_CASE("the time that is left is told about right, and becomes none") {
  for (const Goal& goal : {Goal{MoveTo{{8, 3.5}}}, Goal{MoveTo{{1.0, 1.0}, 2.5}}, Goal{Rotate{3.0}},
                           Goal{MoveForward{1.5}}, Goal{FollowPath{{{2, 0}, {2, 2}}}}}) {
    CAPTURE(goal.index());
    Drive drive("3we_standard_v2", three_rooms(), 15);
    std::vector<double> left;
    const Time began = drive.world.now();
    CHECK(drive.run(goal, 90s, [&](Observation&) { left.push_back(drive.navigator->progress().time_left); }).reason ==
          Reason::reached);
    const double took = to_seconds(drive.world.now() - began);
    REQUIRE(left.size() > 50);
    CHECK(left[25] > 0.4 * took);
    CHECK(left[25] < 1.6 * took);
    CHECK(left.back() < 0.1 * took + 0.5);
  }
}

TEST_CASE("a polyline is followed along its corners, round what stands in its way") {
  Drive drive("3we_standard_v2", three_rooms(), 7);
  double nearest = 1e9;
  CHECK(drive.run(FollowPath{{{2, 0}, {2, 4}, {0, 4}}}, 90s).reason == Reason::reached);
  nearest = distance(drive.world.pose().position(), {0, 4});
  CHECK(nearest < 0.15);
  // the box lies on this line
  CHECK(drive.run(FollowPath{{{1.3, 4}, {1.3, 1.5}}}, 90s).reason == Reason::reached);
  CHECK(drive.least_clearance > 0.01);
}

TEST_CASE("who has seen nothing has not explored it") {
  Drive drive("3we_standard_v2", three_rooms(), 8);
  const auto see = [&] {
    for (Sample& sample : drive.world.tick({})) {
      if (auto* scan = std::get_if<LaserScan>(&sample.data)) std::ranges::fill(scan->ranges, 0.0F);
      drive.localizer->add(sample);
    }
    const Time now = drive.world.now();
    const slam::Localizer& localizer = *drive.localizer;
    return Observation{now, localizer.estimate(now), localizer.map(), localizer.map_version(), localizer.obstacles()};
  };
  drive.navigator->start(Explore{}, see());
  Decision decision;
  for (int tick = 0; tick < 2000 && decision.reason == Reason::running; ++tick) decision = drive.navigator->step(see());
  CHECK(decision.reason == Reason::blocked);
  CHECK(decision.detail == "nothing around the robot has been seen to be free");
}

TEST_CASE("exploring ends when all is seen") {
  Drive drive("3we_standard_v2", three_rooms(), 8);
  CHECK(drive.run(Explore{}, 200s).reason == Reason::reached);
  const map::OccupancyGrid& grid = drive.localizer->map();
  int known = 0;
  int all = 0;
  for (int row = 0; row < 116; ++row) {
    for (int column = 0; column < 196; ++column) {
      const double x = -0.9 + 0.05 * column;
      const double y = -0.9 + 0.05 * row;
      if (x > 0.9 && x < 1.7 && y > 2.4 && y < 3.1) continue;  // the box
      ++all;
      known += grid.at(grid.cell({x, y})) >= 0 ? 1 : 0;
    }
  }
  CHECK(known > 0.99 * all);
  CHECK(drive.least_clearance > 0.01);
}

TEST_CASE("what lies behind a doorway hardly wider than the robot is explored, when nothing else is left") {
  const double width = width_of(profile_named("3we_standard_v2"));
  for (const double gap : {width + 0.05, width - 0.01}) {
    CAPTURE(gap);
    std::vector<TinyWall> walls;
    add_box(walls, {-1, -1}, {7, 3});
    add_box(walls, {2, -1}, {2.1, 1.0 - 0.5 * gap});
    add_box(walls, {2, 1.0 + 0.5 * gap}, {2.1, 3});
    walls.push_back({{4, -1}, {4, 2}});
    Drive drive("3we_standard_v2", walls, 23);
    CHECK(drive.run(Explore{}, 300s).reason == Reason::reached);
    const map::OccupancyGrid& grid = drive.localizer->map();
    CHECK((grid.at(grid.cell({6.5, -0.5})) >= 0) == (gap > width));
    CHECK(drive.least_clearance > 0.0);
  }
}

TEST_CASE("something that appears in the way is driven around") {
  Drive drive("3we_standard_v2", three_rooms(), 9);
  CHECK(drive.run(MoveTo{{0.3, 0.0}}, 30s).reason == Reason::reached);
  add_box(drive.world.walls(), {1.0, -0.3}, {1.3, 0.4});
  CHECK(drive.run(MoveTo{{2.4, 0.0}}, 60s).reason == Reason::reached);
  CHECK(drive.least_clearance > 0.01);
}

TEST_CASE("a door that closes for good leaves no path") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive drive(name, three_rooms(), 11);
    bool closed = false;
    const Decision end = drive.run(MoveTo{{5.0, 2.5}}, 200s, [&](Observation&) {
      if (closed || distance(drive.world.pose().position(), {3.0, 2.5}) > 1.2) return;
      drive.world.walls().push_back({{3, 2}, {3, 3}});
      closed = true;
    });
    CHECK(closed);
    CHECK(to_string(end.reason) == "no_path");
    CHECK(drive.least_clearance > 0.01);
  }
}

TEST_CASE("a doorway hardly wider than the robot is driven through; one that is narrower is no path") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    const double spare = name == std::string("3we_standard_v2") ? 0.05 : 0.08;
    CAPTURE(name);
    const double width = width_of(profile_named(name));
    for (const double gap : {width + spare, width - 0.01}) {
      CAPTURE(gap);
      std::vector<TinyWall> walls;
      add_box(walls, {-1, -1}, {4, 2});
      add_box(walls, {1.5, -1}, {1.6, 0.3 - 0.5 * gap});
      add_box(walls, {1.5, 0.3 + 0.5 * gap}, {1.6, 2});
      Drive drive(name, walls, 23);
      const Decision end = drive.run(MoveTo{{3.0, 0.8}}, 200s);
      CHECK(to_string(end.reason) == (gap > width ? "reached" : "no_path"));
      CHECK(drive.least_clearance > 0.0);
    }
  }
}

TEST_CASE("who is held back recovers step by step, tells so, and gives up with the reason") {
  using State = RecoveryState;
  Drive drive("3we_standard_v2", three_rooms(), 17);
  std::vector<State> states = {State::driving};
  const Decision end = drive.run(MoveTo{{2.4, 0.0}}, 300s, [&](Observation&) {
    const Progress progress = drive.navigator->progress();
    if (progress.recovery != states.back()) states.push_back(progress.recovery);
    drive.held = progress.distance_driven > 0.5;
  });
  CHECK(end.reason == Reason::blocked);
  CHECK(end.detail == "there is no room to move");
  CHECK(drive.navigator->progress().recovery == State::given_up);
  std::vector<State> expected;
  for (int attempt = 1; attempt <= 8; ++attempt) {
    expected.insert(expected.end(), {State::driving, State::clearing, State::backing_off});
    if (attempt >= 3) expected.push_back(State::looking);
    expected.push_back(State::replanning);
  }
  expected.push_back(State::driving);
  CHECK(states == expected);
}

TEST_CASE("a lost robot turns round to look, goes on where it finds itself, and gives up where it does not") {
  Drive drive("3we_standard_v2", three_rooms(), 12);
  double turned = 0.0;
  double before = 0.0;
  Vec2 lost_at;
  const auto lose = [&](Time from, Time to) {
    return [&drive, &turned, &before, &lost_at, from, to](Observation& seen) {
      if (seen.now < from) lost_at = drive.world.pose().position();
      seen.pose.state =
          seen.now >= from && seen.now < to ? slam::LocalizationState::lost : slam::LocalizationState::tracking;
      if (seen.pose.lost()) turned += wrap_angle(drive.world.pose().theta - before);
      before = drive.world.pose().theta;
    };
  };
  const Time now = drive.world.now();
  CHECK(drive.run(MoveTo{{2.0, 0.0}}, 60s, lose(now + 2s, now + 5s)).reason == Reason::reached);
  CHECK(turned > 1.5);
  CHECK(distance(drive.world.pose().position(), {2.0, 0.0}) < 0.1);

  turned = 0.0;
  const Time later = drive.world.now();
  const Decision end = drive.run(MoveTo{{0.0, 0.0}}, 60s, lose(later + 2s, later + 100s));
  CHECK(end.reason == Reason::lost);
  CHECK(turned == doctest::Approx(2.0 * exact::kPi).epsilon(0.1));
  CHECK(distance(drive.world.pose().position(), lost_at) < 0.2);
}

TEST_CASE("a zone to keep out of is driven round, and nothing that only it leads to has a path") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive drive(name, three_rooms(), 16);
    const map::Zone middle{{{0.7, -0.4}, {1.3, -0.4}, {1.3, 0.5}, {0.7, 0.5}}};
    drive.navigator->set_zones({middle});
    double nearest = 1.0;
    CHECK(drive
              .run(MoveTo{{2.2, 0.0}}, 60s,
                   [&](Observation&) {
                     for (const Vec2 corner : drive.profile.body.footprint.corners()) {
                       nearest = std::min(nearest, middle.distance_to(drive.world.pose() * corner));
                     }
                   })
              .reason == Reason::reached);
    CHECK(nearest > 0.0);

    const map::Zone door{{{2.8, 1.9}, {3.2, 1.9}, {3.2, 3.1}, {2.8, 3.1}}};
    drive.navigator->set_zones({door});
    CHECK(drive.run(MoveTo{{5.0, 2.5}}, 200s).reason == Reason::no_path);
    drive.navigator->set_zones({});
    CHECK(drive.run(MoveTo{{5.0, 2.5}}, 90s).reason == Reason::reached);
  }
}

TEST_CASE("in a zone with a speed limit no robot is faster") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Drive drive(name, three_rooms(), 17);
    const map::Zone band{{{0.8, -1.0}, {1.4, -1.0}, {1.4, 5.0}, {0.8, 5.0}}, 0.1};
    drive.navigator->set_zones({band});
    double fastest_inside = 0.0;
    double fastest = 0.0;
    Vec2 before;
    CHECK(drive
              .run(MoveTo{{2.4, 0.0}}, 90s,
                   [&](Observation&) {
                     const Pose2D pose = drive.world.pose();
                     const double speed = distance(pose.position(), before) / to_seconds(kControlPeriod);
                     before = pose.position();
                     fastest = std::max(fastest, speed);
                     for (const Vec2 corner : drive.profile.body.footprint.corners()) {
                       if (band.contains(pose * corner)) fastest_inside = std::max(fastest_inside, speed);
                     }
                   })
              .reason == Reason::reached);
    CHECK(fastest_inside > 0.05);
    CHECK(fastest_inside < 0.115);
    CHECK(fastest > 0.2);
  }
}

TEST_CASE("who is told where the map has changed decides as who looks at all of it, to the bit") {
  for (const Goal& goal : {Goal{MoveTo{{8, 3.5}}}, Goal{Explore{}}}) {
    CAPTURE(goal.index());
    Drive drive("3we_standard_v2", three_rooms(), 18);
    const std::unique_ptr<Navigator> other = drive.navigator->clone();
    const auto untold = [](Observation seen) {
      seen.map_changes = nullptr;
      return seen;
    };
    drive.navigator->start(goal, drive.see());
    other->start(goal, untold(drive.see()));
    for (int tick = 0; tick < 1500; ++tick) {
      const Observation seen = drive.see();
      REQUIRE(seen.map_changes != nullptr);
      drive.command = drive.navigator->step(seen).velocity;
      REQUIRE(drive.command == other->step(untold(seen)).velocity);
    }
  }
}

TEST_CASE("a copy of a mind decides as the original does, to the bit") {
  Drive drive("3we_standard_v2", three_rooms(), 10);
  Observation seen = drive.see();
  drive.navigator->start(MoveTo{{8, 3.5}}, seen);
  std::unique_ptr<slam::Localizer> localizer;
  std::unique_ptr<Navigator> navigator;
  for (int tick = 0; tick < 600; ++tick) {
    if (tick == 250) localizer = drive.localizer->clone(), navigator = drive.navigator->clone();
    const std::vector<Sample> samples = drive.world.tick(drive.command);
    for (const Sample& s : samples) drive.localizer->add(s);
    const Time now = drive.world.now();
    const Velocity commanded = drive.command;
    const auto seen_by = [&](const slam::Localizer& by) {
      return Observation{.now = now,
                         .pose = by.estimate(now),
                         .map = by.map(),
                         .map_version = by.map_version(),
                         .obstacles = by.obstacles(),
                         .commanded = commanded};
    };
    const Decision a = drive.navigator->step(seen_by(*drive.localizer));
    drive.command = a.velocity;
    if (!localizer) continue;
    for (const Sample& s : samples) localizer->add(s);
    const Decision b = navigator->step(seen_by(*localizer));
    REQUIRE(a.velocity == b.velocity);
    REQUIRE(localizer->map() == drive.localizer->map());
  }
}

}  // namespace
}  // namespace threewe::nav
