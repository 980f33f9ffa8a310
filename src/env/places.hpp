// Simulation-ready scenes of a batch.
#pragma once

#include <memory>
#include <vector>

#include "sim/model.hpp"
#include "threewe/env/options.hpp"

namespace threewe::env {

/// What is made of each scene; const and shared by all worlds.
struct Places {
  task::Scenes tables;
  std::vector<std::shared_ptr<const sim::Model>> models;
};

/// Throws ConfigError where a robot can't stand at a scene's start, or can't be simulated.
Places make_places(const Options& options);

}  // namespace threewe::env
