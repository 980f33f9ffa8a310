// The clock of a world.
#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

constexpr const char* kRealTime = "time runs by itself: the backend is not lockstep";

void time_starts_at_zero(const Context& context) {
  Bench bench = context.fresh();
  const Duration slack = bench.features().lockstep ? 0s : 1s;  // real time runs while the world is being made
  expect(bench.now() >= 0s && bench.now() <= slack, "the clock of a fresh world stands at {} s",
         to_seconds(bench.now()));
}

void advance_is_exact(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().lockstep, kRealTime);
  Time t{};
  for (const Duration step : {Duration{20ms}, Duration{1ns}, Duration{33333333ns}, Duration{7us}, Duration{250ms}}) {
    t += step;
    bench.world().advance_to(t);
    expect(bench.now() == t, "advance_to({} ns) ended at {} ns", t.count(), bench.now().count());
  }
}

void time_never_goes_back(const Context& context) {
  Bench bench = context.connected();
  for (Time last = bench.now(); last < 1s;) {
    bench.port().command({}, last + 200ms);
    bench.world().advance_to(last + kControlPeriod);
    bench.port().poll();
    const Time now = bench.now();
    expect(now >= last + kControlPeriod, "after advance_to({} s) the clock stands at {} s",
           to_seconds(last + kControlPeriod), to_seconds(now));
    last = now;
  }
}

void advance_to_now_does_nothing(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 200ms);
  bench.forget();
  const Time before = bench.now();
  bench.world().advance_to(before);
  applies_if(bench.features().lockstep, kRealTime);
  bench.poll();
  expect(bench.now() == before, "advance_to(now) moved time by {} s", to_seconds(bench.now() - before));
  expect(bench.samples().empty(), "advance_to(now) delivered samples");
}

void time_waits_for_advance(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().lockstep, kRealTime);
  bench.drive({}, 200ms);
  const Time before = bench.now();
  for (int i = 0; i < 100; ++i) bench.port().poll();
  expect(bench.now() == before, "time moved by {} s without advance_to", to_seconds(bench.now() - before));
}

void command_returns_at_once(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 200ms);
  const Time before = bench.now();
  for (int i = 0; i < 10; ++i) bench.port().command({}, before + 200ms);
  const Duration taken = bench.now() - before;
  expect(taken <= (bench.features().lockstep ? 0ms : 10 * kControlPeriod), "10 commands took {} s of robot time",
         to_seconds(taken));
}

constexpr Check kTimeChecks[] = {
    {"time_starts_at_zero", time_starts_at_zero},       {"advance_is_exact", advance_is_exact},
    {"time_never_goes_back", time_never_goes_back},     {"advance_to_now_does_nothing", advance_to_now_does_nothing},
    {"time_waits_for_advance", time_waits_for_advance}, {"command_returns_at_once", command_returns_at_once},
};

}  // namespace

std::span<const Check> time_checks() { return kTimeChecks; }

}  // namespace threewe::backend::conformance
