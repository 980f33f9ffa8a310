#include "env/clock.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace threewe::env {
namespace {

constexpr std::uint64_t kTick = kControlPeriod / sim::kStep;

std::uint64_t rounded_up(std::uint64_t steps, std::uint64_t unit) { return (steps + unit - 1) / unit * unit; }

std::uint64_t steps(Duration duration) {
  return static_cast<std::uint64_t>((duration + sim::kStep - 1ns) / sim::kStep);
}

// When the last of a robot's sensors delivers for the first time.
std::uint64_t first_complete(const RobotProfile& profile) {
  Duration last = profile.odometry.period + profile.odometry.latency;
  const auto wait = [&](Duration first) { last = std::max(last, first); };
  if (profile.imu) wait(profile.imu->period + profile.imu->latency);
  if (profile.lidar) wait(profile.lidar->turn + profile.lidar->latency);
  if (profile.ultrasonics) wait(profile.ultrasonics->period() + profile.ultrasonics->latency);
  if (profile.camera) wait(steps(profile.camera->period) * sim::kStep + profile.camera->latency);
  return rounded_up(steps(last), kTick);
}

}  // namespace

bool draws(const models::Randomization& randomization, std::string_view knob) {
  const auto is_it = [&](const models::RandomizedKnob& drawn) { return models::knob_names()[drawn.knob] == knob; };
  return std::ranges::any_of(randomization.startup, is_it) || std::ranges::any_of(randomization.reset, is_it) ||
         std::ranges::any_of(randomization.interval, is_it);
}

Clock make_clock(const Options& options, const sim::RobotModel& robot, const task::Task& task) {
  Clock clock;
  clock.settle = first_complete(options.hardware);
  clock.period = steps(options.control_period);
  clock.turn = static_cast<std::uint64_t>(robot.turn);
  if (options.hardware.lidar) clock.latency = steps(options.hardware.lidar->latency);
  const bool pictures = options.observed.image || options.observed.depth;
  if (!pictures && clock.turn % kTick == 0) clock.stride = kTick;
  clock.scans = options.hardware.lidar && (options.gate == Gate::full || options.observed.lidar || task.reads_scan());
  clock.gate_reads = options.gate == Gate::full;
  clock.any_may_be = draws(options.randomization, "sensor_latency");
  if (clock.scans) clock.tabulate();
  return clock;
}

// After the robot has stood, all that counts comes again when turns and control steps end at once.
void Clock::tabulate() {
  cycle = std::lcm(turn, std::lcm(kTick, period)) / turn;
  uses.clear();
  const std::uint64_t turns = settle / turn + 1 + cycle;
  for (std::uint64_t i = 0; i < turns; ++i) uses.push_back(work_out_use(i * turn));
}

ScanUse Clock::work_out_use(std::uint64_t step) const {
  const std::uint64_t turns = step / turn;
  const std::uint64_t arrives = rounded_up((turns + 1) * turn + latency, kTick);
  const std::uint64_t outdated = rounded_up((turns + 2) * turn + latency, kTick);
  // the first moments that are not before at which something observes, and at which the gate looks
  const std::uint64_t observation = arrives > settle ? settle + rounded_up(arrives - settle, period) : settle;
  const std::uint64_t look = std::max(arrives, settle);
  if (observation < outdated || (any_may_be && look < outdated)) return ScanUse::observed;
  return gate_reads && look < outdated ? ScanUse::gate : ScanUse::none;
}

}  // namespace threewe::env
