// Local map: what was seen on the last metres, for scans of a log to be matched with.
#pragma once

#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/front_end.hpp"

namespace threewe::slam {

/// Two maps that overlap: the older is matched with, and gives way to the younger after some metres. A caller that
/// closes loops finds what was mapped before that in the scans that the keyframe graph keeps.
class LocalMap {
 public:
  explicit LocalMap(SharedParams params = reference_params()) : params_(std::move(params)) {}

  /// Takes the newest scan if it is due, seen where the front end has the robot.
  void extend(FrontEnd& front);
  void clear() { pieces_.clear(); }
  /// Null where nothing has been mapped.
  const map::LogOddsMap* map() const { return pieces_.empty() ? nullptr : &pieces_.front().map; }

 private:
  struct Piece {
    map::LogOddsMap map;
    double begun = 0.0;  // [m] driven until it was
  };

  SharedParams params_;
  std::vector<Piece> pieces_;  // the older first
  double driven_ = 0.0;        // [m] between the scans that were taken
  Pose2D last_;                // map_from_base
};

}  // namespace threewe::slam
