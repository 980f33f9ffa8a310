// The embedded simulator as a backend: lockstep, deterministic, saved and restored.
#pragma once

#include "backend/simulated/simulated_world.hpp"

namespace threewe::backend::mock {

/// A simulated scene with one robot or more.
class MockWorld : public simulated::SimulatedWorld {
 public:
  explicit MockWorld(const WorldOptions& options);
};

}  // namespace threewe::backend::mock
