// Memory of a motion: what was tried, where, and with what result.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/mover.hpp"
#include "nav/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::nav {

/// What came of a place.
enum class Outcome : std::uint8_t {
  driven,     ///< the robot has been here
  closed,     ///< it looked open from afar, and was not
  failed,     ///< the robot could not go on
  excused,    ///< the same, which is held against no place: next to a mover, or at the end of a path
  tried,      ///< a bottleneck that plans lead through, until some time
  stuck,      ///< a bottleneck in which it got stuck, to be passed in creep mode
  passed,     ///< a bottleneck that it has passed
  exhausted,  ///< a bottleneck that it could not pass
  barred      ///< no plan of this motion leads here any more
};

/// All that a route has learned about places in one motion, in `map`, and who has moved around there.
class RouteMemory {
 public:
  explicit RouteMemory(const Params& params);

  /// A motion begins.
  void clear();
  void note(Outcome outcome, Vec2 place);
  /// The same, and plans avoid the place for the time being.
  void avoid(Outcome outcome, Vec2 place);
  /// A bottleneck is tried.
  void note_tried(Vec2 place, Time until);
  /// Where the robot is.
  void note_driven(Vec2 robot);
  /// It is no more what it was, in the same place.
  void forget(Outcome outcome, Vec2 place);

  std::vector<Vec2> places(Outcome outcome) const;
  bool has(Outcome outcome) const;
  /// Whether it was so in the same place.
  bool has(Outcome outcome, Vec2 place) const;
  bool failed_often(Vec2 place) const;
  /// Where it has been it can go, whatever a narrow place looks like from within.
  bool has_driven(Vec2 place) const;
  /// Until when the bottleneck in the same place is tried; nothing where it is new.
  std::optional<Time> tried_until(Vec2 place) const;

  /// Places that plans avoid, for the time being or for good.
  std::vector<Vec2> obstacles() const;
  bool avoids_any() const;
  void stop_avoiding();
  void stop_avoiding(Vec2 place);
  /// Avoids only what has failed often, until that is resumed; what is never resumed is avoided no more.
  void suspend_avoiding();
  void resume_avoiding();

  /// A peer or a moving obstacle is here.
  void note_mover(Mover mover);
  /// Where movers have been, the newest last.
  std::span<const Mover> movers() const { return movers_; }

 private:
  enum class Avoided : std::uint8_t { no, suspended, yes };
  struct Entry {
    Vec2 place;  // [m]
    Outcome outcome;
    Avoided avoided = Avoided::no;
    Time until{};
  };

  double same_place_;      // [m]
  double driven_spacing_;  // [m]
  int attempts_;
  std::vector<Entry> entries_;  // in the order in which it was learned
  std::vector<Mover> movers_;
};

}  // namespace threewe::nav
