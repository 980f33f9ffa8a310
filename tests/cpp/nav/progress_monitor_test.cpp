#include "nav/progress_monitor.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace threewe::nav {
namespace {

constexpr double kSpeedLimit = 0.5;  // [m/s] ...
constexpr double kSpeed = 0.2;       // ... of which it covers ground at a share

// Drives along x, from place to place, at the usual speed; the time when the motion stalls, or `end`.
Time drive(ProgressMonitor& monitor, double from, double to, double goal, Time begin, Time end) {
  Time now = begin;
  for (; now < end && !monitor.stalled(now); now += 20ms) {
    const double driven = kSpeed * to_seconds(now - begin);
    const double x = from < to ? std::min(from + driven, to) : std::max(from - driven, to);
    monitor.update(now, {x, 0.0}, std::fabs(goal - x));
  }
  return now;
}

TEST_CASE("a drive that gets on never stalls, however long it is") {
  ProgressMonitor monitor(kSpeedLimit, Params{});
  monitor.begin(0s);
  CHECK(drive(monitor, 0.0, 500.0, 500.0, 0s, 2500s) == 2500s);
}

TEST_CASE("a robot that stands stalls after two minutes and twice the time that the rest of its path takes") {
  ProgressMonitor monitor(kSpeedLimit, Params{});
  monitor.begin(0s);
  const double stalled = to_seconds(drive(monitor, 0.0, 0.0, 10.0, 0s, 10000s));
  CHECK(stalled == doctest::Approx(120.0 + 2.0 * 10.0 / kSpeed).epsilon(0.01));
}

TEST_CASE("a robot that goes all the way back to take another way does not stall on the way back") {
  ProgressMonitor monitor(kSpeedLimit, Params{});
  monitor.begin(0s);
  const Time there = drive(monitor, 0.0, 60.0, 61.0, 0s, 310s);
  REQUIRE(there == 310s);
  const Time back = drive(monitor, 60.0, -1.0, -40.0, there, there + 310s);
  CHECK(back == there + 310s);
  CHECK(drive(monitor, -1.0, -40.0, -40.0, back, back + 200s) == back + 200s);
}

TEST_CASE("a robot that wavers between two ways stalls") {
  ProgressMonitor monitor(kSpeedLimit, Params{});
  monitor.begin(0s);
  Time now = 0s;
  for (int i = 0; i < 200 && !monitor.stalled(now); ++i) {
    now = drive(monitor, i % 2 == 0 ? 0.0 : 5.0, i % 2 == 0 ? 5.0 : 0.0, 8.0, now, now + 25s);
  }
  CHECK(monitor.stalled(now));
  CHECK(to_seconds(now) < 500.0);
}

TEST_CASE("a motion that begins has nothing to do with the one before") {
  ProgressMonitor monitor(kSpeedLimit, Params{});
  monitor.begin(0s);
  const Time stalled = drive(monitor, 0.0, 0.0, 1.0, 0s, 1000s);
  CHECK(monitor.stalled(stalled));
  monitor.begin(stalled);
  CHECK_FALSE(monitor.stalled(stalled + 60s));
}

}  // namespace
}  // namespace threewe::nav
