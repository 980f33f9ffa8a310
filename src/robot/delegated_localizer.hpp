// Localizer that takes pose and map from another program on the robot, such as SLAM Toolbox or AMCL.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "backend/delegation.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/perception/percepts.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// Of the program of that name. `odom` is that of the robot's odometry. It is lost once nothing has come from the
/// program for a second. Where the program states no covariance, a wide one is assumed.
std::unique_ptr<slam::Localizer> make_delegated_localizer(const RobotProfile& profile, std::string program,
                                                          const backend::ExternalLocalizer& source);
/// How the program is, by its name, of such a localizer; empty of others.
std::optional<perception::SensorHealth> program_health(const slam::Localizer& localizer, Time now);
/// Up to when both the odometry and the program have said where the robot is, of such a localizer; empty of others.
std::optional<Time> known_until(const slam::Localizer& localizer);

}  // namespace threewe
