// Obstacle field around a robot, a look-up table for its rollouts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/mppi/rollout.hpp"
#include "nav/params.hpp"
#include "threewe/core/footprint.hpp"

namespace threewe::nav::mppi {

/// A box of cells.
struct Cells {
  int first_column = 0, first_row = 0, columns = 0, rows = 0;
};

/// An obstacle.
struct Stamp {
  float x = 0.0F, y = 0.0F;  ///< [m] from the corner of cell (0, 0)
  std::int32_t packed = 0;
};

/// What all stamps share.
struct StampShape {
  float cell = 0.0F;                            ///< [m]
  float half_length = 0.0F, half_width = 0.0F;  ///< [m] of the outline
  float sight = 0.0F;                           ///< [m] beyond, obstacles do not count
};

inline constexpr std::int32_t kNothing = static_cast<std::int32_t>(0x80008000);  ///< far outside of the window

/// For each heading and each of the cells that are to be filled, whole blocks wide, the obstacle that is nearest to the
/// outline; of those that are equally near the first. `cells`: (kBins, kSide, kSide). `nearest`: (kSide, kSide), room
/// for how near they are.
void stamp_rows(const StampShape& shape, const Cells& filled, std::span<const Stamp> stamps,
                std::span<std::int32_t> cells, std::span<float> nearest);

/// A square window of kSide x kSide cells with the axes of `odom`. For each cell and each of kBins headings of the
/// robot there, it knows which obstacle is nearest to the outline; the distance itself then follows to the bit of a
/// float, wherever in the cell the robot is. The outline is the box around the footprint. Cells are filled where the
/// robot may get; seen from elsewhere, things are as from the nearest place there.
class ObstacleField {
 public:
  /// `reach` [m]: how far from its middle the robot may get. Obstacles beyond `sight` [m] from the outline do not
  /// count.
  ObstacleField(const Footprint& footprint, double reach, double sight, const Params& params);

  /// Looks at all obstacles anew, points in `odom` [m]; the window's middle is then `middle`, and the robot stays
  /// between the corners `low` and `high`.
  void update(std::span<const Vec2> obstacles, Vec2 middle, Vec2 low, Vec2 high);

  Vec2 middle() const { return middle_; }
  /// The robot may get to all places between two corners.
  bool covers(Vec2 low, Vec2 high) const;
  double unit() const { return unit_; }
  FieldView view() const;

 private:
  Cells cells_around(Vec2 low, Vec2 high) const;
  void add_stamp(float x, float y);

  double cell_;      // [m]
  double thinning_;  // [m]
  double unit_;      // [m]
  float half_length_;
  float half_width_;
  Vec2 base_to_middle_;
  float sight_;
  Vec2 middle_;
  Cells filled_;
  std::vector<Stamp> stamps_;
  std::vector<std::int32_t> cells_;  // (kBins, kSide, kSide), packed obstacles
  std::vector<float> nearest_;       // see `stamp_rows`
};

}  // namespace threewe::nav::mppi
