// Exact ray caster of the lidar: no grid, no marching. What each place can see is known beforehand.
#pragma once

#include <limits>
#include <memory>
#include <span>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim {

namespace kernel {
struct Sweep;
}

/// Shapes that are elsewhere at every call: people, other robots. In the frame of the slice.
struct MovingShapes {
  std::span<const scene::Segment> segments;
  std::span<const scene::Circle> circles;
};

/// Casts fans of rays into the slice it was built from. Const after that: threads may share one.
///
/// Each range is that of `scene::cast_ray` to 0.1 mm, unless the ray passes within 10 microradians of where one shape
/// ends; the bits do not depend on the machine, nor on what else is cast.
class RayCaster {
 public:
  /// Finds out what can be seen from where, up to `range_max` [m].
  RayCaster(const scene::Slice& slice, double range_max);

  double range_max() const { return range_max_; }

  /// Fills `ranges` [m], shape (N,): beam i leaves the sensor along `angle_min + i * angle_increment` [rad] in its own
  /// frame; `range_max` where nothing is hit. A negative increment turns clockwise. With `reach` [m], what stands
  /// farther away may be left out: ranges up to there are the same to the bit, and no other is below it.
  void cast(const Pose2D& sensor, double angle_min, double angle_increment, std::span<float> ranges,
            const MovingShapes& moving = {}, double reach = kEverything) const;

  /// The same for a sensor on its way: beam i leaves from `interpolate(begin, end, i / N)`, so that sweeps join without
  /// a seam when one begins where the last has ended.
  void cast_rolling(const Pose2D& begin, const Pose2D& end, double angle_min, double angle_increment,
                    std::span<float> ranges, const MovingShapes& moving = {}, double reach = kEverything) const;

  /// [m] From a point to the nearest shape, less by up to a millimetre; `most` where none is within that.
  double clearance(Vec2 point, double most) const;

  static constexpr double kEverything = std::numeric_limits<double>::infinity();

 private:
  struct Cell;
  struct Table;
  double range_max_ = 0.0;
  std::shared_ptr<const Table> table_;  // copies share it

  void cast_part(const kernel::Sweep& sweep, std::span<float> ranges, const MovingShapes& moving, double reach) const;
};

}  // namespace threewe::sim
