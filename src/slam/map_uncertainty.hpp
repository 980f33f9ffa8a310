// Map uncertainty model: covariance of the online map against the world, around the robot.
#pragma once

#include <vector>

#include "slam/params.hpp"
#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// What one scan has shown.
struct View {
  double unknown = 0.0;                   ///< share of its hits where the map knew nothing
  double scatter = 0.01;                  ///< [m] of its ranges
  Matrix3 information = Matrix3::Zero();  ///< that it tells about (x, y, theta), along the map's axes
};

/// Scans are fitted to what earlier ones have drawn, so that a robot comes to know its place in the map well and never
/// hears how far off the map is. What is drawn is as far off as the robot was that drew it, and a little more with each
/// scan that shows new things: the more, the less its fit says of the pose, and the noisier its ranges are. So the
/// errors of a place are those of the way by which it was first reached; who comes back has the errors that it had
/// there before. A random walk over the distance would grow for ever. What is common to all views, such as what is left
/// of the lidar's bias, stretches the map.
class MapUncertainty {
 public:
  explicit MapUncertainty(const Params::MapUncertainty& params = {}) : params_(params) {}

  /// The robot is at `position` [m] of the map.
  void update(Vec2 position, const View& view);
  /// The robot was put elsewhere: what counts is where it is next.
  void forget_way();

  /// Of (x, y, theta) of the map around the robot, along the map's axes [m^2, rad^2].
  Matrix3 covariance() const;

 private:
  /// A spot that was reached, and what had been seen by then.
  struct Place {
    Vec2 position;
    double views = 0.0;                    ///< what was new, weighted, the first view among it
    double driven = 0.0;                   ///< [m]
    Matrix3 covariance = Matrix3::Zero();  ///< of the pose there, from what each view has added
  };
  void come_back();

  Params::MapUncertainty params_;
  Vec2 origin_;  // where it saw first
  Place here_;
  double worse_ = 1.0;  // times the usual scatter is that of the newest scan
  bool began_ = false;
  bool elsewhere_ = false;
  std::vector<Place> places_;  // a metre apart
};

}  // namespace threewe::slam
