// Real-time pacer: keeps a lockstep world in step with the wall clock.
#pragma once

#include <chrono>
#include <optional>
#include <thread>

#include "threewe/core/time.hpp"

namespace threewe {

/// Ties robot time to the wall clock while ticks follow each other, and anew after a pause.
class RealTimePacer {
 public:
  using Clock = std::chrono::steady_clock;

  /// [wall] until the tick that begins at robot time `now` is due; zero when late.
  Duration due(Time now) const {
    if (!anchor_) return Duration::zero();
    return std::max(Duration::zero(), std::chrono::duration_cast<Duration>(lead(now)));
  }
  /// Sleeps until it is due. After a pause (no caller waited, a hold, a slow computer) time goes on from here.
  void wait(Time now) {
    std::this_thread::sleep_for(due(now));
    if (!anchor_ || lead(now) < -kForgiven) anchor_ = Anchor{Clock::now(), now};
  }
  void forget() { anchor_.reset(); }

 private:
  static constexpr Duration kForgiven = 100ms;  // lateness that is caught up with
  struct Anchor {
    Clock::time_point wall;
    Time robot{};
  };
  Clock::duration lead(Time now) const { return anchor_->wall + (now - anchor_->robot) - Clock::now(); }
  std::optional<Anchor> anchor_;
};

}  // namespace threewe
