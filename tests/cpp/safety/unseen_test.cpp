#include "safety/unseen.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "hardware/invalid_beams.hpp"
#include "safety/gate.hpp"
#include "safety/scan_points.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

const std::vector<std::string> kRobots = {"3we_standard_v2", "turtlebot_like"};

// A robot whose lidar turns in no time, in the middle of a square room.
struct Looking {
  explicit Looking(const std::string& name, double half_width = 2.0)
      : profile(load_profile(name)), gate(make_gate_model(profile)), model(make_sight_model(profile, gate)) {
    half = half_width;
  }
  double angle(std::size_t beam) const {
    return static_cast<double>(beam) * 2.0 * exact::kPi / profile.lidar->beams - exact::kPi;
  }
  // What the lidar measures; invalid where `covered` says so of a beam's angle, and where it is too near.
  template <typename Covered>
  void look(const Covered& covered) {
    now += profile.lidar->turn;
    const Pose2D lidar = base * profile.lidar->base_from_lidar;
    ranges.clear();
    for (std::size_t i = 0; i < static_cast<std::size_t>(profile.lidar->beams); ++i) {
      const Vec2 d = rotate({1.0, 0.0}, lidar.theta + angle(i));
      const double x = d.x > 0.0 ? (half - lidar.x) / d.x : d.x < 0.0 ? (-half - lidar.x) / d.x : 1e9;
      const double y = d.y > 0.0 ? (half - lidar.y) / d.y : d.y < 0.0 ? (-half - lidar.y) / d.y : 1e9;
      const double range = std::min({x, y, profile.lidar->range_max});
      ranges.push_back(covered(i) || range < profile.lidar->range_min ? 0.0F : static_cast<float>(range));
    }
    sight.add(model, {now, lidar, lidar}, ranges, base);
  }
  double nearest_unseen() const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec2 p : sight.unseen()) nearest = std::min(nearest, gate.footprint.signed_distance(inverse(base) * p));
    return nearest;
  }

  RobotProfile profile;
  GateModel gate;
  SightModel model;
  double half = 2.0;
  Pose2D base;
  Time now{};
  std::vector<float> ranges;
  Sight sight;
};

constexpr auto kNothing = [](std::size_t) { return false; };
constexpr auto kEverything = [](std::size_t) { return true; };

}  // namespace

TEST_CASE("beams without return, and a few that drop out, leave nothing unseen") {
  for (const std::string& robot : kRobots) {
    CAPTURE(robot);
    Looking far(robot, 100.0);
    far.look(kNothing);
    CHECK(far.sight.unseen().empty());
    Looking looking(robot);
    for (std::uint64_t scan = 0; scan < 200; ++scan) {
      const RngKey key{.seed = scan};
      looking.look([&](std::size_t i) { return uniform(key, i, 0, 0.0, 1.0) < 0.05; });
      CHECK(looking.sight.unseen().empty());
    }
  }
}

TEST_CASE("beside a wall that is too near to be measured, nothing is unseen") {
  Looking beside("turtlebot_like", 1.0);
  for (const double clearance : {0.02, 0.05, 0.06}) {
    beside.base = {0.0, 1.0 - 0.09 - clearance, 0.0};
    beside.look(kNothing);
    CHECK(invalid_beams(beside.ranges, 5).size() == 1);
    CHECK(beside.sight.unseen().empty());
  }
}

TEST_CASE("who has never seen anything is shut in by the margin; who has, for half a second no more") {
  for (const std::string& robot : kRobots) {
    CAPTURE(robot);
    Looking blind(robot);
    blind.look(kEverything);
    CHECK(blind.sight.unseen().size() == static_cast<std::size_t>(blind.profile.lidar->beams));
    CHECK(blind.nearest_unseen() == doctest::Approx(std::max(blind.gate.margin, blind.nearest_unseen())).epsilon(0.01));

    Looking covered(robot);
    covered.look(kNothing);
    for (int i = 0; i < 5; ++i) {
      covered.look(kEverything);
      CHECK(covered.sight.unseen().empty());  // the walls are far
    }
    covered.look(kEverything);
    CHECK(covered.sight.unseen().size() == static_cast<std::size_t>(covered.profile.lidar->beams));
  }
}

TEST_CASE("what was seen to stand in the way stays there while nobody looks") {
  Looking looking("3we_standard_v2", 0.3);
  looking.look(kNothing);
  looking.look(kEverything);
  for (const Vec2 p : looking.sight.unseen()) {
    const double off = std::max(std::abs(p.x), std::abs(p.y));
    CHECK(off > 0.29);
    CHECK(off < 0.3 + 0.03);
  }
}

TEST_CASE("a robot that does not see ahead goes no farther than what it has seen, in whatever steps it asks") {
  for (const std::string& robot : kRobots) {
    for (const double speed : {0.02, 0.1, 0.5}) {
      CAPTURE(robot);
      CAPTURE(speed);
      Looking looking(robot);
      GateState state;
      Pose2D commanded;
      const auto ahead = [&](std::size_t i) { return std::abs(looking.angle(i)) < 0.25 * exact::kPi; };
      for (int tick = 0; tick < 1000; ++tick) {
        if (tick % 5 == 0) {
          looking.base = commanded;
          looking.look(ahead);
          state.last_scan = looking.now;
          state.scan_seen = true;
        }
        const GateOutput out =
            gate(looking.gate, state, {{speed, 0.0, 0.0}}, {{}, looking.sight.unseen()}, looking.now, commanded);
        commanded = integrate(commanded, out.command, 0.02);
      }
      CHECK(commanded.x <= 0.04);  // starts are free by 5 cm
    }
  }
}
