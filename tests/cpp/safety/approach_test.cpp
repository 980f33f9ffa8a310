#include "safety/approach.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

// A disc that moves evenly.
struct Mover {
  Vec2 from;
  Vec2 velocity;
  double radius = 0.15;
  Vec2 at(double t) const { return from + t * velocity; }
};

// A robot whose lidar turns and measures with noise while it drives in a room with boxes and movers.
struct World {
  World(const std::string& robot, std::uint64_t seed, std::vector<Mover> who, Velocity driven)
      : draw(seed),
        profile(load_profile(robot)),
        gate(make_gate_model(profile)),
        sight_model(make_sight_model(profile, gate)),
        model(make_approach_model(profile, gate)),
        movers(std::move(who)),
        velocity(driven) {}

  double normal() { return std::sqrt(-2.0 * std::log(1.0 - draw(0.0, 1.0))) * std::cos(draw(0.0, 2.0 * exact::kPi)); }
  double range(const Pose2D& lidar, double angle, double t) const {
    const Vec2 d = rotate({1.0, 0.0}, angle);
    const auto to_wall = [](double from, double direction) {
      return direction > 0.0 ? (1.6 - from) / direction : direction < 0.0 ? (-1.6 - from) / direction : 1e9;
    };
    double nearest = std::min(to_wall(lidar.x, d.x), to_wall(lidar.y, d.y));
    std::vector<std::pair<Vec2, double>> discs = {{{0.7, 0.5}, 0.1}, {{-0.5, 0.6}, 0.04}, {{0.1, -0.7}, 0.2}};
    for (const Mover& mover : movers) discs.emplace_back(mover.at(t), mover.radius);
    for (const auto& [at, radius] : discs) {
      const Vec2 c = at - lidar.position();
      const double along = dot(c, d);
      const double off = cross(d, c);
      if (along > 0.0 && std::fabs(off) < radius)
        nearest = std::min(nearest, along - std::sqrt(radius * radius - off * off));
    }
    return nearest;
  }

  // One turn, clockwise, a beam after the other.
  void turn() {
    const LidarSpec& lidar = *profile.lidar;
    const double seconds = to_seconds(lidar.turn);
    const Pose2D begin = base;
    const Pose2D end = integrate(base, velocity, seconds);
    std::vector<float> ranges;
    for (int i = 0; i < lidar.beams; ++i) {
      const double share = 1.0 - (i + 0.5) / lidar.beams;
      const Pose2D at = integrate(base, velocity, share * seconds) * lidar.base_from_lidar;
      const double angle = at.theta + i * 2.0 * exact::kPi / lidar.beams - exact::kPi;
      const double r = range(at, angle, to_seconds(now) + share * seconds) + lidar.sigma * normal();
      ranges.push_back(draw(0.0, 1.0) < lidar.dropout || r < lidar.range_min ? 0.0F : static_cast<float>(r));
    }
    now += lidar.turn;
    base = end;
    sight.add(sight_model, {now, end * lidar.base_from_lidar, begin * lidar.base_from_lidar}, ranges, base);
    approach.update(model, sight, velocity);
  }

  Draw draw;
  RobotProfile profile;
  GateModel gate;
  SightModel sight_model;
  ApproachModel model;
  std::vector<Mover> movers;
  Velocity velocity;
  Pose2D base;
  Time now{};
  Sight sight;
  Approach approach;
};

const std::vector<std::string> kRobots = {"3we_standard_v2", "turtlebot_like"};

}  // namespace

TEST_CASE("nothing approaches where nothing moves, however the robot drives") {
  for (const std::string& robot : kRobots) {
    int hits = 0;
    for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
      Draw draw(seed);
      World world(robot, seed, {}, {draw(-0.3, 0.3), 0.0, draw(-1.0, 1.0)});
      for (int i = 0; i < 60; ++i) {
        if (i % 5 == 4) world.velocity = {-world.velocity.vx, 0.0, draw(-1.0, 1.0)};  // stays in the middle
        world.turn();
        hits += static_cast<int>(world.approach.approaching().size());
      }
    }
    CAPTURE(robot);
    MESSAGE(robot << ": " << hits << " hits");
    CHECK(hits <= 3);
  }
}

TEST_CASE("what comes straight at the robot is predicted before it is there, about as fast as it comes") {
  for (const std::string& robot : kRobots) {
    int noticed = 0;
    double fastest = 0.0;
    constexpr std::uint64_t kCases = 60;
    for (std::uint64_t seed = 0; seed < kCases; ++seed) {
      Draw draw(seed);
      const double bearing = draw(-exact::kPi, exact::kPi);
      const double speed = draw(0.35, 0.55);
      const Vec2 from = rotate({1.3, 0.0}, bearing);
      World world(robot, seed, {{from, (-speed / 1.3) * from}}, {});
      bool in_time = false;
      while (norm(world.movers[0].at(to_seconds(world.now) + 0.1)) > 0.45) {
        world.turn();
        for (const Approaching& it : world.approach.approaching()) {
          in_time = true;
          fastest = std::max(fastest, it.speed);
          CHECK(distance(it.position, world.movers[0].at(to_seconds(world.now))) < 0.3);
        }
      }
      noticed += in_time ? 1 : 0;
    }
    CAPTURE(robot);
    MESSAGE(robot << ": noticed " << noticed);
    CHECK(noticed >= static_cast<int>(kCases) * 9 / 10);
    CHECK(fastest <= 0.6);
  }
}

TEST_CASE("a robot that meets something stands sooner than one that takes it for fixed") {
  const auto gap_when_it_stands = [](bool predicts) {
    World world("3we_standard_v2", 1, {{{1.3, 0.0}, {-0.4, 0.0}}}, {});
    GateState state;
    state.scan_seen = true;
    bool drove = false;
    while (world.now < Time{2s}) {
      world.turn();
      for (int i = 0; i < 5; ++i) {
        const Time now = world.now + i * kControlPeriod;
        state.last_scan = now;
        std::vector<Vec2> expected;
        if (predicts) world.approach.append_predicted(world.model, state.last(), world.base.position(), now, expected);
        const double surface = world.movers[0].at(to_seconds(world.now)).x - world.movers[0].radius;
        const std::vector<Vec2> hits = {{surface, 0.0}, {surface + 0.01, 0.05}, {surface + 0.01, -0.05}};
        const Velocity v = gate(world.gate, state, {{0.3, 0.0, 0.0}}, {hits, expected}, now, world.base).command;
        if (drove && v == Velocity{}) return surface - world.base.x - 0.125;
        drove = drove || v.vx > 0.1;
        world.velocity = v;
      }
    }
    return -1.0;
  };
  const double plain = gap_when_it_stands(false);
  const double predicted = gap_when_it_stands(true);
  MESSAGE("stands " << predicted << " m before what comes, and " << plain << " m without prediction");
  CHECK(plain > 0.0);
  CHECK(predicted > plain + 0.03);
}

TEST_CASE("hits beyond what there is room for: the nearest stay") {
  World world("3we_standard_v2", 2, {{{0.95, 0.0}, {-0.5, 0.0}, 0.45}}, {});
  for (int i = 0; i < 6; ++i) world.turn();
  const auto approaching = world.approach.approaching();
  REQUIRE(approaching.size() > 10);
  CHECK(approaching.size() <= Approach::kMost);
}

TEST_CASE("a copy goes on as the original does") {
  World world("3we_standard_v2", 7, {{{1.2, 0.1}, {-0.4, 0.0}}}, {0.1, 0.0, 0.2});
  for (int i = 0; i < 4; ++i) world.turn();
  World copy = world;
  for (int i = 0; i < 8; ++i) {
    world.turn();
    copy.turn();
    CHECK(std::ranges::equal(world.approach.approaching(), copy.approach.approaching()));
  }
}
