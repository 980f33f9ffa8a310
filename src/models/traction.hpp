// Traction model of wheels that spin freely once they slip: what a profile's measured `traction` makes of its drive.
//
// `drive.hpp` alone takes wheels for flywheels: they follow their motors, and the body follows them as well as it can.
// Light wheels do neither. While they hold, wheels and body are one mass that the speed loops push; once a wheel slips
// it is fast at once, and pushes with its friction until the body has caught up. What a wheel bears is not always the
// same:
//  - of a body that speeds up, the wheels behind bear more, and a caster takes from driven wheels what they lose;
//  - four wheels on a rigid floor may stand on either diagonal pair. Rollers shake those up that spin, so these bear
//  more.
#pragma once

#include <array>

#include "models/drive.hpp"

namespace threewe::models {

/// What `traction` says, worked out beforehand. V is double, or a vector of doubles: one robot's in each lane.
template <class V>
struct TractionModelOf {
  V present;  ///< 1, or 0 where nothing was measured

  // the share of a commanded velocity that the body reaches
  V ahead;
  V sideways;
  V turning;

  V turn_inertia;     ///< of the body about the wheels' arm, over its mass
  V hold;             ///< the share of its friction with which a wheel pushes ahead
  V load;             ///< of the weight, on driven wheels
  V shift;            ///< of a wheel's load, at most, to the diagonal pair that slips
  V per_shift_speed;  ///< [s/m]
  V pitch;            ///< [s/m] of a front wheel's load, lost for each m/s that the body gains ahead in a step
  V rear_pitch;       ///< [s/m] the same of a rear wheel's
  V roll;             ///< [s/m] of a left wheel's load, lost for each m/s that the body gains to the left
  V wheel_share;      ///< 1 over the number of wheels
  V unused_a;         ///< rows of four
  V unused_b;
  V unused_c;
};

using TractionModel = TractionModelOf<double>;

TractionModel make_traction_model(const RobotProfile& profile, Duration step);

/// What became of body and wheels in one step.
struct TractionStep {
  Velocity body;       ///< in the body frame
  WheelSpeeds wheels;  ///< [rad/s]
};

/// One step of a drive whose profile has a `traction`, from the body's velocity `body` towards `command`. `lateral` is
/// of the episode's wheels; `supply`, `shares` and `floor` are as for `drive_motors` and `limit_by_friction`.
TractionStep apply_traction(const Drive& drive, const TractionModel& traction_model, const Traction& traction,
                            const Velocity& body, const Velocity& command, double lateral = 1.0, double supply = 1.0,
                            double floor = 1.0, const std::array<double, 4>& shares = {1.0, 1.0, 1.0, 1.0});

}  // namespace threewe::models
