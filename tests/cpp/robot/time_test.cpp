// Robot time: when it advances, who waits, in which order waits end, and what can never end.
#include <doctest/doctest.h>

#include <chrono>
#include <vector>

#include "robot/toy_world.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

// The toy's world with its robot connected, at time 0.
struct Connected : Toy {
  Connected() { world->robot(0).connect(); }
};

}  // namespace

TEST_CASE("a sleep ends at the first tick at or after its time") {
  for (int ms = 1; ms <= 100; ++ms) {
    Connected toy;
    const WaitHandle wait = toy.world->sleep(ms * 1ms);
    toy.world->wait(wait);
    CHECK(toy.world->now() == (ms * 1ms + kControlPeriod - 1ns) / kControlPeriod * kControlPeriod);
    CHECK(wait->deadline() == ms * 1ms);
  }
}

TEST_CASE("time stands still while nobody waits") {
  Connected toy;
  CHECK_FALSE(toy.world->run(1s));
  CHECK(toy.world->now() == 0ms);
  CHECK_FALSE(toy.world->has_pending());
}

TEST_CASE("a sleep of no time is done at once and costs none") {
  Connected toy;
  const WaitHandle wait = toy.world->sleep(0ms);
  CHECK(wait->done());
  CHECK(toy.world->run(1s));
  CHECK(toy.world->now() == 0ms);
  CHECK(toy.world->take_finished() == std::vector{wait});
  CHECK_THROWS_AS(toy.world->sleep(-1ns), ContractError);
}

TEST_CASE("waits that end at one tick are told by deadline, then by creation") {
  Connected toy;
  const WaitHandle c = toy.world->sleep(39ms);
  const WaitHandle d = toy.world->sleep(40ms);
  const WaitHandle a = toy.world->sleep(25ms);
  const WaitHandle b = toy.world->sleep(25ms);
  while (!a->done()) CHECK(toy.world->run(1h));
  CHECK(toy.world->take_finished() == std::vector{a, b, c, d});
  CHECK(toy.world->take_finished().empty());
}

TEST_CASE("an alarm rings while others wait, but nobody waits for an alarm") {
  Connected toy;
  const WaitHandle alarm = toy.world->alarm(40ms);
  CHECK_FALSE(toy.world->run(1h));
  CHECK(toy.world->now() == 0ms);
  const WaitHandle sleep = toy.world->sleep(60ms);
  CHECK(toy.world->run(1h));
  CHECK(toy.world->now() == 40ms);
  CHECK(toy.world->take_finished() == std::vector{alarm});
  CHECK_FALSE(sleep->done());
}

TEST_CASE("what was forgotten is never done and lets no time go by") {
  Connected toy;
  const WaitHandle forgotten = toy.world->sleep(20ms);
  toy.world->forget(forgotten);
  CHECK_FALSE(toy.world->has_pending());
  toy.world->wait(toy.world->sleep(100ms));
  CHECK_FALSE(forgotten->done());
  CHECK_THROWS_AS(toy.world->wait(forgotten), ContractError);
}

TEST_CASE("thinking takes as long as it stands for, while others go on") {
  Connected toy;
  World& world = *toy.world;
  const WaitHandle other = world.sleep(100ms);

  world.open_hold();
  CHECK(world.held());
  CHECK_FALSE(world.run(1h));
  CHECK_THROWS_AS(world.tick(), ContractError);
  CHECK(world.now() == 0ms);

  const WaitHandle thought = world.close_hold(200ms);
  world.wait(other);
  CHECK(world.now() == 100ms);
  world.wait(thought);
  CHECK(world.now() == 200ms);
}

TEST_CASE("thoughts at the same time run side by side") {
  Connected toy;
  World& world = *toy.world;
  world.open_hold();
  world.open_hold();
  const WaitHandle slow = world.close_hold(300ms);
  CHECK_FALSE(world.run(1h));  // the second thinker holds still
  CHECK_FALSE(slow->done());
  const WaitHandle fast = world.close_hold(100ms);
  world.wait(slow);
  CHECK(world.now() == 300ms);
  CHECK(world.take_finished() == std::vector{fast});
  CHECK_THROWS_AS(world.close_hold(0ms), ContractError);
}

TEST_CASE("a thought that starts in the middle of another's charge") {
  Connected toy;
  World& world = *toy.world;
  world.open_hold();
  const WaitHandle first = world.close_hold(100ms);
  world.wait(world.sleep(40ms));
  world.open_hold();
  CHECK_THROWS_AS(world.wait(first), ContractError);
  const WaitHandle second = world.close_hold(100ms);
  world.wait(first);
  CHECK(world.now() == 100ms);
  world.wait(second);
  CHECK(world.now() == 140ms);
}

TEST_CASE("waiting for what can never happen throws") {
  Toy unconnected;
  CHECK_THROWS_AS(unconnected.world->wait(unconnected.world->sleep(1s)), ConnectionError);

  Connected toy;
  Connected other;
  CHECK_THROWS_AS(toy.world->wait(other.world->sleep(1s)), ContractError);
  toy.world->open_hold();
  CHECK_THROWS_AS(toy.world->wait(toy.world->sleep(1s)), ContractError);
}

TEST_CASE("Robot: thinking, also when the thought fails or waits inside itself") {
  Toy toy;
  Robot robot(*toy.world);
  const Time start = toy.world->now();
  robot.thinking(0.5, [&] { CHECK(robot.world().held()); });
  CHECK(toy.world->now() == start + 500ms);

  CHECK_THROWS_AS(robot.thinking(0.5, [] { throw std::runtime_error("no idea"); }), std::runtime_error);
  CHECK_FALSE(toy.world->held());
  CHECK_THROWS_AS(robot.thinking(0.5, [&] { robot.sleep(1.0); }), ContractError);
  CHECK_FALSE(toy.world->held());
  CHECK_THROWS_AS(robot.thinking(-1.0, [] {}), ContractError);
  CHECK(toy.world->now() == start + 500ms);
}

TEST_CASE("a paced world never runs ahead of the wall clock") {
  Toy toy({"3we_standard_v2"}, {}, {}, true);
  toy.world->robot(0).connect();
  CHECK(toy.world->realtime());
  CHECK(toy.world->due() == 0ms);
  const auto start = std::chrono::steady_clock::now();
  toy.world->wait(toy.world->sleep(100ms));
  // the first tick is due at once, the fifth 80 ms later
  CHECK(std::chrono::steady_clock::now() - start >= 80ms);
}

TEST_CASE("a paced world hands control back when its slice is over, and goes by while nobody waits") {
  Toy toy({"3we_standard_v2"}, {}, {}, true);
  toy.world->robot(0).connect();
  while (toy.world->now() < 40ms) toy.world->run(1ms);
  CHECK(toy.world->now() == 40ms);
}

TEST_CASE("several worlds keep their own time") {
  Connected one;
  Connected other;
  one.world->wait(one.world->sleep(1s));
  CHECK(one.world->now() == 1s);
  CHECK(other.world->now() == 0s);
}
