// The embedded simulator as a backend: lockstep, deterministic, saved and restored.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/models/randomization.hpp"
#include "threewe/sim/model.hpp"
#include "threewe/sim/people.hpp"
#include "threewe/sim/state.hpp"

namespace threewe::backend::mock {

class MockPort;

/// A simulated scene with one robot or more.
class MockWorld : public World {
 public:
  /// Throws ConfigError for an unknown scene or profile, one that cannot be simulated, or a start inside an obstacle.
  explicit MockWorld(const WorldOptions& options);
  ~MockWorld() override;

  std::size_t robot_count() const override;
  RobotPort& robot(std::size_t index) override;
  Time now() const override { return now_; }
  /// Physics advances in steps of `sim::kStep`; between two of them only the clock moves.
  void advance_to(Time t) override;
  void reset(const ResetOptions& options) override;
  void carry(std::size_t robot, const Pose2D& pose) override;
  /// Connections are not part of what is saved. A saved world fits any other made of the same options.
  std::vector<std::byte> save() const override;
  void restore(const std::vector<std::byte>& state) override;

 private:
  friend class MockPort;

  void begin(const ResetOptions& options);
  void step();
  void vary();
  std::vector<Pose2D> start_poses(const std::vector<Pose2D>& asked) const;
  void require_free(std::size_t robot, const Pose2D& pose, const std::string& name,
                    std::span<const Pose2D> others) const;

  std::shared_ptr<const sim::Model> model_;
  NoiseLevel noise_{};
  models::Randomization randomization_;
  Time now_{};
  std::uint64_t steps_ = 0;
  std::uint64_t draws_ = 0;  // of what changes in the middle of an episode ...
  Time next_draw_{};         // ... and when it does again, if at all
  std::vector<sim::RobotState> states_;
  std::vector<sim::PersonState> people_;
  std::vector<Velocity> commands_;  // of each robot, in the step to come
  std::vector<std::unique_ptr<MockPort>> ports_;
};

}  // namespace threewe::backend::mock
