// Exploration: its coverage against the meter that explorations of robots are measured with.
#include "threewe/task/tasks.hpp"

#include <doctest/doctest.h>

#include <array>
#include <memory>
#include <vector>

#include "core/exact.hpp"
#include "scene/coverage.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::task {
namespace {

constexpr double kLidarHeight = 0.135;

const Scenes& office() {
  static const Scenes scenes{std::make_shared<const scene::SceneTables>(
      std::make_shared<const scene::Scene>(scene::Scene::load("office_v2")), Footprint::rectangle(0.25, 0.22), 0.15)};
  return scenes;
}

std::vector<float> rays_from(const Pose2D& lidar) {
  static const scene::Slice slice = office()[0]->scene().at_height(kLidarHeight);
  std::vector<float> ranges;
  for (int i = 0; i < 360; ++i) {
    const double angle = lidar.theta + i * 2.0 * exact::kPi / 360;
    ranges.push_back(static_cast<float>(scene::cast_ray(slice, lidar.position(), angle, 12.0)));
  }
  return ranges;
}

double metric(const Task& task, std::size_t i) {
  std::array<double, 8> metrics{};  // of two robots
  task.measure(0, metrics);
  return metrics.at(i);
}

TEST_CASE("two robots cover together what a meter says they do, and earn what they cover") {
  const auto task = make_exploration({.scenes = office(), .robots = 2});
  CHECK(task->rays() == 360);
  std::array<Pose2D, 2> starts;
  task->begin(0, {.seed = 5}, {}, starts);
  CHECK(distance(starts[0].position(), starts[1].position()) >= 1.0);
  CHECK(distance(starts[0].position(), starts[1].position()) <= 4.0);

  scene::CoverageMeter meter(office()[0], kLidarHeight);
  double earned = 0.0;
  double area = 0.0;
  for (const unsigned char cell : meter.reachable_cells().cells) area += cell ? 0.0025 : 0.0;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const std::array<Pose2D, 2> lidars{office()[0]->sample_free_pose(2 * i), office()[0]->sample_free_pose(2 * i + 1)};
    const std::vector<float> first = rays_from(lidars[0]);
    const std::vector<float> second = rays_from(lidars[1]);
    std::array<TaskState, 2> moments;
    moments[0] = {.pose = lidars[0], .lidar = lidars[0], .ranges = first};
    moments[1] = {.pose = lidars[1], .lidar = lidars[1], .ranges = second};
    std::array<Outcome, 2> outcomes;
    task->step(0, moments, outcomes);
    CHECK(outcomes[0].reward == outcomes[1].reward);
    earned += outcomes[0].reward + 0.01;
    meter.observe(lidars[0]);
    meter.observe(lidars[1]);
    CHECK(metric(*task, 1) == doctest::Approx(meter.crossed()).epsilon(1e-3));  // floats and doubles, cell by cell
    if (outcomes[0].terminated) earned -= 10.0;
    CHECK(outcomes[0].terminated == (metric(*task, 1) >= 0.95));
    if (outcomes[0].terminated) break;
  }
  CHECK(metric(*task, 1) > 0.5);
  CHECK(earned == doctest::Approx(0.2 * area * metric(*task, 1)).epsilon(1e-6));
}

TEST_CASE("the coverage map shows what was seen, around the robot") {
  const auto task = make_exploration({.scenes = office()});
  std::array<Pose2D, 1> start;
  task->begin(0, {.seed = 5}, {.start = Pose2D{}}, start);
  std::vector<float> scan(360, 3.0F);
  scan[90] = 0.0F;  // invalid: to the right nothing is known
  const Pose2D belief{1.0, 0.0, 0.0};
  task->update(0, {belief, scan, {}, 12.0});
  std::vector<std::byte> map(64 * 64);
  const std::span<std::byte> bytes(map);
  task->observe(0, 0, {belief, scan, {}, 12.0}, {&bytes, 1});
  const auto value = [&](int row, int column) {
    return std::to_integer<int>(map[static_cast<std::size_t>(row * 64 + column)]);
  };
  CHECK(value(32, 32) == 127);
  CHECK(value(32, 42) == 127);       // 2.6 m ahead
  CHECK(value(32, 32 + 12) == 255);  // 3 m ahead
  CHECK(value(32 + 12, 32) == 255);  // 3 m to the left
  CHECK(value(32, 32 - 12) == 255);
  CHECK(value(32, 32 + 14) == 0);
  CHECK(value(0, 0) == 0);
}

TEST_CASE("an exploration has no goal") {
  const auto task = make_exploration({.scenes = office()});
  std::array<Pose2D, 1> start;
  CHECK_THROWS_AS(task->begin(0, {}, {.goal = Vec2{}}, start), ConfigError);
}

}  // namespace
}  // namespace threewe::task
