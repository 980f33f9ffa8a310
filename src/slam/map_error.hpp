// How far the map that a robot draws may lie off, where the robot is.
#pragma once

#include <vector>

#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// Scans are fitted to what earlier ones have drawn, so that a robot comes to know its place in the map well and never
/// hears how far off the map is. What is drawn is as far off as the robot was that drew it, and a little more with each
/// part of a scan that shows new things. So the errors of a place are those of the way by which it was first reached;
/// who comes back has the errors that it had there before. A random walk over the distance would grow for ever.
class MapError {
 public:
  MapError();

  /// The robot is at `position` [m]; of the newest scan, `unknown` is the share of hits where the map knew nothing.
  void see(Vec2 position, double unknown);
  /// Somebody has put the robot elsewhere: what counts is where it is next.
  void forget_way();

  /// Of (x, y, theta) of the map around the robot, along the map's axes [m^2, rad^2].
  Matrix3 covariance() const;

 private:
  /// A spot that was reached, and what had been seen by then.
  struct Place {
    Vec2 position;
    double views = 1.0;               ///< sum of the shares that were new, all of the first view among them
    double driven = 0.0;              ///< [m]
    Matrix3 turns = Matrix3::Zero();  ///< what a turn of 1 rad^2 for each view has made of the pose
  };
  void come_back();

  Place here_;
  bool began_ = false;
  bool elsewhere_ = false;
  std::vector<Place> places_;  // a metre apart
};

}  // namespace threewe::slam
