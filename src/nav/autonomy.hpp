// Factories of our localizer and navigator from a robot profile. They stand here because `slam` knows no profiles.
#pragma once

#include <memory>

#include "slam/params.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::slam {

/// The parameters of localization for a robot; its map's resolution is rounded, see `rounded_resolution`.
SharedParams params_for(const RobotProfile& profile);

/// Localisation and mapping by lidar, gyro and wheels; by wheels and gyro alone where there is no lidar.
std::unique_ptr<Localizer> make_localizer(const RobotProfile& profile, const InitialState& initial = {});

}  // namespace threewe::slam

namespace threewe::nav {

/// Planning and control for the profile's kinematics, footprint and operating limits.
std::unique_ptr<Navigator> make_navigator(const RobotProfile& profile);

}  // namespace threewe::nav
