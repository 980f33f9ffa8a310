// Ground-truth localizer, for experiments in a simulated world.
#pragma once

#include <memory>

#include "threewe/hardware/profile.hpp"
#include "threewe/scene/truth_view.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// For experiments in a simulated world, made by the holder of its truth service. `odom` lies where the robot started,
/// and never drifts; the map is drawn by scans at their true poses. Throws ContractError for a given map where it is
/// unknown where the robot starts in it.
std::unique_ptr<slam::Localizer> make_truth_localizer(const RobotProfile& profile, const slam::InitialState& initial,
                                                      const scene::TruthView& truth);
/// Lets such a localizer, restored from the state of another world, know the truth of this one. Does nothing to others.
void set_truth(slam::Localizer& localizer, const scene::TruthView& truth);

}  // namespace threewe
