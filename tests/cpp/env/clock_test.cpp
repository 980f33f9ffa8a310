// Episode clock: what will read a scan, by the table and worked out.
#include "env/clock.hpp"

#include <doctest/doctest.h>

#include "draw.hpp"

namespace threewe::env {

TEST_CASE("the table knows what will read a scan") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const auto whole = [&](int low, int high) { return static_cast<std::uint64_t>(draw.whole(low, high)); };
    constexpr std::uint64_t kTick = 2;  // steps
    Clock clock;
    clock.settle = kTick * whole(1, 60);
    clock.period = kTick * whole(1, 30);
    clock.turn = whole(1, 25);
    clock.latency = whole(0, 40);
    clock.scans = true;
    clock.gate_reads = whole(0, 1) == 1;
    clock.any_may_be = whole(0, 1) == 1;
    clock.tabulate();
    for (std::uint64_t step = 0; step < 4000; ++step) REQUIRE(clock.use_of_scan(step) == clock.work_out_use(step));
  }
}

TEST_CASE("a clock without scans has no use for them") {
  Clock clock;
  CHECK(clock.use_of_scan(7) == ScanUse::none);
}

}  // namespace threewe::env
