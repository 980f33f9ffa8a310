// Robot time: things that happen at the same time, time limits, and thinking.
//
// Robot time goes by only inside `wait`, `sleep` and `thinking`. So this program prints the same lines in every run, on
// a fast machine and on a slow one; they are those of its twin in Python.
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "threewe/threewe.hpp"

using namespace std::chrono_literals;

namespace {

void say(const threewe::Robot& robot, const std::string& what) {
  std::printf("%5.2f s  %s\n", threewe::to_seconds(robot.now()), what.c_str());
}

/// Stands for a slow call: a neural network, a language model, the internet.
const char* ask_a_model() {
  std::this_thread::sleep_for(50ms);
  return "left";
}

}  // namespace

int main() {
  threewe::Robot robot;

  // two things at once: an observer is called at every tick, and looks around twice a second while the robot drives
  threewe::Time next = robot.now() + 500ms;
  const auto watcher = robot.runtime().observe([&](const threewe::TickView& tick) {
    if (tick.now < next) return;
    next += 500ms;
    const auto [x, y, theta] = tick.pose.map_from_base();
    std::printf("%5.2f s  at (%.1f, %.1f)\n", threewe::to_seconds(tick.now), x, y);
  });
  const threewe::MoveResult result = robot.wait(robot.move_to(2.0, 1.0));
  robot.runtime().unobserve(watcher);
  say(robot, std::string(to_string(result.reason)));

  // robot time stands still while the program waits for something else, and then makes up for it by 0.3 s
  std::string answer;
  robot.thinking(0.3, [&] { answer = ask_a_model(); });
  say(robot, "the model says " + answer);

  // a limit in robot time; the motion ends, and the robot stops
  if (!robot.wait(robot.move_to(0.0, 0.0, {.timeout = 1.0})).success) say(robot, "not there in time");

  // a motion goes on while the program does something else, until it is cancelled
  const threewe::MotionHandle turn = robot.rotate(10.0);
  robot.sleep(0.5);
  turn->cancel();
  say(robot, "nothing to be found here");
  return result.success && turn->result().reason == threewe::Reason::cancelled ? 0 : 1;
}
