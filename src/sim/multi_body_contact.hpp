// Multi-body contact: how robots of one world block and push one another.
#pragma once

#include <span>
#include <vector>

#include "sim/contact.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::sim {

/// One of several bodies as a step begins.
struct Mover {
  const RigidBody* body = nullptr;
  Pose2D pose;
  Velocity carried;             ///< body frame, before its own drive pushed it
  Velocity velocity;            ///< body frame, that it would move at if it were alone
  double approach_speed = 0.0;  ///< [m/s] with which its own motion met another body in this step; 0 at rest
  double mass = 1.0;            ///< factor of the body's mass and inertia
};

/// Gives each body the velocity that it leaves contact with in the next `seconds`: inelastic and frictionless impacts,
/// equal and opposite, so that momentum is kept and energy never grows. Bodies that would not touch keep their
/// velocities to the bit. No one's place in the list matters.
void exchange_momentum(std::span<Mover> movers, double seconds);

/// Which of the bodies must stay where the step began, because they would overlap where they have moved to (both of a
/// pair, and those who followed them, until none overlap). None overlaps where the step begins.
std::vector<bool> must_stay(std::span<const Mover> movers, std::span<const Pose2D> moved);

}  // namespace threewe::sim
