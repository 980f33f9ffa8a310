// Lockstep simulated world on any engine: a scene with robots and people, their sensors, and its saved state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/simulated/engine.hpp"
#include "sim/model.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::backend::simulated {

class Port;
class Truth;

/// A simulated scene with one robot or more.
class SimulatedWorld : public World, private TruthService {
 public:
  using EngineFactory = std::function<std::unique_ptr<Engine>(std::shared_ptr<const sim::Model>)>;

  /// `format` names what is saved: of a simulator, in a version of it. Throws ConfigError for an unknown scene or
  /// profile, one that cannot be simulated, or a start inside an obstacle.
  SimulatedWorld(const WorldOptions& options, std::string format, const EngineFactory& make_engine);
  SimulatedWorld(const SimulatedWorld&) = delete;
  SimulatedWorld& operator=(const SimulatedWorld&) = delete;
  ~SimulatedWorld() override;

  std::size_t robot_count() const override;
  RobotPort& robot(std::size_t index) override;
  const TruthService* truth_service() const override { return this; }
  Time now() const override { return now_; }
  /// Physics advances in steps of `sim::kStep`; between two of them only the clock moves.
  void advance_to(Time t) override;
  void reset(const ResetOptions& options) override;
  void teleport(std::size_t robot, const Pose2D& pose) override;
  /// Connections are not part of what is saved. A saved world fits any other made of the same options.
  std::vector<std::byte> save() const override;
  void restore(const std::vector<std::byte>& state) override;

 private:
  friend class Port;
  friend class Truth;

  const scene::TruthView& truth(std::size_t index) const override;
  void begin(const ResetOptions& options);
  void step();
  void vary();
  std::vector<Pose2D> start_poses(const std::vector<Pose2D>& asked) const;
  void require_free(std::size_t robot, const Pose2D& pose, const std::string& name,
                    std::span<const Pose2D> others) const;
  WorldCapture capture(std::size_t robot) const;

  std::string format_;
  NoiseLevel noise_{};
  models::Randomization randomization_;
  std::shared_ptr<const sim::Model> model_;
  std::unique_ptr<Engine> engine_;
  Time now_{};
  std::uint64_t steps_ = 0;
  std::uint64_t draws_ = 0;  // of what changes in the middle of an episode ...
  Time next_draw_{};         // ... and when it does again, if at all
  std::vector<sim::RobotState> states_;
  std::vector<sim::PersonState> people_;
  std::vector<Velocity> commands_;  // of each robot, in the step to come
  std::vector<std::unique_ptr<Port>> ports_;
  std::vector<std::unique_ptr<Truth>> truths_;
};

}  // namespace threewe::backend::simulated
