// Test bench of the conformance checks: a fresh world, a robot to drive, and all that it delivered.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "threewe/backend/conformance.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::conformance {

/// Thrown by a check that found the contract broken.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Thrown by a check whose feature the backend does not claim.
struct NotApplicable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Ends the check as failed, with a formatted detail, unless `condition` holds.
template <typename... Args>
void expect(bool condition, fmt::format_string<Args...> detail, Args&&... args) {
  if (!condition) throw Failure(fmt::format(detail, std::forward<Args>(args)...));
}

/// Ends the check as not applicable unless `claimed`.
inline void applies_if(bool claimed, const char* why_not) {
  if (!claimed) throw NotApplicable(why_not);
}

/// Fails unless `action` throws an `Error`; `what` names the action in the detail.
template <typename Error, typename Action>
void expect_throws(Action&& action, const char* what, const char* error) {
  try {
    action();
  } catch (const Error&) {
    return;
  } catch (const std::exception& other) {
    throw Failure(fmt::format("{} must throw {}, but threw: {}", what, error, other.what()));
  }
  throw Failure(fmt::format("{} must throw {}, but did not", what, error));
}

/// A fresh world and its first robot. Collects every sample that it polls.
class Bench {
 public:
  explicit Bench(std::unique_ptr<World> world);

  World& world() { return *world_; }
  RobotPort& port() { return world_->robot(0); }
  /// The truth about the robot; null where the world is not simulated.
  const scene::TruthView* truth() {
    const TruthService* service = world_->truth_service();
    return service == nullptr ? nullptr : &service->truth(0);
  }
  const Features& features() { return port().features(); }
  const RobotProfile& profile() { return port().profile(); }
  Time now() { return world_->now(); }

  /// Drives for `duration` as a healthy runtime does: every control period a command valid for 200 ms, then a poll.
  void drive(const Velocity& velocity, Duration duration);
  /// Drives, then stands until the robot has come to rest.
  void drive_and_stop(const Velocity& velocity, Duration duration);
  /// Lets time pass without a command, polling every control period.
  void wait(Duration duration);
  /// Advances to `t`, and fails unless that is where the clock then stands, or later.
  void advance(Time t);
  void poll();

  /// Everything polled since the start or the last `forget`, in the order in which it was handed over.
  const std::vector<Sample>& samples() const { return samples_; }
  void forget() { samples_.clear(); }
  std::vector<Sample> of(SensorType type);
  std::vector<Sample> of_sensor(std::size_t sensor) const;
  bool has(SensorType type);
  /// The newest odometry. Stands for up to a second until the first one has arrived, and fails when none has.
  Odometry odometry();
  /// A scan whose every beam was measured from now on.
  LaserScan next_scan();

  /// Fails, since no sample of a kind has arrived that was measured from `begin` on.
  [[noreturn]] void fail_without_new(SensorType type, Time begin);

  /// A speed to drive at [m/s] and one to turn at [rad/s], within what the robot is asked to do by default.
  double cruise();
  double turning();

 private:
  std::unique_ptr<World> world_;
  std::vector<Sample> samples_;
};

/// How a check makes its worlds.
struct Context {
  const WorldFactory& make;
  const WorldOptions& options;
  const Surroundings& surroundings;

  Bench fresh() const { return Bench(make(options)); }
  Bench connected() const;
  Bench connected(std::uint64_t seed) const;
};

/// One check: a function that throws Failure or NotApplicable, or returns.
struct Check {
  const char* name;
  void (*run)(const Context&);
};

/// Whether beam `i` hit something: it is neither invalid nor without a return.
bool hits_something(const LaserScan& scan, std::size_t i);
/// Where beam `i` ends, in the lidar's frame.
Vec2 point_of(const LaserScan& scan, std::size_t i);
/// Where the beams hit something, in the base frame.
std::vector<Vec2> hits(const LaserScan& scan, const Pose2D& base_from_lidar);

/// How badly `after`, moved by `before_from_after`, fits `before`: the mean distance of its points to the nearest one
/// [m], each counted as at most 0.3 m so that what came into view does not matter much.
double misfit(const std::vector<Vec2>& before, const std::vector<Vec2>& after, const Pose2D& before_from_after);

// The checks, one table per subject.
std::span<const Check> connection_checks();
std::span<const Check> time_checks();
std::span<const Check> sample_checks();
std::span<const Check> delay_checks();
std::span<const Check> lidar_checks();
std::span<const Check> mount_checks();
std::span<const Check> ultrasonic_checks();
std::span<const Check> camera_checks();
std::span<const Check> scenery_checks();
std::span<const Check> motion_checks();
std::span<const Check> command_checks();
std::span<const Check> repeat_checks();
std::span<const Check> truth_checks();
std::span<const Check> place_checks();

}  // namespace threewe::backend::conformance
