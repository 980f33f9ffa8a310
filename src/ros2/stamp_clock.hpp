// Stamp clock: robot time of what other clocks stamped, learned from when messages arrive.
//
// A message arrives after it was measured, by at least the least delay that its sender and the network have. The
// smallest difference of arrival and stamp over some seconds is therefore the offset between the clocks, up to that
// least delay. Streams whose offsets are about the same are taken to share a clock: the quickest of them settles it for
// all.
#pragma once

#include <optional>
#include <vector>

#include "threewe/core/time.hpp"

namespace threewe::ros2 {

/// Of one robot, whose sensors are streams with numbers from 0 on.
class StampClock {
 public:
  explicit StampClock(std::size_t streams) : streams_(streams) {}

  /// When something was measured that arrives at `arrival` [robot time], stamped `stamp` by its sender, with 0 where
  /// that has no clock; `to_measured` and `to_end` are from the stamp to that time and to the end of the measurement.
  /// Later than the one before; nothing where it was stamped no later, as one that came twice or was overtaken.
  std::optional<Time> measured(std::size_t stream, Time stamp, Duration to_measured, Duration to_end, Time arrival);
  /// A sender that was started anew may have another clock.
  void restart(std::size_t stream);
  /// What a stream's clock shows at robot time `t`, less the least delay; nothing where it has stamped none.
  std::optional<Time> stamp_at(std::size_t stream, Time t) const;

 private:
  // The smallest difference is kept of this window and of the one before, so that clocks may drift.
  static constexpr Duration kWindow = 10s;
  static constexpr Duration kSameClock = 500ms;  // no sensor of a robot is slower
  // A clock that was set back, as NTP does, makes all that comes seem late.
  static constexpr Duration kJump = 1s;       // no link delays one message by as much
  static constexpr Duration kJitter = 50ms;   // of a link; a smaller step passes for it
  static constexpr int kSurely = 3;           // messages in turn
  static constexpr Duration kHeldUp = 500ms;  // in which a link delivers what it has held up

  struct Stream {
    std::optional<Duration> least;   // in this window
    std::optional<Duration> before;  // in the one before
    Time window_end{};
    Time newest_stamp{};
    Time last_stamp{};  // of any message, in order or not
    int late = 0;       // messages in turn
    Time late_since{};
    std::optional<Time> newest;  // robot time
    std::optional<Duration> offset() const;
  };
  static void forget(Stream& stream);
  static bool was_set(Stream& stream, Time stamp, Duration difference, Time arrival);
  void begin_anew(const Stream& stream);
  static void note(Stream& stream, Duration difference, Time arrival);
  Duration offset(const Stream& stream) const;

  std::vector<Stream> streams_;
};

}  // namespace threewe::ros2
