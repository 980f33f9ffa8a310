// STOP, the reward of the tasks that end with it, and success weighted by path length.
#include "task/stop_task.hpp"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <vector>

#include "draw.hpp"

namespace threewe::task {
namespace {

using Action = std::array<float, 3>;

TEST_CASE("STOP is half a second of small commands, whatever the control period") {
  const Action small = {0.049F, -0.049F, 0.0F};
  for (const auto& [period, steps] : std::vector<std::pair<Duration, int>>{
           {20ms, 25}, {100ms, 5}, {300ms, 2}, {499999999ns, 2}, {500ms, 1}, {1s, 1}}) {
    CAPTURE(period.count());
    StopState state;
    for (int i = 0; i < steps; ++i) {
      CHECK_FALSE(says_stop(state));
      state = advance(state, small, period);
    }
    CHECK(says_stop(state));
  }
}

TEST_CASE("one command at its threshold, or not a number, and the count starts anew") {
  for (const Action& action : {Action{0.05F, 0.0F, 0.0F}, Action{0.0F, -0.05F, 0.0F}, Action{0.0F, 0.0F, 1.0F},
                               Action{std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F}}) {
    StopState state{480ms};
    CHECK(advance(state, action, 20ms) == StopState{});
    CHECK(says_stop(advance(state, Action{}, 20ms)));
  }
}

TEST_CASE("the reward is the progress, and ten for a right STOP") {
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    StopTaskState state{.stop = {}, .distance = draw(3.0, 9.0)};
    const double first = state.distance;
    const bool right = draw.whole(0, 1) == 0;
    double sum = 0.0;
    bool asked = false;
    StopTaskStep step;
    while (!step.terminated) {
      const bool still = draw.whole(0, 2) > 0;
      const Action action = {still ? 0.0F : 0.5F, 0.0F, 0.0F};
      const double unknown = std::numeric_limits<double>::infinity();
      const double distance = draw.whole(0, 9) == 0 ? unknown : draw(0.0, 9.0);
      step = advance(state, action, 100ms, distance, [&] { return asked = true, right; });
      if (distance < unknown) CHECK(state.distance == distance);
      sum += step.reward;
      CHECK(asked == step.terminated);
    }
    CHECK(step.success == right);
    CHECK(sum == doctest::Approx(first - state.distance + (right ? 10.0 : 0.0)));
  }
}

TEST_CASE("success weighted by path length") {
  CHECK(success_weighted_by_path_length(false, 4.0, 4.0) == 0.0);
  CHECK(success_weighted_by_path_length(true, 4.0, 5.0) == doctest::Approx(0.8));
  CHECK(success_weighted_by_path_length(true, 4.0, 3.9) == 1.0);
  CHECK(success_weighted_by_path_length(true, 0.0, 0.0) == 1.0);
  CHECK(success_weighted_by_path_length(true, 0.0, 0.2) == 1.0);
  CHECK(success_weighted_by_path_length(false, 0.0, 0.0) == 0.0);
}

}  // namespace
}  // namespace threewe::task
