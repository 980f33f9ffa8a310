// Episode clock: when things happen, counted in steps of physics since it began.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "sim/model.hpp"
#include "threewe/env/options.hpp"

namespace threewe::env {

/// What will read a scan: nothing, the gate alone, which cares for what is near, or whatever observes.
enum class ScanUse : std::uint8_t { none, gate, observed };

/// The same for all worlds of a batch.
struct Clock {
  std::uint64_t settle = 0;   ///< the robot stands for so long, until each of its sensors has delivered once
  std::uint64_t period = 0;   ///< of one control step
  std::uint64_t turn = 0;     ///< of the lidar; 0 without
  std::uint64_t latency = 0;  ///< of the lidar
  std::uint64_t stride = 1;   ///< steps between which nothing is to be noticed, at most a control period of the robot
  bool scans = false;         ///< something reads scans
  bool gate_reads = false;    ///< and the gate each of them, not just the newest at the end of a control step
  bool any_may_be = false;    ///< the newest at the end of a control step, since when they arrive is drawn

  /// What will read the scan of the turn that step number `step` (from 0) belongs to. By a table, since every step of
  /// every world asks, and to work it out takes half a dozen divisions.
  ScanUse use_of_scan(std::uint64_t step) const {
    if (!scans) return ScanUse::none;
    const std::uint64_t turns = step / turn;
    return uses[turns < uses.size() ? turns : uses.size() - cycle + (turns - uses.size()) % cycle];
  }
  /// The same without the table.
  ScanUse work_out_use(std::uint64_t step) const;
  /// Makes the table, once all else is known.
  void tabulate();

  std::vector<ScanUse> uses;  ///< of the first turns; from then on the last `cycle` of these come again and again
  std::uint64_t cycle = 1;    ///< [turns]
};

/// Whether a knob is drawn at any time.
bool draws(const models::Randomization& randomization, std::string_view knob);

Clock make_clock(const Options& options, const sim::RobotModel& robot, const task::Task& task);

}  // namespace threewe::env
