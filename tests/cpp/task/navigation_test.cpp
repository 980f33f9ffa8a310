// Navigation as a pure function of moments.
#include "threewe/task/tasks.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>

#include "scene/scene_tables.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

const Scenes& office() {
  static const Scenes scenes{std::make_shared<const scene::SceneTables>(
      std::make_shared<const scene::Scene>(scene::Scene::load("office_v2")), Footprint::rectangle(0.25, 0.22), 0.15)};
  return scenes;
}

struct Alone {
  std::unique_ptr<Task> task;
  std::array<Pose2D, 1> start{};
  explicit Alone(const NavigationOptions& options = {}) : task(make_navigation({.scenes = office()}, options)) {}

  void begin(std::uint32_t episode, const EpisodeRequest& request = {}) {
    task->begin(0, {.seed = 7, .episode = episode}, request, start);
  }
  Outcome step(const Pose2D& pose, double driven, double contact = 0.0, const Velocity& action = {}) {
    const TaskState moment{.pose = pose, .action = action, .distance_driven = driven, .max_collision_speed = contact};
    Outcome outcome;
    task->step(0, {&moment, 1}, {&outcome, 1});
    return outcome;
  }
  double metric(std::size_t i) const {
    std::array<double, 8> metrics{};
    task->measure(0, std::span(metrics).first(task->metrics().size()));
    return metrics.at(i);
  }
  Vec2 goal_in_robot(const Pose2D& map_from_base) {
    std::array<float, 2> goal{};
    const std::span<std::byte> bytes = std::as_writable_bytes(std::span(goal));
    task->observe(0, 0, {.map_from_base = map_from_base}, {&bytes, 1});
    return {static_cast<double>(goal[0]), static_cast<double>(goal[1])};
  }
};

TEST_CASE("episodes keep their bounds, differ, and are the same for the same key") {
  Alone alone({.goals = 16});
  Alone again({.goals = 16});
  std::set<double> starts;
  int detours = 0;
  for (std::uint32_t i = 0; i < 300; ++i) {
    CAPTURE(i);
    alone.begin(i);
    again.begin(299 - i);
    again.begin(i);
    CHECK(alone.start == again.start);
    const double shortest = alone.metric(3);
    CHECK(shortest == again.metric(3));
    CHECK(shortest >= 2.0);
    CHECK(shortest <= 15.0);
    CHECK(office()[0]->clearance(alone.start[0]) >= 0.05);
    const Vec2 goal = alone.goal_in_robot({});
    CHECK(shortest ==
          doctest::Approx(office()[0]->geodesic(alone.start[0].position(), alone.start[0] * goal)).epsilon(0.02));
    detours += shortest > 1.3 * norm(goal) ? 1 : 0;
    starts.insert(alone.start[0].x);
  }
  CHECK(starts.size() > 200);
  CHECK(detours > 30);
  CHECK(detours < 90);
}

TEST_CASE("rewards add up to the way that was made good") {
  Alone alone({.goals = 4});
  alone.begin(0, {.start = Pose2D{0.0, 0.0, 0.0}, .goal = Vec2{2.0, 1.0}});
  const double whole = alone.metric(3);
  CHECK(whole == doctest::Approx(std::hypot(2.0, 1.0)).epsilon(0.05));
  double sum = 0.0;
  int steps = 0;
  Outcome last;
  for (double share = 0.1; !last.terminated; share += 0.1) {
    last = alone.step({2.0 * share, share, 0.0}, share * whole);
    sum += last.reward;
    ++steps;
  }
  const double left = alone.metric(2);
  CHECK(left <= 0.5);
  CHECK(sum == doctest::Approx(whole - left - 0.01 * steps + 10.0));
  CHECK(alone.metric(0) == 1.0);
  CHECK(alone.metric(1) == doctest::Approx(1.0));
}

TEST_CASE("a contact ends an episode in failure, a gentle one does not") {
  Alone alone({.goals = 4});
  alone.begin(0);
  CHECK_FALSE(alone.step(alone.start[0], 0.0, 0.049).terminated);
  const Outcome outcome = alone.step(alone.start[0], 0.0, 0.051);
  CHECK(outcome.terminated);
  CHECK(outcome.reward == doctest::Approx(-10.01));
  CHECK(alone.metric(0) == 0.0);
  CHECK(alone.metric(1) == 0.0);
}

TEST_CASE("with stop only STOP ends an episode, right within the success distance and wrong elsewhere") {
  const Velocity ahead{1.0, 0.0, 0.0};
  for (const double x : {2.0, 1.0}) {
    CAPTURE(x);
    Alone alone({.goals = 4, .stop = true});
    alone.begin(0, {.start = Pose2D{0.0, 0.0, 0.0}, .goal = Vec2{2.0, 0.0}});
    CHECK_FALSE(alone.step({2.0, 0.0, 0.0}, 2.0, 0.0, ahead).terminated);  // there, and says nothing
    Outcome outcome;
    for (int i = 0; i < 5; ++i) {  // half a second of actions below 5 %
      CHECK_FALSE(outcome.terminated);
      outcome = alone.step({x, 0.0, 0.0}, 2.0, 0.0, {0.04, 0.0, -0.04});
    }
    CHECK(outcome.terminated);
    CHECK(alone.metric(0) == (x == 2.0 ? 1.0 : 0.0));
    CHECK(alone.task->metrics().at(6) == "stopped");
    CHECK(alone.metric(6) == 1.0);
  }
}

TEST_CASE("contacts that are counted end no episode") {
  Alone alone({.goals = 4, .contact_ends = false});
  alone.begin(0);
  const scene::SceneTables& tables = *office()[0];
  Pose2D wall = alone.start[0];  // to the first obstacle ahead
  while (tables.clearance(wall) > 1e-4) wall = wall * Pose2D{0.5 * std::max(tables.clearance(wall), 1e-4), 0.0, 0.0};
  CHECK_FALSE(alone.step(alone.start[0], 0.0).terminated);
  CHECK(alone.metric(6) == 0.0);
  CHECK_FALSE(alone.step(wall, 1.0, 0.3).terminated);
  CHECK_FALSE(alone.step(wall, 1.0, 0.3).terminated);  // the same one
  CHECK(alone.metric(6) == 1.0);
  CHECK_FALSE(alone.step(alone.start[0], 2.0, 0.3).terminated);
  CHECK_FALSE(alone.step(wall, 3.0, 0.3).terminated);
  CHECK(alone.metric(6) == 2.0);
  CHECK(alone.task->metrics().at(6) == "contacts");
}

TEST_CASE("robots of a team have goals and metrics of their own, and keep them when they are done") {
  const auto task = make_navigation({.scenes = office(), .robots = 2}, {.goals = 4});
  std::array<Pose2D, 2> starts;
  task->begin(0, {.seed = 3}, {}, starts);
  const std::vector<Vec2> goals = task->debug_overlay(0).goals;
  REQUIRE(goals.size() == 2);

  // the first arrives, the second stays; then the first is hit, and counts as arrived all the same
  std::array<Outcome, 2> outcomes;
  std::array<TaskState, 2> moments{TaskState{.pose = {goals[0].x, goals[0].y, 0.0}, .distance_driven = 20.0},
                                   TaskState{.pose = starts[1], .distance_driven = 0.0}};
  task->step(0, moments, outcomes);
  CHECK(outcomes[0].terminated);
  CHECK_FALSE(outcomes[1].terminated);
  std::array<double, 12> arrived{};
  task->measure(0, arrived);
  CHECK(arrived[0] == 1.0);
  CHECK(arrived[4] == 20.0);
  CHECK(arrived[6] == 0.0);
  CHECK(arrived[8] == arrived[9]);
  moments[0].max_collision_speed = 0.5;
  task->step(0, moments, outcomes);
  CHECK(outcomes[0].reward == 0.0);
  std::array<double, 12> later{};
  task->measure(0, later);
  CHECK(later == arrived);
}

TEST_CASE("the goal is seen from where the robot believes to be") {
  Alone alone({.goals = 4});
  alone.begin(3, {.start = Pose2D{1.0, 0.0, 1.0}, .goal = Vec2{2.0, 1.0}});
  const Vec2 goal = inverse(Pose2D{1.0, 0.0, 1.0}) * Vec2{2.0, 1.0};
  CHECK(distance(alone.goal_in_robot({}), goal) < 1e-6);
  const Pose2D belief{0.3, -0.2, 0.5};
  CHECK(distance(alone.goal_in_robot(belief), inverse(belief) * goal) < 1e-6);

  Alone in_map({.goals = 4, .goal_in_map = true});
  in_map.begin(3, {.start = Pose2D{1.0, 0.0, 1.0}, .goal = Vec2{2.0, 1.0}});
  CHECK(distance(in_map.goal_in_robot(belief), goal) < 1e-6);
}

TEST_CASE("what can't be is refused") {
  Alone alone({.goals = 4});
  CHECK_THROWS_AS(alone.begin(0, {.goal = Vec2{1000.0, 0.0}}), ConfigError);
  CHECK_THROWS_AS(alone.begin(0, {.start = Pose2D{1000.0, 0.0, 0.0}}), ConfigError);
  CHECK_THROWS_AS(Alone({.goals = 4, .shortest = 200.0, .longest = 300.0}).begin(0), ConfigError);
}

}  // namespace
}  // namespace threewe::task
