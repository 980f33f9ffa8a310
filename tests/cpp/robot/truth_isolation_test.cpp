// What a robot does does not depend on what only its simulator knows.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "robot/false_truth_world.hpp"
#include "robot/peeking_autonomy.hpp"
#include "robot/toy_world.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

// Whether the truth can be asked for by name.
template <typename T>
concept KnowsTheTruth = requires(T& it) { it.truth_service(); } || requires(T& it) { it.truth(); } ||
                        requires(T& it) { it.truth(std::size_t{0}); } || requires(T& it) { it.simulation(); };

static_assert(!KnowsTheTruth<backend::RobotPort>);
static_assert(!KnowsTheTruth<Runtime>);         // an observer sees a const one
static_assert(!KnowsTheTruth<const World>);     // as Runtime::world() is
static_assert(!KnowsTheTruth<const TickView>);  // what an observer is given
static_assert(KnowsTheTruth<World>);
static_assert(KnowsTheTruth<backend::World>);
static_assert(KnowsTheTruth<Robot>);

// What happens to a robot in a world that states the truth, or in one that falsifies it.
struct Record {
  std::vector<Time> stamps;
  std::vector<Pose2D> poses;
  std::vector<Velocity> commands;
  friend bool operator==(const Record&, const Record&) = default;
};

std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options, bool falsified) {
  std::unique_ptr<backend::World> world = backend::make_world("mock", options);
  if (!falsified) return world;
  return std::make_unique<FalseTruthWorld>(std::move(world));
}

template <typename Errand>
Record record(World& world, const Errand& errand) {
  Robot robot(world);
  Record record;
  const auto id = robot.runtime().observe([&](const TickView& view) {
    record.stamps.push_back(view.now);
    record.poses.push_back(view.pose.map_from_base());
    record.commands.push_back(view.commanded.command);
  });
  errand(robot);
  robot.runtime().unobserve(id);
  return record;
}

}  // namespace

TEST_CASE("where the truth is shifted and people are exchanged, every command stays the same to the bit") {
  const auto errand = [](Robot& robot) {
    (void)robot.wait(robot.move_to(2.0, 1.0, {.timeout = 20.0}));
    (void)robot.wait(robot.explore(10.0));
    robot.set_velocity(0.3, 0.0, 0.5);
    robot.sleep(0.4);
    (void)robot.wait(robot.rotate(1.0));
    robot.execute_action({0.5, 0.0, -0.5}, 0.1);
  };
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    CAPTURE(seed);
    const backend::WorldOptions options{.scene = seed == 0 ? "office_v2" : "dynamic_v1", .seed = seed};
    World stated(make_world(options, false));
    World falsified(make_world(options, true));
    const scene::TruthView& truth = stated.truth_service()->truth(0);
    const scene::TruthView& lie = falsified.truth_service()->truth(0);
    CHECK(distance(truth.true_pose().position(), lie.true_pose().position()) > 100.0);
    for (std::size_t i = 0; i < truth.people().size(); ++i) CHECK(truth.people()[i].name != lie.people()[i].name);

    const Record expected = record(stated, errand);
    CHECK(expected.commands.size() > 500);
    CHECK(record(falsified, errand) == expected);
  }
}

TEST_CASE("an autonomy stack that peeks at the truth is found out") {
  const auto errand = [](Robot& robot) { (void)robot.wait(robot.move_to(2.0, 1.0, {.timeout = 4.0})); };
  const backend::WorldOptions options{.scene = "dynamic_v1", .seed = 1};
  for (const PeekingAutonomy& twin : kPeekingAutonomies) {
    CAPTURE(twin.at);
    const auto commands = [&](bool falsified) {
      auto backend = make_world(options, falsified);
      const Autonomy autonomy = twin.make(*backend->truth_service());
      World world(std::move(backend), false, autonomy);
      return record(world, errand).commands;
    };
    const std::vector<Velocity> expected = commands(false);
    CHECK(expected == commands(false));  // it is repeatable, and differs by what it peeks at alone
    CHECK(expected != commands(true));
  }
}

TEST_CASE("a world of real robots has no truth, and says so") {
  World world(std::make_unique<test::ToyWorld>());
  CHECK(world.truth_service() == nullptr);
  CHECK(Robot(world).simulation() == nullptr);
  CHECK_THROWS_WITH_AS(Simulation(world, 0),
                       "robot '3we_standard_v2' is not simulated: on this backend the truth about it is unknown",
                       ContractError);
  CHECK_THROWS_WITH_AS(World(std::make_unique<test::ToyWorld>(), false, autonomy_with("truth")),
                       "localization 'truth' needs a simulator that states it; unknown is where robot "
                       "'3we_standard_v2' truly is on this backend",
                       ContractError);
}
