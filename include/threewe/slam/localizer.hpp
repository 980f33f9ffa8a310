// Localizer interface: pose estimate and map of one robot from its samples. The runtime knows this interface alone, so
// that an external localization can stand in for ours.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {
class ChangeLog;
}

namespace threewe::slam {

/// What is known of the robot's place before its first sample.
struct InitialState {
  std::shared_ptr<const map::OccupancyGrid> map;  ///< to be localised in; null: it draws its own
  /// Where it starts in `map`. Empty: at the origin of its own map, anywhere in a given one.
  std::optional<Pose2D> map_from_start;
};

/// How far a localizer knows where the robot is.
enum class LocalizationState : std::uint8_t {
  tracking,    ///< scans fit the map where the robot is estimated to be
  doubting,    ///< they fit, but a prior map has long been contradicted: the whole map is searched meanwhile
  lost,        ///< they do not fit: the pose is where the robot was last believed to be; the whole map is searched
  relocating,  ///< the search found one pose; the next scans decide whether it is right
};
/// Its name, such as "tracking".
std::string_view to_string(LocalizationState state);

/// What is known about the robot's pose at one time.
struct PoseEstimate {
  Time stamp{};                                           ///< of the estimate
  Pose2D odom_from_base;                                  ///< smooth: wheels and gyro, never jumps
  Pose2D map_from_odom;                                   ///< moves when a scan or a loop closure corrects the drift
  Velocity velocity;                                      ///< in the body frame
  std::array<double, 9> covariance{};                     ///< of map_from_base (x, y, theta), row-major
  LocalizationState state = LocalizationState::tracking;  ///< whether map_from_odom is known

  /// The estimated pose in `map`.
  Pose2D map_from_base() const { return map_from_odom * odom_from_base; }
  /// Whether map_from_odom is no more than where the robot was last believed to be.
  bool lost() const { return state == LocalizationState::lost || state == LocalizationState::relocating; }
  /// `odom_from_base` a short time before, had the robot moved as it does now.
  Pose2D odom_from_base_ago(Duration ago) const { return integrate(odom_from_base, velocity, -to_seconds(ago)); }
  /// Radius [m] of the disc around the estimated position that holds the true one with a probability of 95 %, as far as
  /// the covariance is consistent.
  double position_uncertainty() const;
};

/// Localisation and mapping of one robot. It sees samples and nothing else.
class Localizer {
 public:
  virtual ~Localizer() = default;

  /// One sample, in order of arrival. Sensors it has no use for are ignored.
  virtual void add(const Sample& sample) = 0;
  /// The best estimate for time `now`, extrapolated from the newest samples.
  virtual PoseEstimate estimate(Time now) const = 0;
  /// The map so far, in the `map` frame. The reference stays valid until the next `add`.
  virtual const map::OccupancyGrid& map() const = 0;
  /// Counts the changes of the map: equal numbers mean equal maps.
  virtual std::uint64_t map_version() const = 0;
  /// Where it changed, by these versions, so that others need not look at all of it; null where unknown.
  virtual const map::ChangeLog* map_changes() const { return nullptr; }
  /// Where the newest scan hit something: points in `odom`, deskewed; and where earlier ones did, for what has come
  /// nearer than the lidar can see. Valid until the next `add`.
  virtual std::span<const Vec2> obstacles() const = 0;
  /// A copy that lives on independently, for saving and restoring.
  virtual std::unique_ptr<Localizer> clone() const = 0;
};

}  // namespace threewe::slam
