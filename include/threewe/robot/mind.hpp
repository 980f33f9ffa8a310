// Who thinks for a robot: our localisation and navigation, or others behind the same interfaces.
#pragma once

#include <functional>
#include <memory>

#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// Makes the mind of one robot. A factory that is empty stands for ours.
struct Mind {
  /// `map_from_start` is where the robot starts in its `map` frame.
  using LocalizerFactory =
      std::function<std::unique_ptr<slam::Localizer>(const RobotProfile& profile, const Pose2D& map_from_start)>;
  using NavigatorFactory = std::function<std::unique_ptr<nav::Navigator>(const RobotProfile& profile)>;
  LocalizerFactory localizer;
  NavigatorFactory navigator;
};

}  // namespace threewe
