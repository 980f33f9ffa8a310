// Autonomy stack: factories of a robot's localizer and navigator, ours or others behind the same interfaces.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// Makes the autonomy stack of one robot. A factory that is empty stands for ours.
struct Autonomy {
  /// Makes a localizer for a robot.
  using LocalizerFactory =
      std::function<std::unique_ptr<slam::Localizer>(const RobotProfile& profile, const slam::InitialState& initial)>;
  /// Makes a navigator for a robot.
  using NavigatorFactory = std::function<std::unique_ptr<nav::Navigator>(const RobotProfile& profile)>;
  LocalizerFactory localizer;  ///< empty: ours, the one that `localization` names
  NavigatorFactory navigator;  ///< empty: ours
  /// The localizer's name: states of one are of no use to another. Of ours `slam`, or `truth`, see `autonomy_with`.
  std::string localization = "slam";
};

/// `slam` is our own. With `truth` the robot always knows where it is: the world makes that localizer itself, where it
/// is simulated. Throws ConfigError naming the nearest of these.
Autonomy autonomy_with(std::string_view localization);

}  // namespace threewe
