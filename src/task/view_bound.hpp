// Conservative view test: whether any of some objects may be in view.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "camera_frame.hpp"
#include "task/sight.hpp"
#include "threewe/core/camera.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::task {

/// Objects as boxes around all of each, and what can hide one entirely: walls and furniture that stand on the floor,
/// are no lower than the object and the eye, and do not reach into its box. Low furniture hides nothing.
class ViewBound {
 public:
  /// `objects` are indices into the scene's, `solids` all of its solids.
  ViewBound(const scene::Scene& scene, std::span<const scene::Solid> solids, std::span<const int> objects,
            double eye_height);

  /// Whether more than `pixels` of one of them may be seen.
  bool may_see(const CameraIntrinsics& camera, const Eye& eye, double pixels) const;

 private:
  struct Bounded {
    Polygon outline;
    Vec2 center;
    double radius = 0.0;  // [m] of a circle around it
    double z_min = 0.0;   // [m]
    double z_max = 0.0;   // [m]
    std::vector<std::size_t> hiding;
  };
  class View;

  std::vector<Bounded> objects_;
  std::vector<Polygon> tall_;
};

}  // namespace threewe::task
