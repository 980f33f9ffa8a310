// Noise-free visibility of a scene so far: it only ever grows.
#pragma once

#include <cstddef>
#include <vector>

#include "scene/scene_tables.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::benchmark {

/// [m] between two looks: what is driven at 0.5 m/s during one turn of a lidar.
inline constexpr double kStride = 0.05;

/// A lidar without noise, latency or motion during its turn, and what it has shown.
class Sight {
 public:
  /// `around` [m]: beyond the scene's own cells. Throws HardwareError for a robot without a lidar.
  Sight(const scene::SceneTables& tables, const RobotProfile& profile, double around);

  /// A look from where the base is; what the robot would run into next is noticed too, where no beam can meet it.
  void look(const Pose2D& scene_from_base);

  /// Where the robot may hope to pass: no obstacle has been seen within its passing radius.
  const scene::CellSet& open() const { return open_; }
  /// The cells that a beam has crossed within scene::kCoverageRange.
  const scene::CellSet& known() const { return known_; }
  /// Whether a polyline leads through open cells alone.
  bool is_open(const std::vector<Vec2>& path) const;

 private:
  void add_beam(Vec2 origin, Vec2 direction, double range);
  template <class Visit>
  void for_cells(Vec2 point, double radius, Visit visit);

  const scene::SceneTables* tables_;
  LidarSpec lidar_;
  scene::Slice slice_;
  scene::CellSet open_;
  scene::CellSet known_;
};

/// Throws ContractError for a place that is not among a scene's cells, where nothing would ever be met.
void require_inside(const scene::SceneTables& tables, const char* name, Vec2 place);

/// A point that walks along polylines and counts its steps.
class Walk {
 public:
  explicit Walk(Vec2 start) : here_(start) {}

  /// Goes on along `path`, whose first point it stands at, by at most `far` [m]; drops what it has passed.
  void along(std::vector<Vec2>& path, double far);
  Vec2 here() const { return here_; }
  /// [m] walked.
  double length() const { return length_; }

 private:
  Vec2 here_;
  double length_ = 0.0;
};

}  // namespace threewe::benchmark
