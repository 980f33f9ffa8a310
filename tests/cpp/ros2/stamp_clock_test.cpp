// Robot time of what another clock stamped.
#include "ros2/stamp_clock.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include "draw.hpp"

namespace threewe::ros2 {
namespace {

constexpr Duration kUptime = 4711s;  // how far the sender's clock is ahead

TEST_CASE("measurements have their times, up to the least delay, whatever the sender's clock shows") {
  Draw draw(1);
  StampClock clock(1);
  for (int i = 0; i < 2000; ++i) {
    const Time truth = i * 10ms;
    const Duration delay = from_seconds(draw(0.001, 0.008));
    const auto measured = clock.measured(0, truth + kUptime, {}, {}, truth + delay);
    REQUIRE(measured);
    if (i < 100) continue;  // while it learns
    CHECK(*measured >= truth);
    CHECK(*measured <= truth + 2ms);
  }
}

TEST_CASE("a slow stream learns the offset from a quick one, of the same clock") {
  StampClock clock(2);
  for (int i = 1; i < 200; ++i) {
    const Time truth = i * 20ms;
    clock.measured(0, truth + kUptime, {}, {}, truth + 1ms);
    if (i % 5 != 0) continue;
    // a scan of 100 ms, stamped at its beginning, that arrives 120 ms after it; its beam 0 is its last
    const auto measured = clock.measured(1, truth + kUptime, 99ms, 99ms, truth + 120ms);
    REQUIRE(measured);
    if (i > 10) CHECK(*measured == truth + 100ms);
  }
}

TEST_CASE("another clock is another offset") {
  StampClock clock(2);
  for (int i = 1; i < 50; ++i) {
    const Time truth = i * 20ms;
    clock.measured(0, truth + kUptime, {}, {}, truth + 1ms);
    CHECK(clock.measured(1, truth + 2 * kUptime, {}, {}, truth + 5ms) == truth + 5ms);
  }
}

TEST_CASE("clocks drift apart, and the offset follows") {
  StampClock clock(1);
  for (int i = 1; i < 12000; ++i) {
    const Time truth = i * 10ms;
    const Time theirs = truth + truth / 10000;  // 100 ppm fast: 12 ms in the end
    const auto measured = clock.measured(0, theirs + kUptime, {}, {}, truth + 1ms);
    REQUIRE(measured);
    CHECK(*measured <= truth + 1ms);
    CHECK(*measured >= truth - 2ms);
  }
}

TEST_CASE("what has no stamp was measured as it arrived") {
  StampClock clock(1);
  CHECK(clock.measured(0, {}, {}, {}, 3s) == 3s);
  CHECK(clock.measured(0, {}, 10ms, 90ms, 4s) == 4s - 80ms);
}

TEST_CASE("what came twice, or was overtaken, is dropped; a clock that was set back is not") {
  StampClock clock(1);
  CHECK(clock.measured(0, kUptime + 1s, {}, {}, 1s));
  CHECK_FALSE(clock.measured(0, kUptime + 1s, {}, {}, 1010ms));
  CHECK_FALSE(clock.measured(0, kUptime + 990ms, {}, {}, 1020ms));
  CHECK(clock.measured(0, 7s, {}, {}, 2s) == 2s);
  CHECK(clock.measured(0, 8s, {}, {}, 3s) == 3s);
  clock.restart(0);
  CHECK(clock.measured(0, 1ms, {}, {}, 4s) == 4s);
}

TEST_CASE("a clock that is set by a fraction of a second costs some messages, and no reading its time") {
  for (const Duration step : {-900ms, -600ms, -300ms, -100ms, 100ms, 300ms, 600ms, 900ms}) {
    CAPTURE(to_seconds(step));
    Draw draw(7);
    StampClock clock(2);
    int dropped = 0;
    for (int i = 1; i < 1000; ++i) {
      const Time truth = i * 20ms;
      const Time stamp = truth + kUptime + (truth > 10s ? step : 0s);
      for (const std::size_t stream : {0U, 1U}) {  // odometry, and a lidar of 10 Hz
        if (stream == 1 && i % 5 != 0) continue;
        const Time arrival = truth + from_seconds(draw(0.001, 0.021));
        const auto measured = clock.measured(stream, stamp, {}, {}, arrival);
        dropped += measured ? 0 : 1;
        if (!measured || (truth > 10s && truth < 10600ms)) continue;
        CHECK(std::chrono::abs(*measured - truth) < 25ms);
      }
    }
    CHECK(dropped <= 4);
  }
}

TEST_CASE("what a link holds up, and then delivers at once, keeps its times") {
  StampClock clock(1);
  for (int i = 1; i < 500; ++i) {
    const Time truth = i * 20ms;
    const Time arrival = truth > 5s && truth < 5400ms ? 5400ms + i * 10us : truth + 1ms;
    const auto measured = clock.measured(0, truth + kUptime, {}, {}, arrival);
    REQUIRE(measured);
    CHECK(*measured == truth + 1ms);
  }
}

TEST_CASE("a message that comes again and again is none that is new") {
  StampClock clock(1);
  CHECK(clock.measured(0, kUptime, {}, {}, 1ms));
  for (int i = 1; i < 100; ++i) {
    CHECK_FALSE(clock.measured(0, kUptime, {}, {}, i * 50ms));
  }
}

TEST_CASE("a stamp for the sender is by its clock") {
  StampClock clock(1);
  CHECK_FALSE(clock.stamp_at(0, 1s));
  clock.measured(0, kUptime + 1s, {}, {}, 1002ms);
  CHECK(clock.stamp_at(0, 3002ms) == kUptime + 3s);
  clock.restart(0);
  CHECK_FALSE(clock.stamp_at(0, 4s));
}

TEST_CASE("times rise, whatever comes") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    StampClock clock(3);
    std::array<Time, 3> newest{-1ns, -1ns, -1ns};
    Time arrival{};
    for (int i = 0; i < 500; ++i) {
      arrival += from_seconds(draw(0.0, 0.05)) + 1ns;
      const auto stream = static_cast<std::size_t>(draw.whole(0, 2));
      const Time stamp =
          draw.whole(0, 9) == 0 ? from_seconds(draw(0.0, 1e6)) : arrival + kUptime - from_seconds(draw(0.0, 0.3));
      const Duration span = from_seconds(draw(0.0, 0.1));
      const auto measured = clock.measured(stream, stamp, span / 2, span, arrival);
      if (!measured) continue;
      CHECK(*measured > newest[stream]);
      CHECK(*measured <= arrival);
      newest[stream] = *measured;
    }
  }
}

}  // namespace
}  // namespace threewe::ros2
