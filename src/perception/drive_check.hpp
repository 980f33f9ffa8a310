// Detector of wheels that do not follow their commands, or do not move the robot as they turn.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::perception {

/// Compares how the wheels turned over half a second with what was commanded. Once a control period.
class DriveCheck {
 public:
  DriveCheck() = default;
  explicit DriveCheck(const RobotProfile& profile, const Params::Drive& params = {});

  /// What was commanded before has come to an end.
  void begin() { count_ = 0; }
  /// One period: what was commanded in it, and how the wheels turn at its end. True when they do not do as
  /// commanded.
  bool is_disobeyed(const Velocity& command, const Velocity& wheels);
  /// True when the robot has been commanded to stand for some time, and must not be moving.
  bool commanded_to_stand() const;
  /// True when the robot has been commanded to drive for some time, and must be moving.
  bool commanded_to_drive() const;

 private:
  static constexpr std::size_t kWindow = 25;  // periods
  static constexpr std::size_t kMostDelay = 20;

  // Whether the wheels turned, in the sum of a window, as a window's commands say.
  bool obeys(const Velocity& commands, const Velocity& turns) const;
  static Velocity mean_of(const Velocity& sum) {
    constexpr double kShare = 1.0 / kWindow;
    return {kShare * sum.vx, kShare * sum.vy, kShare * sum.omega};
  }
  const Velocity& command(std::size_t age) const { return commands_[(count_ - 1 - age) % commands_.size()]; }
  // What can be asked: of a wheel that turns as fast as its motor may let it, no more than it does.
  Velocity attainable(const Velocity& commanded, const Velocity& done) const;

  Params::Drive params_;
  WheelGeometry base_;
  double motor_limit_ = 0.0;  // [rad/s] a wheel as fast as this may be at its motor's limit
  std::size_t delay_ = 0;     // periods, from a command to its effect by the data sheet
  std::size_t latest_ = 0;    // periods, until which an effect may come
  std::size_t count_ = 0;
  std::array<Velocity, kWindow + kMostDelay> commands_{};
  std::array<Velocity, kWindow> wheels_{};
};

/// Compares the way by the wheels with what the localiser makes of it: it knows the wheels' systematic errors, and
/// corrects what is left with each scan.
class WayCheck {
 public:
  explicit WayCheck(const Params::Slip& params = {}) : params_(params) {}
  /// One period. True when the last corrections all took back, or added, a large share of the way.
  bool is_contradicted(const slam::PoseEstimate& estimate);

 private:
  static constexpr std::size_t kCorrections = 7;

  Params::Slip params_;
  std::optional<slam::PoseEstimate> corrected_;  // when it last was
  std::size_t count_ = 0;
  std::array<double, kCorrections> shares_{};       // of the way, added by each correction
  std::array<double, kCorrections> corrections_{};  // [m] along the way
};

}  // namespace threewe::perception
