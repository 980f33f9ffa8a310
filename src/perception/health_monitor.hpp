// Sensor health monitor: which sensors may be believed.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/blind_check.hpp"
#include "perception/drive_check.hpp"
#include "perception/params.hpp"
#include "perception/repeat_check.hpp"
#include "perception/scan_check.hpp"
#include "perception/stamp_check.hpp"
#include "perception/turn_check.hpp"
#include "threewe/perception/percepts.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::perception {

/// Each sample is examined before it is used, and each period what sensors say is compared. A sensor in trouble is
/// not believed until it has been sound for a while; one that the robot cannot do without keeps it from moving. Plain
/// data.
class HealthMonitor {
 public:
  HealthMonitor(std::span<const SensorInfo> sensors, const RobotProfile& profile, const Params& params);

  /// The robot was connected: what was known of arrivals is of no use any more.
  void begin(Time now);
  /// One sample, in order of arrival. True when it may be used.
  bool examine(const Sample& sample, std::span<const SensorInfo> sensors, const RobotProfile& profile);
  /// The end of a period in which `command` was sent.
  void judge(Time now, const Velocity& command, const slam::PoseEstimate& estimate);

  const std::vector<SensorHealth>& sensors() const { return sensors_; }
  /// The first sensor in trouble that the robot cannot do without; null while it may move.
  const SensorHealth* blocking_sensor() const;
  /// Places of the sensors whose trouble has begun or ended since the last call.
  std::vector<std::size_t> take_changes();

 private:
  struct Watch {
    SensorType type{};
    Duration patience{};  // for the next sample
    StampCheck stamps{};
    RepeatCheck repeats{};
    std::optional<Time> received{};
    bool believed = true;  // what it delivers is used all the same
    Time until{};          // when the trouble is over, unless something else is noticed
    Duration penalty{};    // how long the last contradiction was waited for
    Time ended{};
  };
  struct Finding {
    SensorFault fault = SensorFault::none;
    std::string detail{};
  };
  Finding check(Watch& watch, const Sample& sample);
  Finding check_scan(Time measured, const LaserScan& scan);
  void report(std::size_t sensor, SensorFault fault, const std::string& detail, Duration hold, bool believed = false);
  void contradict(SensorType type, const std::string& detail, bool believed);
  void watch_silence(std::size_t sensor);
  Motion motion() const;

  Params::Monitor params_;
  StampCheck new_stamps_;
  RepeatCheck new_repeats_;
  std::vector<SensorHealth> sensors_;
  std::vector<Watch> watches_;
  std::vector<std::size_t> changes_;
  Time begun_{};
  Time now_{};
  ScanCheck scan_;
  BlindCheck blind_;
  TurnCheck turn_;
  DriveCheck drive_;
  WayCheck way_;
  double lidar_heading_ = 0.0;      // [rad] in the base frame
  std::optional<double> turn_off_;  // the newest innovation, until it is judged
  std::optional<Odometry> wheels_;
  double gyro_rate_ = 0.0;  // [rad/s]
};

}  // namespace threewe::perception
