// Costmap: nothing far from obstacles, more near them, everything inside the robot's own radius.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "map/region.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/map/zone.hpp"

namespace threewe::map {

/// Squared distance, in cells, from each cell of a region of a row-major grid to the nearest that is not 0 in
/// `occupied`, within the region or not; never more than kMaxDistance^2. Exact. `squared`: the shape of the region.
inline constexpr int kMaxDistance = 15;
void squared_distances(std::span<const std::uint8_t> occupied, int width, int height, const Region& region,
                       std::vector<std::uint8_t>& squared);

/// A grid of weights for planning: the cost of a path is its length times the weight under it.
///
/// It is made of layers, one upon the other: the map; what is seen now and may not be in the map yet; zones; the
/// distance to the nearest of all that is occupied; weights by that distance, and more where no wall of the map is in
/// sight, so that a robot keeps near what tells it where it is (after Roy & Thrun 1999, "Coastal navigation"). An
/// update costs what changed: each layer compares, and tells the next one where. The result is that of a new costmap
/// with the same arguments, to the bit.
class Costmap {
 public:
  struct Settings {
    double lethal_radius = 0.13;   ///< [m] no path comes so near to an obstacle ...
    double unknown_radius = 0.0;   ///< [m] ... nor, where nothing is known, so near, if that is more
    double caution_radius = 0.50;  ///< [m] weights fall to kFree here
    int near_weight = 32;          ///< added at the lethal radius
    int unknown_weight = 2;        ///< added where nothing is known: optimistic, but dearer than known to be free
    double sight = 0.0;            ///< [m] within which a wall is in sight of a tile; 0: every tile has one
    int blind_weight = 0;          ///< added in tiles that have none
  };
  using Weight = std::uint16_t;
  static constexpr Weight kFree = 4;
  static constexpr Weight kLethal = 0xFFFF;
  static constexpr int kTile = 32;  ///< [cells] the side of a tile

  Costmap() : Costmap(Settings{}) {}
  explicit Costmap(const Settings& settings);

  /// Takes over a map, with at least `rim` unknown cells all around it, rounded up to whole tiles, and large enough to
  /// hold `include`, except for what lies too far away (fits_a_grid). Points in `obstacles` [m] count as occupied
  /// besides, until the next update. `changed`: the cells of the map that may differ from what the last update saw; all
  /// by default.
  void update(const OccupancyGrid& grid, std::span<const Vec2> obstacles, std::span<const Vec2> include, int rim = 20,
              std::optional<Region> changed = {});
  /// From the next update on, cells whose middle lies in a zone to keep out of count as occupied, and those in a zone
  /// with a speed limit are dearer by as much as a robot that drives `speed` [m/s] elsewhere is slower there.
  void set_zones(const std::vector<Zone>& zones, double speed);
  /// Lethal cells within `radius` [m] of `point` that are no nearer to an obstacle than `point` itself become dear
  /// instead, until the next update: the robot is so near already. No slit in a wall opens by that.
  void open_around(Vec2 point, double radius);

  const Settings& settings() const { return settings_; }
  int width() const { return width_; }
  int height() const { return height_; }
  double resolution() const { return resolution_; }
  bool contains(Cell c) const { return c.x >= 0 && c.y >= 0 && c.x < width_ && c.y < height_; }
  std::size_t index(Cell c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c.x);
  }
  Cell cell(Vec2 point) const;
  Vec2 center(Cell c) const;
  /// Where cell (0, 0) is, in cells from the map's raster nearest to (0, 0) m; whole tiles.
  Cell low() const { return low_; }
  /// The stamp of the tile that holds a cell. Equal stamps, in this or any other costmap, mean equal weights, also on
  /// the first row and column of the next tiles. Numbers mean nothing else; they differ between runs.
  std::uint64_t stamp(Cell c) const { return stamps_[tile_of(c)]; }

  const std::vector<Weight>& weights() const { return weights_; }
  /// The weight at a cell; outside as if unknown and far from everything.
  Weight weight(Cell c) const;
  /// Distance [m] between the middles of this cell and of the nearest occupied one, at most kMaxDistance cells.
  double clearance(Cell c) const;
  /// Nothing is known about this cell.
  bool unknown(Cell c) const { return !contains(c) || unknown_[index(c)] != 0; }
  /// 1 for each unknown cell, else 0.
  const std::vector<std::uint8_t>& unknown() const { return unknown_; }
  /// The cost of a straight line [m times weight]; infinity where it meets a lethal cell.
  double line_cost(Vec2 a, Vec2 b) const;

 private:
  struct Frame {
    Cell low;
    int width = 0;
    int height = 0;
    friend bool operator==(const Frame&, const Frame&) = default;
  };
  enum Occupant : std::uint8_t { kMapped = 1, kSeen = 2, kFresh = 4, kZoned = 8 };  // who says that a cell is occupied
  enum Stale : std::uint8_t { kWeights = 1, kDistances = 2 };  // what of a tile is to be made again

  int raster(double metres) const;
  Frame frame_for(const OccupancyGrid& grid, std::span<const Vec2> include, int rim) const;
  void begin(const OccupancyGrid& grid);
  void close_opened();
  void move_to(const Frame& frame);
  void move_tile(Cell from, Cell to, Costmap& target) const;
  void take_map(const OccupancyGrid& grid, const std::optional<Region>& changed);
  void take_block(Cell at, std::span<const std::int8_t> values);
  void take_obstacles(std::span<const Vec2> points);
  void take_zones();
  void count_walls();
  void count_hit(Cell c, int more);
  void show_wall(Cell c, int more);
  bool is_blind(std::size_t tile) const { return settings_.sight > 0.0 && walls_in_sight_[tile] == 0; }
  void set_occupied(Cell c, std::uint8_t occupants);
  void note_occupied(Cell c);
  void inflate();
  void measure(const Region& region);
  void weigh(Cell corner);
  std::array<Weight, kTile> row_of_weights(std::size_t at, bool blind) const;
  void set_weight(Cell c, Weight weight);
  void restamp(Cell c, bool left, bool below, bool corner);
  // The tile that a cell is counted in.
  std::size_t tile_of(Cell c) const {
    return static_cast<std::size_t>(c.y / kTile) * static_cast<std::size_t>(width_ / kTile) +
           static_cast<std::size_t>(c.x / kTile);
  }

  Settings settings_;
  static constexpr std::size_t kUnknown = kMaxDistance * kMaxDistance + 1;
  std::array<Weight, 2 * kUnknown> weight_at_{};  // by squared distance; then the same where nothing is known
  int width_ = 0;
  int height_ = 0;
  double resolution_ = 0.0;
  Cell low_;
  Vec2 origin_;
  std::vector<std::uint8_t> occupied_;
  std::vector<std::uint8_t> unknown_;
  std::vector<std::uint8_t> squared_;
  std::vector<Weight> weights_;
  std::vector<std::uint64_t> stamps_;  // of tiles
  std::vector<std::uint8_t> stale_;    // of tiles, 0 between updates
  std::vector<Cell> seen_;             // cells with kSeen
  std::vector<Cell> opened_;
  std::vector<Zone> zones_;
  double zone_speed_ = 0.0;
  bool zones_taken_ = true;
  bool zoned_ = false;                         // cells may count as occupied, or as slow, for zones
  std::vector<Weight> slow_;                   // added where zones limit the speed; empty where none does
  std::vector<std::uint16_t> hits_;            // of tiles: occupied cells of the map
  std::vector<std::uint32_t> walls_in_sight_;  // of tiles: tiles with hits enough
};

}  // namespace threewe::map
