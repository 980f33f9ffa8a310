// The controller driven: courses for both kinematics, and what its commands obey.
#include "nav/mppi.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "hardware/limits.hpp"
#include "hardware/parameters.hpp"
#include "nav/mppi/obstacle_field.hpp"
#include "nav/mppi_course.hpp"

namespace threewe::nav {
namespace {

using testing::Course;
using testing::CourseWorld;
using testing::kCourses;
using testing::Outcome;

// What the method can do with as many samples and plans as it takes. Robots make do with less, and their path follower
// does more than this: `./dev verify control` drives the same courses with that.
Params thorough(const RobotProfile& profile) {
  auto params = params_for<Params>(profile, "nav");
  params.mppi.samples = 2000;
  params.mppi.periods = 1;
  params.mppi.temperature = 0.3;
  params.mppi.obstacle_reach *= 3.0;
  params.mppi.people_reach *= 2.0;
  params.mppi.weights.obstacle_braking *= 0.3;
  params.mppi.weights.people_contact *= 2.0;
  params.mppi.weights.people_close *= 4.0;
  return params;
}

TEST_CASE("both kinematics drive all courses, and touch nothing") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(robot);
    for (const auto& [name, make] : kCourses) {
      for (std::uint64_t seed = 1; seed <= std::max<std::uint64_t>(1, cases(2)); ++seed) {
        CAPTURE(std::string(robot));
        CAPTURE(std::string(name));
        CAPTURE(seed);
        Mppi mppi(profile, thorough(profile));
        const Outcome outcome =
            testing::drive(profile, make(profile, seed), [&](const MppiObservation& seen, std::span<const Vec2> path) {
              return mppi.step(seen, {.path = path, .margin = 0.01});
            });
        CHECK(outcome.arrived);
        CHECK(outcome.clearance > 0.0);
      }
    }
  }
}

TEST_CASE("commands keep to the limits, and to what a period can change, whatever is asked and seen") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(robot);
    const Limits& limits = profile.operating_limits;
    for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
      CAPTURE(std::string(robot));
      CAPTURE(seed);
      testing::Draw draw(seed, 9);
      auto params = params_for<Params>(profile, "nav");
      params.mppi.samples = 200;
      Mppi mppi(profile, params, seed);
      Velocity last;
      for (int tick = 0; tick < 20; ++tick) {
        std::vector<Vec2> obstacles;
        for (int i = 0; i < 30; ++i) obstacles.push_back({draw.between(-1.0, 1.0), draw.between(-1.0, 1.0)});
        const std::vector<Vec2> path = {{0.0, 0.0}, {draw.between(-2.0, 2.0), draw.between(-2.0, 2.0)}};
        const Pose2D pose{draw.between(-0.2, 0.2), draw.between(-0.2, 0.2), draw.between(-3.0, 3.0)};
        const Velocity v = mppi.step({tick * kControlPeriod, pose, last, obstacles},
                                     {.path = path, .backwards = seed % 5 == 0, .margin = 0.05});
        REQUIRE(is_finite(v));
        REQUIRE(exact::hypot(v.vx, v.vy) <= limits.linear + 1e-9);
        REQUIRE(std::fabs(v.omega) <= limits.angular + 1e-9);
        if (profile.kinematics() == Kinematics::differential) REQUIRE(v.vy == 0.0);
        REQUIRE(within_acceleration(limits, last, v) == v);
        last = v;
      }
    }
  }
}

// Drives one task to its end in a room, with the path that it names.
template <class Task>
Pose2D carry_out(const RobotProfile& profile, const Course& course, Task task, double seconds) {
  Mppi mppi(profile, thorough(profile));
  CourseWorld world(profile, course);
  Velocity command;
  std::vector<Vec2> points;
  for (int tick = 0; to_seconds(tick * kControlPeriod) < seconds; ++tick) {
    if (tick % 5 == 0) points = world.scan();
    command = mppi.step({tick * kControlPeriod, world.pose(), command, points}, task(world.pose()));
    world.tick(command);
  }
  return world.pose();
}

Course empty_room() {
  Course course;
  testing::add_box(course.walls, {-2.0, -2.0}, {2.0, 2.0});
  return course;
}

TEST_CASE("it turns on the spot, more than a full turn too, and drives lines both ways") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(std::string(robot));
    const RobotProfile profile = load_profile(robot);
    double turned = 0.0;
    double last = 0.0;
    const Pose2D after_turn = carry_out(
        profile, empty_room(),
        [&](const Pose2D& pose) {
          turned += wrap_angle(pose.theta - last);
          last = pose.theta;
          return MppiTask{.turn = -7.0 - turned};
        },
        12.0);
    CHECK(turned == doctest::Approx(-7.0).epsilon(0.01));
    CHECK(norm(after_turn.position()) < 0.05);

    const std::array<Vec2, 2> line = {Vec2{0.0, 0.0}, Vec2{-0.8, 0.0}};
    const Pose2D after_line = carry_out(
        profile, empty_room(), [&](const Pose2D&) { return MppiTask{.path = line, .backwards = true}; }, 10.0);
    CHECK(distance(after_line.position(), line[1]) < 0.02);
    CHECK(std::fabs(after_line.theta) < 0.1);
  }
}

TEST_CASE("without a path it stays") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const Pose2D end = carry_out(profile, empty_room(), [](const Pose2D&) { return MppiTask{}; }, 4.0);
  CHECK(norm(end.position()) < 0.03);
}

TEST_CASE("a copy goes on as the original does, to the bit") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const Course course = testing::slalom(profile, 5);
  CourseWorld world(profile, course);
  Mppi mppi(profile, Params{});
  Velocity command;
  std::vector<Mppi> copy;
  for (int tick = 0; tick < 100; ++tick) {
    const std::vector<Vec2> points = world.scan();
    if (tick == 40) copy.push_back(mppi);
    const MppiObservation seen{tick * kControlPeriod, world.pose(), command, points};
    const Velocity next = mppi.step(seen, {.path = course.path});
    if (!copy.empty()) {
      REQUIRE(copy.front().step(seen, {.path = course.path}) == next);
    }
    command = next;
    world.tick(command);
  }
}

TEST_CASE("a plan is the weighted mean of its samples, and to read it changes nothing") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(std::string(robot));
    const RobotProfile profile = load_profile(robot);
    const bool holonomic = profile.kinematics() == Kinematics::holonomic;
    auto params = params_for<Params>(profile, "nav");
    params.mppi.samples = 100;  // a multiple of 16 is rolled out
    params.mppi.periods = 3;
    const Course course = testing::slalom(profile, 6);
    CourseWorld world(profile, course);
    Mppi read(profile, params);
    Mppi unread(profile, params);
    CHECK_FALSE(read.plan({}).has_value());
    Velocity command;
    for (int tick = 0; tick < 150; ++tick) {
      CAPTURE(tick);
      const std::vector<Vec2> points = world.scan();
      const Time now = tick * kControlPeriod;
      const MppiObservation seen{now, world.pose(), command, points};
      command = read.step(seen, {.path = course.path});
      REQUIRE(command == unread.step(seen, {.path = course.path}));
      CHECK_FALSE(read.plan(now + kControlPeriod).has_value());
      const std::optional<SampledPlan> plan = Mppi(read).plan(now);
      REQUIRE(plan.has_value());
      CHECK(plan->made == tick / 3 * 3 * kControlPeriod);
      REQUIRE(plan->poses.size() == mppi::kSteps);
      REQUIRE(plan->velocities.size() == mppi::kSteps);
      REQUIRE(plan->weights.size() == 112);
      REQUIRE(plan->trajectories.size() == 112 * mppi::kSteps);
      REQUIRE(plan->controls.size() == 112 * mppi::kSteps);

      double total = 0.0;
      std::vector<Velocity> mean(mppi::kSteps);
      for (std::size_t sample = 0; sample < plan->weights.size(); ++sample) {
        const double weight = plan->weights[sample];
        REQUIRE(weight >= 0.0);
        total += weight;
        for (std::size_t i = 0; i < mppi::kSteps; ++i) {
          const Velocity& v = plan->controls[sample * mppi::kSteps + i];
          mean[i] = {mean[i].vx + weight * v.vx, mean[i].vy + weight * v.vy, mean[i].omega + weight * v.omega};
        }
      }
      CHECK(total == doctest::Approx(1.0).epsilon(1e-12));
      for (std::size_t i = 0; i < mppi::kSteps; ++i) {
        const Velocity& v = plan->velocities[i];
        REQUIRE(std::fabs(v.vx - mean[i].vx) < 1e-5);
        REQUIRE(std::fabs(v.vy - mean[i].vy) < 1e-5);
        REQUIRE(std::fabs(v.omega - mean[i].omega) < 1e-5);
        if (!holonomic) REQUIRE(v.vy == 0.0);
      }

      // no way leaps, and all begin where the robot is or soon will be
      const double step =
          1.1 * profile.operating_limits.linear * params.mppi.step;  // a turn while braking may be faster
      for (std::size_t i = 0; i < plan->trajectories.size(); ++i) {
        const bool first = i % mppi::kSteps == 0;
        const Vec2 before = first ? world.pose().position() : plan->trajectories[i - 1].position();
        REQUIRE(distance(before, plan->trajectories[i].position()) < step + (first ? 0.15 : 0.0));
      }
      world.tick(command);
    }
  }
}

TEST_CASE("the obstacle field knows the real outline's clearance wherever the robot may be") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const Footprint footprint = load_profile(robot).body.footprint;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      CAPTURE(std::string(robot));
      CAPTURE(seed);
      testing::Draw draw(seed, 10);
      mppi::ObstacleField field(footprint, 1.4, 0.25, {});
      std::vector<Vec2> obstacles;
      for (int i = 0; i < 60; ++i) obstacles.push_back({5.0 + draw.between(-1.5, 1.5), draw.between(-1.5, 1.5)});
      field.update(obstacles, {5.0, 0.0}, {3.6, -1.35}, {6.4, 1.35});
      int close = 0;
      int off = 0;  // by so much that it matters: seen from the middle of the cell another obstacle was nearer
      const mppi::FieldView view = field.view();
      for (int i = 0; i < 300; ++i) {
        const Pose2D pose{5.0 + draw.between(-1.3, 1.3), draw.between(-1.3, 1.3), draw.between(-3.1, 3.1)};
        double expected = std::numeric_limits<double>::infinity();
        for (const Vec2 p : obstacles) expected = std::min(expected, footprint.signed_distance(inverse(pose) * p));

        // what the rollouts look up
        const Vec2 middle = pose * Vec2{static_cast<double>(view.middle_x), static_cast<double>(view.middle_y)};
        const Vec2 in_window = middle - field.middle();
        const auto cell = [&](double along) {
          return static_cast<int>(std::floor(along * static_cast<double>(view.cells_per_metre))) + mppi::kSide / 2;
        };
        const int bin = static_cast<int>(std::floor(pose.theta * mppi::kBins / exact::kPi)) & (mppi::kBins - 1);
        const std::int32_t packed =
            view.cells[(bin * mppi::kSide + cell(in_window.y)) * mppi::kSide + cell(in_window.x)];
        const Vec2 nearest =
            field.middle() + field.unit() * Vec2{static_cast<double>(static_cast<std::int16_t>(packed)),
                                                 static_cast<double>(packed >> 16)};
        const double found = footprint.signed_distance(inverse(pose) * nearest);
        CHECK(found > expected - 1e-4);
        if (expected > 0.2) continue;
        CHECK(found < expected + 0.06);
        ++close;
        off += found > expected + 0.01 ? 1 : 0;
      }
      CHECK(close > 100);
      CHECK(off < 0.05 * close);
    }
  }
}

}  // namespace
}  // namespace threewe::nav
