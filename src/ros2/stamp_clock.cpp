#include "ros2/stamp_clock.hpp"

#include <algorithm>
#include <utility>

namespace threewe::ros2 {

std::optional<Time> StampClock::measured(std::size_t index, Time stamp, Duration to_measured, Duration to_end,
                                         Time arrival) {
  Stream& stream = streams_[index];
  Time measured = arrival - (to_end - to_measured);
  if (stamp != Time::zero()) {
    if (stream.newest && stamp <= stream.newest_stamp) {
      if (stamp > stream.newest_stamp - kJump) return std::nullopt;
      forget(stream);
    }
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

void StampClock::restart(std::size_t stream) {
  forget(streams_[stream]);
  streams_[stream].newest_stamp = Time::min();
}

void StampClock::forget(Stream& stream) { stream.least = stream.before = std::nullopt; }

void StampClock::note(Stream& stream, Duration difference, Time arrival) {
  if (stream.least && difference - *stream.least > kJump) forget(stream);
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
