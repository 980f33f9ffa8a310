// Log of one drive: what left the gate and where the robot truly was, and the replay of it below the gate.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scene/scene_tables.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::benchmark {

/// A drive tick by tick, from robot time 0.
struct Drive {
  std::vector<Velocity> commands;  ///< that left the gate: [m/s, m/s, rad/s] in the body frame
  std::vector<Pose2D> poses;       ///< true poses at the ends of the ticks, in the scene's frame
  double length = 0.0;             ///< [m] driven
  double collision_speed = 0.0;    ///< [m/s] of the fastest contact
  friend bool operator==(const Drive&, const Drive&) = default;
};

/// How often the body came to touch walls or furniture.
int contacts(const Drive& drive, const scene::SceneTables& tables);

/// A drive, and the truth about its robot where it has come to.
class TrueDrive {
 public:
  virtual ~TrueDrive() = default;

  const Drive& drive() const { return drive_; }
  /// Of the world as it is now.
  virtual const scene::TruthView& truth() const = 0;

 protected:
  void add(const Velocity& command);

  Drive drive_;
};

/// Logs the first robot of a simulated world at every tick, beginning anew where the world does. The world outlives it.
class DriveLog final : public TrueDrive {
 public:
  /// Throws ContractError for a robot whose true pose is not known.
  explicit DriveLog(threewe::World& world);
  ~DriveLog() override;
  DriveLog(const DriveLog&) = delete;
  DriveLog& operator=(const DriveLog&) = delete;

  /// What follows is not logged.
  void end();
  const scene::TruthView& truth() const override { return *truth_; }

 private:
  threewe::World* world_;
  const scene::TruthView* truth_;
  std::uint64_t observer_ = 0;
  Time last_{};
  bool ended_ = false;
};

/// Sends commands to the port of a fresh world, one a tick, without autonomy and gate: the same world and commands give
/// the same drive to the bit where the backend is deterministic.
class Replay final : public TrueDrive {
 public:
  /// Throws ContractError for a backend without truth, what `backend::make_world` throws, and what the port throws for
  /// a velocity that it cannot drive.
  Replay(const std::string& backend, const backend::WorldOptions& options, std::span<const Velocity> commands);

  const scene::TruthView& truth() const override;

 private:
  std::unique_ptr<backend::World> world_;
};

}  // namespace threewe::benchmark
