// Action timeline of a learned policy: chunks of velocities in robot time, merged, interpolated, and braked at their
// end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::policy {

/// What a new chunk does to those before it.
enum class Merge : std::uint8_t {
  replace,   ///< it alone counts from now on
  blend,     ///< it gains weight evenly from now until the chunk before it ends
  ensemble,  ///< all that cover a time are averaged, older ones weigh more (Zhao et al. 2023, ACT)
};

/// How an action timeline is read. Never changes.
struct TimelineModel {
  Limits limits;                 ///< of the robot: how it brakes, and what counts as a jump
  Duration period{};             ///< from one action of a chunk to the next
  std::size_t chunk = 0;         ///< actions of a chunk, two or more
  Merge merge = Merge::replace;  ///< what a new chunk does to those before it
};
/// Throws ContractError unless the rate [Hz] lies in [0.5, 50] and a chunk has 2 to 1,000 actions.
TimelineModel make_timeline_model(const Limits& limits, double rate, std::size_t chunk, Merge merge);

/// What became of the chunks.
struct ChunkCounts {
  int applied = 0;  ///< chunks that were merged in
  int late = 0;     ///< chunks that had ended before they arrived, and were dropped
  int jumps = 0;    ///< chunks that changed the velocity by more than a control period's acceleration
  friend bool operator==(const ChunkCounts&, const ChunkCounts&) = default;
};

/// Action `k` of a chunk belongs to `measured + k * period`, whenever it arrives, where `measured` is the robot time of
/// the picture that it was made from. So the latency of camera and inference is made up for.
class Timeline {
 public:
  /// No chunk has arrived: the robot stands.
  explicit Timeline(const TimelineModel& model);

  /// Merges a chunk in. Throws ContractError, and changes nothing, where it has another length, holds a velocity that
  /// is not finite, was measured in the future, or no later than the one before it.
  void add(Time measured, std::span<const Velocity> actions, Time now);
  /// The velocity of a control tick: interpolated, or braked from the one before where no chunk covers it.
  Velocity next(Time now);

  /// The velocity that a control tick at `t`, now or later, will have unless a chunk arrives before; none beyond the
  /// end.
  std::optional<Velocity> planned(Time t) const;

  /// When the newest chunk ends; none before the first.
  std::optional<Time> end() const;
  const ChunkCounts& counts() const { return counts_; }

 private:
  struct Chunk {
    Time measured{};
    Time applied{};
    std::vector<Velocity> actions;
  };
  Time end(const Chunk& chunk) const;
  Velocity read(const Chunk& chunk, Time t) const;
  Velocity blended(Time t) const;
  Velocity averaged(Time t) const;
  Velocity peek(Time now) const;

  TimelineModel model_;
  std::vector<Chunk> chunks_;  // oldest first; those that count no more are dropped
  Velocity last_;              // of the newest control tick
  ChunkCounts counts_;
};

}  // namespace threewe::policy
