// Pose-graph SLAM on its own: scans and odometry in, trajectory and occupancy grid out. `threewe slam replay` and
// `threewe.slam.Slam` are built on it; a robot that drives uses a `Localizer` instead.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {

/// What is known about the robot beforehand.
struct SlamConfig {
  Pose2D base_from_lidar{};        ///< where the lidar is mounted
  double range_max = 30.0;         ///< [m] what a scan sees farther away is left out
  double resolution = 0.05;        ///< [m] a cell of the map
  double range_bias_sigma = 0.01;  ///< [m] of the lidar's constant error
  double distance_sigma = 0.02;    ///< share by which the odometry's distances may all be wrong
  double position_drift = 0.05;    ///< [m/sqrt(m)] by which its position wanders ...
  double heading_drift = 0.15;     ///< [rad/sqrt(m)] ... and its heading
};

/// Where the robot was at some time.
struct StampedPose {
  Time stamp{};          ///< of beam 0 of its scan
  Pose2D map_from_base;  ///< as it is known now
  /// The component of the pose graph that it belongs to, 0 for the map's. Components are not related to each other by
  /// any measurement: one that is not 0 lies where the robot was last believed to be.
  int component = 0;
  friend bool operator==(const StampedPose&, const StampedPose&) = default;
};

/// A place that the robot came back to.
struct LoopClosure {
  Time earlier{};             ///< when it was there first
  Time later{};               ///< when it came back
  Pose2D earlier_from_later;  ///< where it was at the later time, seen from where it was at the earlier one
  friend bool operator==(const LoopClosure&, const LoopClosure&) = default;
};

/// What may be wrong with the input of a mapper, and what it does then.
enum class SlamIncident : std::uint8_t {
  lidar_frozen,      ///< scans repeat to the bit while odometry moves: they are left out, odometry goes on alone
  odometry_jumped,   ///< scans contradict a step of the odometry, such as a reset to zero: it is left out
  odometry_stopped,  ///< scans move while odometry does not: they go on alone, as long as they overlap a lot
  odometry_scaled,   ///< odometry drives farther or less far than scans do, by one factor: its steps are corrected
  track_lost,        ///< scans in a row fit nowhere near, as of a kidnapped robot: another component begins
  components_joined  ///< the robot was recognised in another component: the two are one from then on
};
/// Its name, such as "lidar_frozen".
std::string_view to_string(SlamIncident incident);

/// An incident, from the first scan concerned to the last.
struct SlamEvent {
  SlamIncident incident{};  ///< what was noticed
  Time begin{};             ///< of the first scan concerned
  Time end{};               ///< of the last one
  int scans = 1;            ///< concerned
  friend bool operator==(const SlamEvent&, const SlamEvent&) = default;
};

/// Simultaneous localisation and mapping from scans of any field of view, as often or as rarely as they come as long as
/// neighbours overlap, and odometry as poses. The frame `map` begins where the robot is at the first scan. Neither
/// sensor is trusted blindly: see `events`.
class Slam {
 public:
  /// Throws ContractError where a figure is out of its range.
  explicit Slam(const SlamConfig& config = {});
  ~Slam();
  /// Moves; what was moved from may only be destroyed or assigned to.
  Slam(Slam&&) noexcept;
  /// Moves.
  Slam& operator=(Slam&&) noexcept;

  /// One scan whose beam 0 was measured at `stamp`, where odometry had the robot at `odom_from_base`. Returns
  /// map_from_base. Throws ContractError, and changes nothing, when a number is out of bounds (core/bounds.hpp), when
  /// time does not go on, and when the scan has not as many ranges as the first.
  Pose2D add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base);
  /// A scan of a robot without odometry: scans alone tell how it moves, which takes that they overlap a lot.
  Pose2D add(Time stamp, const LaserScan& scan);

  /// The map: every scan that brought something new, drawn where `trajectory` has it. Only of one component of the pose
  /// graph, by default the one that the map began with; empty for one that does not exist.
  map::OccupancyGrid map(int component = 0) const;
  /// Where the robot was at each scan, as it is known now: what `add` returned may have been corrected since.
  std::vector<StampedPose> trajectory() const;
  /// The places that were recognised, by comparing scans.
  std::vector<LoopClosure> closures() const;
  /// What was wrong with the input since this Slam was made or loaded, in order of time.
  std::vector<SlamEvent> events() const;

  /// Keeps the map in a file with all that is behind it: configuration, pose graph, scans and trajectory, without
  /// losing a bit. Throws ConfigError when it cannot be written; a file that was there then stays as it was.
  void save(const std::filesystem::path& path) const;
  /// A map that was kept, to be looked at or to go on with: odometry and lidar may be others then, time goes on. The
  /// next scan is taken at `map_from_base`, half a metre and ten degrees off at most; without one, where the last was.
  /// Throws ConfigError with file:line when the file is wrong.
  static Slam load(const std::filesystem::path& path, const std::optional<Pose2D>& map_from_base = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace threewe::slam
