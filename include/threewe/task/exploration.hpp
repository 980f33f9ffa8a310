// Exploration: see as much of a place as possible.
#pragma once

#include <memory>

#include "threewe/task/task.hpp"

namespace threewe::task {

struct ExplorationOptions {
  double enough = 0.95;  ///< the share of the place that ends an episode in success
};

/// `3we/Exploration-v1`. Covered is what noise-free rays from the lidar's true place have crossed within 8 m, as
/// `scene::CoverageMeter` has it: the share C of all reachable 5 cm cells, of area A [m^2] together. All robots of a
/// world cover for all of them, and all of them get
///
///   reward = 0.2 A (C(now) - C(before)) - 0.01 + 10 [C >= enough] - 0.1 [new contact],
///
/// the first part being potential-based; a contact counts when a robot meets an obstacle faster than it has before, and
/// faster than 0.05 m/s. An episode ends in success when enough is covered.
///
/// Field `coverage_map` (64, 64, 1), an image of one channel: what the robots of the world have seen so far, by their
/// own scans and beliefs: 0 unknown, 127 free, 255 occupied, in cells of 0.25 m. Rows go along the map's y axis,
/// columns along x; the robot is at the corner between cells (31, 31) and (32, 32). Metrics: `success`, `coverage`,
/// both of all robots together, `path_length` [m] and `collision_speed` [m/s] of the fastest contact.
std::unique_ptr<Task> make_exploration(const Setting& setting, const ExplorationOptions& options = {});

}  // namespace threewe::task
