// Rigid-body contact in the plane: a convex body stops at obstacles and slides along them, and never passes into one.
#pragma once

#include "sim/ray_caster.hpp"
#include "sim/shape_index.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim {

/// A body that slides over the floor.
struct RigidBody {
  Footprint footprint;
  double mass = 0.0;     ///< [kg]
  double inertia = 0.0;  ///< [kg m^2]
};

/// What one step of motion came to.
struct Motion {
  Pose2D pose;
  Velocity velocity;            ///< body frame, after contact
  bool touching = false;        ///< something held it back in this step
  double approach_speed = 0.0;  ///< [m/s] at which the body met what held it back; 0 while it rests against it
};

/// How far from the base a shape can matter in one step [m]: what `ShapeIndex` needs for this body.
double contact_reach(const Footprint& footprint, double max_speed, double max_turn_rate, double seconds);

/// Moves a body for `seconds` at `velocity` (body frame) from a pose that is free.
///
/// `carried` is its velocity before its own drive pushed it in this step, which is what it meets an obstacle with: so a
/// robot that leans against a wall does not hit it again at every step. `others` are more shapes, such as people.
/// Contact is inelastic and without friction; it never adds energy. The new pose is free.
Motion move(const RigidBody& body, const ShapeIndex& obstacles, const MovingShapes& others, const Pose2D& pose,
            const Velocity& velocity, const Velocity& carried, double seconds);
/// The same for those who know where `integrate` leads: to `free_end`.
Motion move(const RigidBody& body, const ShapeIndex& obstacles, const MovingShapes& others, const Pose2D& pose,
            const Velocity& velocity, const Velocity& carried, double seconds, const Pose2D& free_end);

}  // namespace threewe::sim
