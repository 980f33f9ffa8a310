#include "policy/timeline.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "draw.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using policy::Merge, policy::Timeline;

namespace {

const Limits kLimits = load_profile("3we_standard_v2").operating_limits;

policy::TimelineModel model(Merge merge, double rate = 10.0, std::size_t chunk = 5) {
  return policy::make_timeline_model(kLimits, rate, chunk, merge);
}

std::vector<Velocity> constant(double vx, std::size_t count = 5) { return {count, Velocity{vx, 0.0, 0.0}}; }

constexpr double kRounding = 1e-9;  // [s], of the twin's times

// The definition, word by word: every chunk that ever came is kept, and each is read by looking at all of its actions.
struct SlowTimeline {
  struct Chunk {
    double measured = 0.0;
    double applied = 0.0;
    std::vector<Velocity> actions;
  };
  double period;
  Merge merge;
  std::vector<Chunk> chunks{};
  Velocity last{};

  double end(const Chunk& chunk) const {
    return chunk.measured + period * (static_cast<double>(chunk.actions.size()) - 1);
  }
  // a hat of one period around each action
  Velocity read(const Chunk& chunk, double t) const {
    Velocity v;
    for (std::size_t k = 0; k < chunk.actions.size(); ++k) {
      const double at = chunk.measured + static_cast<double>(k) * period;
      const double weight = std::max(0.0, 1.0 - std::abs(std::min(t, end(chunk)) - at) / period);
      v = {v.vx + weight * chunk.actions[k].vx, v.vy + weight * chunk.actions[k].vy,
           v.omega + weight * chunk.actions[k].omega};
    }
    return v;
  }
  Velocity blend(std::size_t newest, double t) const {
    const Velocity mine = read(chunks[newest], t);
    if (newest == 0 || t >= end(chunks[newest - 1]) - kRounding) return mine;
    const double from = chunks[newest].applied;
    const double w = (t - from) / (end(chunks[newest - 1]) - from);
    const Velocity old = blend(newest - 1, t);
    return {(1 - w) * old.vx + w * mine.vx, (1 - w) * old.vy + w * mine.vy, (1 - w) * old.omega + w * mine.omega};
  }
  Velocity next(double t) {
    if (chunks.empty() || end(chunks.back()) < t - kRounding) return last = braked();
    if (merge == Merge::replace) return last = read(chunks.back(), t);
    if (merge == Merge::blend) return last = blend(chunks.size() - 1, t);
    Velocity sum;
    double weights = 0.0;
    int age = 0;
    for (const Chunk& chunk : chunks) {
      if (end(chunk) < t - kRounding) continue;
      const double w = std::exp(-0.01 * age++);
      const Velocity v = read(chunk, t);
      sum = {sum.vx + w * v.vx, sum.vy + w * v.vy, sum.omega + w * v.omega};
      weights += w;
    }
    return last = {sum.vx / weights, sum.vy / weights, sum.omega / weights};
  }
  Velocity braked() const {
    const double speed = std::hypot(last.vx, last.vy);
    const double kept = speed == 0.0 ? 0.0 : std::max(0.0, 1.0 - kLimits.linear_braking * 0.02 / speed);
    const double turn = std::max(0.0, std::abs(last.omega) - kLimits.angular_acceleration * 0.02);
    return {kept * last.vx, kept * last.vy, std::copysign(turn, last.omega)};
  }
};

void check_near(const Velocity& a, const Velocity& b) {
  CHECK(std::abs(a.vx - b.vx) < 1e-7);
  CHECK(std::abs(a.vy - b.vy) < 1e-7);
  CHECK(std::abs(a.omega - b.omega) < 1e-7);
}

}  // namespace

TEST_CASE("random chunks with random latencies: as the definition says") {
  for (const Merge merge : {Merge::replace, Merge::blend, Merge::ensemble}) {
    int late = 0;
    for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
      CAPTURE(seed);
      Draw draw(seed);
      const double rate = std::vector{5.0, 10.0, 12.5, 50.0}[static_cast<std::size_t>(draw.whole(0, 3))];
      const auto length = static_cast<std::size_t>(draw.whole(2, 12));
      Timeline timeline(model(merge, rate, length));
      SlowTimeline slow{1.0 / rate, merge};
      Time measured{-1};
      for (int tick = 0; tick < 150; ++tick) {
        const Time now = tick * kControlPeriod;
        const Time picture = now - draw.whole(0, 25) * kControlPeriod;
        if (draw(0.0, 1.0) < 0.15 && picture > measured) {
          std::vector<Velocity> actions(length);
          for (Velocity& v : actions) v = {draw(-0.5, 0.5), draw(-0.5, 0.5), draw(-1.0, 1.0)};
          const int dropped = timeline.counts().late;
          timeline.add(picture, actions, now);
          if (timeline.counts().late == dropped) {
            measured = picture;
            slow.chunks.push_back({to_seconds(picture), to_seconds(now), actions});
          }
        }
        check_near(timeline.next(now), slow.next(to_seconds(now)));
      }
      late += timeline.counts().late;
      CHECK(timeline.counts().applied == static_cast<int>(slow.chunks.size()));
    }
    CHECK(late > 0);
  }
}

TEST_CASE("what is planned is what comes, unless a chunk arrives before") {
  for (const Merge merge : {Merge::replace, Merge::blend, Merge::ensemble}) {
    Timeline timeline(model(merge));
    CHECK_FALSE(timeline.planned(Time{0}));
    Draw draw(7);
    for (int i = 0; i < 20; ++i) {
      const Time now = i * 5 * kControlPeriod;
      std::vector<Velocity> actions(5);
      for (Velocity& v : actions) v = {draw(-0.5, 0.5), draw(-0.5, 0.5), draw(-1.0, 1.0)};
      timeline.add(now - 3 * kControlPeriod, actions, now);
      std::vector<Velocity> planned;
      for (int tick = 0; tick < 5; ++tick) planned.push_back(timeline.planned(now + tick * kControlPeriod).value());
      for (int tick = 0; tick < 5; ++tick) {
        check_near(timeline.next(now + tick * kControlPeriod), planned[static_cast<std::size_t>(tick)]);
      }
    }
    CHECK(timeline.planned(timeline.end().value()));
    CHECK_FALSE(timeline.planned(timeline.end().value() + kControlPeriod));
  }
}

TEST_CASE("a tick takes the action of its own time, whenever the chunk arrives") {
  const std::vector<Velocity> ramp = {{0.0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}, {0.4, 0, 0}};
  for (const Time arrived : {Time{0ms}, Time{100ms}, Time{240ms}}) {
    Timeline timeline(model(Merge::replace));
    timeline.add(Time{0}, ramp, arrived);
    CHECK(timeline.next(Time{260ms}).vx == doctest::Approx(0.26));
  }
}

TEST_CASE("a timeline that runs out brakes at the profile's deceleration to a stand-still, and never repeats itself") {
  Timeline timeline(model(Merge::blend));
  CHECK(timeline.next(Time{0}) == Velocity{});
  timeline.add(Time{0}, constant(0.5), Time{0});
  CHECK(timeline.end() == Time{400ms});
  CHECK(timeline.next(Time{400ms}).vx == 0.5);
  double before = 0.5;
  int ticks = 0;
  for (Time now{420ms}; before > 0.0; now += kControlPeriod, ++ticks) {
    const double v = timeline.next(now).vx;
    CHECK(v < before);
    CHECK(before - v <= kLimits.linear_braking * 0.02 + 1e-12);
    before = v;
  }
  CHECK(ticks == static_cast<int>(std::ceil(0.5 / (kLimits.linear_braking * 0.02) - 1e-9)));
}

TEST_CASE("jumps are counted where a chunk does not continue the one before it") {
  for (const Merge merge : {Merge::replace, Merge::blend}) {
    Timeline timeline(model(merge));
    timeline.add(Time{0}, constant(0.0), Time{0});
    timeline.next(Time{0});
    timeline.add(Time{100ms}, constant(0.5), Time{100ms});
    CHECK(timeline.counts().jumps == (merge == Merge::replace ? 1 : 0));
    timeline.next(Time{100ms});
    timeline.add(Time{120ms}, constant(0.5), Time{120ms});
    CHECK(timeline.counts().applied == 3);
    CHECK(timeline.counts().jumps == (merge == Merge::replace ? 1 : 0));
  }
}

TEST_CASE("a chunk that cannot be right is refused, and changes nothing") {
  Timeline timeline(model(Merge::blend));
  timeline.add(Time{100ms}, constant(0.2), Time{120ms});
  const policy::ChunkCounts before = timeline.counts();
  const auto refused = [&](Time measured, std::vector<Velocity> actions, const std::string& why) {
    CHECK_THROWS_WITH_AS(timeline.add(measured, actions, Time{200ms}), why.c_str(), ContractError);
  };
  std::vector<Velocity> broken = constant(0.2);
  broken[3].omega = std::numeric_limits<double>::quiet_NaN();
  refused(Time{200ms}, constant(0.2, 4), "a chunk must have 5 actions, got 4");
  refused(Time{200ms}, broken, "action 3 of a chunk is not finite");
  refused(Time{300ms}, constant(0.2), "a chunk was measured at 0.3 s, which is after now, 0.2 s");
  refused(Time{100ms}, constant(0.2), "a chunk was measured at 0.1 s, no later than the one before it, 0.1 s");
  CHECK(timeline.counts() == before);
  CHECK(timeline.next(Time{200ms}).vx == 0.2);
  CHECK_THROWS_AS(model(Merge::blend, 0.0), ContractError);
  CHECK_THROWS_AS(model(Merge::blend, std::numeric_limits<double>::quiet_NaN()), ContractError);
  CHECK_THROWS_AS(model(Merge::blend, 10.0, 1), ContractError);
}

TEST_CASE("a copy goes on as the original does") {
  Timeline timeline(model(Merge::ensemble));
  timeline.add(Time{0}, constant(0.2), Time{0});
  Timeline copy = timeline;
  for (Timeline* each : {&timeline, &copy}) each->add(Time{100ms}, constant(0.4), Time{140ms});
  for (Time now{160ms}; now < Time{800ms}; now += kControlPeriod) CHECK(timeline.next(now) == copy.next(now));
}
