// Autonomy stack: factories of a robot's localizer and navigator, ours or others behind the same interfaces.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/scene/truth_view.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// Makes the autonomy stack of one robot. A factory that is empty stands for ours.
struct Autonomy {
  /// `truth` is null on a real robot; ours never sees it.
  using LocalizerFactory = std::function<std::unique_ptr<slam::Localizer>(
      const RobotProfile& profile, const slam::InitialState& initial, const scene::TruthView* truth)>;
  /// Makes a navigator for a robot.
  using NavigatorFactory = std::function<std::unique_ptr<nav::Navigator>(const RobotProfile& profile)>;
  LocalizerFactory localizer;         ///< empty: ours
  NavigatorFactory navigator;         ///< empty: ours
  std::string localization = "slam";  ///< its name: states of one are of no use to another
};

/// `slam` is our own. With `truth` the robot always knows where it is, as it can in simulated worlds alone, see
/// `make_truth_localizer`. Throws ConfigError naming the nearest of these.
Autonomy autonomy_with(std::string_view localization);

}  // namespace threewe
