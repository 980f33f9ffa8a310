#include "ros2/stamp_clock.hpp"

#include <algorithm>
#include <utility>

namespace threewe::ros2 {

std::optional<Time> StampClock::measured(std::size_t index, Time stamp, Duration to_measured, Duration to_end,
                                         Time arrival) {
  Stream& stream = streams_[index];
  Time measured = arrival - (to_end - to_measured);
  if (stamp != Time::zero()) {
    if (was_set(stream, stamp, arrival - (stamp + to_end), arrival)) begin_anew(stream);
    if (stream.newest && stamp <= stream.newest_stamp) return std::nullopt;
    stream.newest_stamp = stamp;
    note(stream, arrival - (stamp + to_end), arrival);
    measured = stamp + to_measured + offset(stream);
  }
  // offsets shrink as they are learned: time does not go back for that
  if (stream.newest) measured = std::max(measured, *stream.newest + Time(1));
  if (measured > arrival || measured < Time::zero()) return std::nullopt;  // before robot time began
  stream.newest = measured;
  return measured;
}

void StampClock::restart(std::size_t stream) { forget(streams_[stream]); }

std::optional<Time> StampClock::stamp_at(std::size_t stream, Time t) const {
  if (!streams_[stream].offset()) return std::nullopt;
  return t - offset(streams_[stream]);
}

void StampClock::forget(Stream& stream) {
  stream.least = stream.before = std::nullopt;
  stream.newest_stamp = Time::min();
  stream.late = 0;
}

/// Whether the sender's clock was set back. Its messages then seem to be late, in an order of their own: all of them,
/// and not those of one burst alone that a link has held up.
bool StampClock::was_set(Stream& stream, Time stamp, Duration difference, Time arrival) {
  const bool rises = stamp > std::exchange(stream.last_stamp, stamp);
  const auto offset = stream.offset();
  if (!offset || difference - *offset <= kJitter) {
    stream.late = 0;
    return false;
  }
  const bool repeated = stamp <= stream.newest_stamp && stamp > stream.newest_stamp - kJump;
  if (difference - *offset > kJump && !repeated) return true;
  if (stream.late == 0 || !rises) {
    stream.late = 0;
    stream.late_since = arrival;
  }
  return ++stream.late >= kSurely && (stamp <= stream.newest_stamp || arrival - stream.late_since >= kHeldUp);
}

/// The clock of this stream, and of all that share it.
void StampClock::begin_anew(const Stream& stream) {
  const Duration was = *stream.offset();
  for (Stream& other : streams_) {
    const auto theirs = other.offset();
    if (theirs && std::chrono::abs(*theirs - was) < kSameClock) forget(other);
  }
}

void StampClock::note(Stream& stream, Duration difference, Time arrival) {
  if (arrival >= stream.window_end) {
    stream.before = std::exchange(stream.least, std::nullopt);
    stream.window_end = arrival + kWindow;
  }
  stream.least = std::min(stream.least.value_or(difference), difference);
}

std::optional<Duration> StampClock::Stream::offset() const {
  if (!least) return before;
  return before ? std::min(*least, *before) : least;
}

Duration StampClock::offset(const Stream& stream) const {
  const Duration own = *stream.offset();
  Duration best = own;
  for (const Stream& other : streams_) {
    const auto theirs = other.offset();
    if (theirs && *theirs < best && own - *theirs < kSameClock) best = *theirs;
  }
  return best;
}

}  // namespace threewe::ros2
