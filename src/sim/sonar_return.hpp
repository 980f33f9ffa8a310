// Sonar model, exact: the nearest surface in the cone that reflects a return.
#pragma once

#include "sim/ray_caster.hpp"
#include "sim/shape_index.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::sim {

/// The sound that leaves a sensor, in the frame of the slice.
struct SonarCone {
  Pose2D sensor;               ///< the cone opens along its x axis
  double field_of_view = 0.0;  ///< [rad] from edge to edge, below pi
  double max_incidence = 0.0;  ///< [rad] off a surface's normal, below pi/2: beyond it the sound glances off
  double range_max = 0.0;      ///< [m]
};

struct SonarReturn {
  double range = 0.0;    ///< [m]; the cone's range_max where nothing is heard
  double bearing = 0.0;  ///< tangent of the angle off the cone's axis at which it comes back; 0 where nothing is heard
};

/// The nearest point of a surface that sound from the sensor reaches in a straight line, past everything in front of
/// it, and meets within `max_incidence` of the normal. What glances off still hides what stands behind it.
///
/// Surfaces are those of `scene::cast_ray`: seen from outside alone. Sound that comes back by way of two surfaces, as
/// out of a corner, is not modelled. `standing` must tell what lies within the cone's `range_max`.
SonarReturn nearest_sonar_return(const SonarCone& cone, const ShapeIndex& standing, const MovingShapes& moving = {});

}  // namespace threewe::sim
