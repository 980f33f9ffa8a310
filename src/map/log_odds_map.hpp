// Log-odds occupancy map built from scans, with the mean position of the hits in each cell.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "map/change_log.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

/// How much too long or too short all ranges of a lidar may be [m].
inline constexpr double kMaxRangeBias = 1.0;

inline constexpr double kFreeRange = 8.0;  ///< [m] beams clear nothing beyond, by default

/// One measured line of sight.
struct Beam {
  Vec2 origin;         ///< [m] where the sensor was
  Vec2 direction;      ///< unit
  double range = 0.0;  ///< [m] as measured; without a hit, how far the beam is known to be free
  bool hit = false;
  bool thin = false;  ///< the hit belongs to something narrow that stands free, such as a leg
};

/// The hits in one cell: sums, so that surfaces are known much finer than the cell is wide. Hits are kept as they were
/// measured, and whence, so that a better knowledge of the lidar's bias mends old ones too.
struct CellHits {
  std::int16_t sum_x = 0;  ///< [cell/256] of the offsets from the cell's middle
  std::int16_t sum_y = 0;
  std::int16_t sum_from_x = 0;  ///< of the directions back to the sensor, times 100
  std::int16_t sum_from_y = 0;
  std::int16_t count = 0;
  friend bool operator==(const CellHits&, const CellHits&) = default;
};

/// The map. Evidence is an integer of a tenth of a unit of log odds, so that it is the same on every machine.
class LogOddsMap {
 public:
  struct Settings {
    double resolution = 0.05;        ///< [m]
    double free_range = kFreeRange;  ///< [m] beams clear nothing beyond
    std::int8_t hit = 25;            ///< evidence of one scan that hit a cell
    std::int8_t pass = -11;          ///< evidence of one scan that looked through it
    std::int8_t max = 75;
    std::int8_t min = -50;
  };

  LogOddsMap() : LogOddsMap(Settings{}) {}
  explicit LogOddsMap(const Settings& settings);
  /// Goes on from a given map: what is occupied or free in it counts as seen often, each occupied cell
  /// next to free ones as a surface through its middle. The version begins at 1, at 0 where `given` has no cells.
  static LogOddsMap going_on_from(const OccupancyGrid& given, double free_range = kFreeRange);

  /// Adds one scan whose ranges are measured too long by `range_bias` [m] and scatter by `range_noise` [m]. A cell
  /// changes once: where any beam hit it, it counts as hit, whatever passed through it. Beams that the map would
  /// outgrow its limits for are ignored. Throws ContractError where the bias is beyond kMaxRangeBias.
  void insert(std::span<const Beam> scan, double range_bias = 0.0, double range_noise = 0.0);

  /// Makes room for a box at once, where many scans will be inserted: growing scan by scan copies the map each time.
  /// Nothing happens where the map would outgrow its limits.
  void make_room(Vec2 low, Vec2 high);

  /// Takes what another map, of cells of the same raster, has in place of all that it has itself. Versions go on.
  void replace(LogOddsMap other);

  /// The map as others see it. A copy of the evidence that is kept up to date cell by cell.
  const OccupancyGrid& grid() const { return grid_; }
  /// Counts the insertions.
  std::uint64_t version() const { return version_; }
  /// Where each of them changed the grid.
  const ChangeLog& changes() const { return changes_; }
  /// Evidence at a cell of `grid()`: > 0 occupied, < 0 free, 0 unknown.
  std::int8_t log_odds(Cell c) const { return grid_.contains(c) ? log_odds_[grid_.index(c)] : std::int8_t{0}; }
  /// Hits at a cell, shape as `grid().data`.
  const std::vector<CellHits>& hits() const { return hits_; }

 private:
  std::vector<Beam> within_reach(std::span<const Beam> beams) const;
  void grow_to_hold(std::span<const Beam> beams, double range_bias);
  void grow_to(Vec2 low, Vec2 high, double rim);
  void add_hit(const Beam& beam, double range_bias);
  Region mark_free(std::span<const Beam> beams, double range_bias);
  void apply_marks(const Region& seen, bool noisy);
  Region show_changed(bool noisy);
  void forget_surface(std::uint32_t index, bool noisy);
  std::array<std::ptrdiff_t, 8> steps_around() const;
  bool is_beside_occupied(std::size_t index) const;
  void add_given_surface(Cell c);

  Settings settings_;
  OccupancyGrid grid_;
  Vec2 raster_;  // [m] where the corner of some cell is: (0, 0) unless the map was given
  std::vector<std::int8_t> log_odds_;
  std::vector<CellHits> hits_;
  std::vector<std::uint8_t> marks_;     // what the present scan saw; all 0 between scans
  std::vector<std::uint32_t> changed_;  // the cells that it changed or hit
  std::uint64_t version_ = 0;
  ChangeLog changes_;
};

}  // namespace threewe::map
