// One robot of a simulated world, as a runtime sees it.
#pragma once

#include <cstddef>
#include <optional>

#include "backend/mock/mock_truth.hpp"
#include "backend/simulated_port.hpp"
#include "threewe/backend/mock/mock_world.hpp"
#include "threewe/sim/camera.hpp"

namespace threewe::backend::mock {

/// A picture is made of its shot once it has arrived and is looked at.
class MockPort : public SimulatedPort<std::optional<sim::Shot>> {
 public:
  MockPort(const MockWorld& world, std::size_t index, const RobotProfile& profile);

  const scene::TruthView* truth() const override { return &truth_; }
  /// For the world: sends on what became ready in the step that it has just taken.
  void collect();

 private:
  void finish(Sample& sample, std::optional<sim::Shot>& shot) const override;
  void put(ByteWriter& bytes, const std::optional<sim::Shot>& shot) const override;
  void get(ByteReader& bytes, const Sample& sample, std::optional<sim::Shot>& shot) const override;

  const MockWorld& world_;
  std::size_t index_;
  MockTruth truth_;
};

}  // namespace threewe::backend::mock
