// Bodies for the tests of contact, and the scene's own exact tests of where they are: independent of the code under
// test.
#pragma once

#include <algorithm>
#include <vector>

#include "sim/contact.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim {

inline RigidBody box_body() { return {Footprint::rectangle(0.25, 0.22), 2.5, 0.0231}; }
inline RigidBody off_centre_body() {
  return {Footprint({{0.041, -0.09}, {0.041, 0.09}, {-0.11, 0.09}, {-0.11, -0.09}}), 1.0, 0.0052};
}
inline RigidBody triangle_body() { return {Footprint({{0.2, 0.0}, {-0.1, 0.15}, {-0.1, -0.15}}), 1.5, 0.02}; }
inline RigidBody octagon_body() {
  return {Footprint({{0.12, -0.05},
                     {0.12, 0.05},
                     {0.05, 0.12},
                     {-0.05, 0.12},
                     {-0.12, 0.05},
                     {-0.12, -0.05},
                     {-0.05, -0.12},
                     {0.05, -0.12}}),
          2.0, 0.015};
}

inline std::vector<Vec2> outline(const RigidBody& body, const Pose2D& pose) {
  std::vector<Vec2> corners;
  for (const Vec2 corner : body.footprint.corners()) corners.push_back(pose * corner);
  return corners;
}

/// Whether a body at `pose` overlaps one of the solids deeper than `depth` [m].
inline bool inside(const std::vector<scene::Solid>& solids, const RigidBody& body, const Pose2D& pose,
                   double depth = 1e-9) {
  return std::ranges::any_of(solids, [corners = outline(body, pose), depth](const scene::Solid& solid) {
    return scene::overlaps(solid, corners, depth);
  });
}

/// The distance [m] to the nearest solid.
inline double gap(const std::vector<scene::Solid>& solids, const RigidBody& body, const Pose2D& pose) {
  double least = 1e9;
  for (const scene::Solid& solid : solids) least = std::min(least, scene::distance_to(solid, outline(body, pose)));
  return least;
}

}  // namespace threewe::sim
