// A costmap as a graph of tiles, so that long ways are found without looking at every cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "map/costmap.hpp"

namespace threewe::nav {

/// A way through tiles.
struct TileWay {
  std::vector<map::Cell> tiles;  ///< their lower left cells, from the start's to the goal's; neighbours share a side
  std::uint64_t cost = 0;        ///< of a path along it [cells times weight / 256]
};

/// Tiles of 32 x 32 cells, each with the line of cells that it shares with its neighbours. Where free cells follow one
/// another on a shared line, some of them are portals; each tile knows what it costs to go from portal to portal
/// through its cells, by steps to 16 neighbours. Ways are found from portal to portal by A* (near-optimal pathfinding
/// by abstraction: Botea, Mueller & Schaeffer 2004).
///
/// Every run of free cells has a portal, and a path can only change tiles on a shared line. So there is a way through
/// tiles exactly where there is a path of 8-connected cells. The tables of a tile follow from its weights alone and are
/// made when a search first comes there; they are kept until a weight changes. So nothing depends on what was asked or
/// changed before, and a new plan costs what changed on its way. Used by `Planner`.
class TileGraph {
 public:
  static constexpr int kTile = map::Costmap::kTile;

  /// The cheapest way through portals; nothing where no path exists. `start` may be a lethal cell, `goal` may not.
  std::optional<TileWay> find(const map::Costmap& costmap, map::Cell start, map::Cell goal);
  /// After `find` has found nothing: whether there is a path to another cell from the same start.
  bool reaches(const map::Costmap& costmap, map::Cell cell);

  /// Tiles whose tables were made since the beginning.
  std::size_t tables_made() const { return tables_made_; }
  /// [bytes] of all tables and of what a search keeps.
  std::size_t memory() const;

 private:
  static constexpr int kMostPortals = kTile / 2 + 1;   // on one side, where every second cell is free
  static constexpr std::uint32_t kStart = 0xFFFFFFFF;  // in the place of a portal

  // What is known of a tile. Portals are in the order of its sides: west, east, south, north.
  struct Tile {
    std::uint64_t stamp = 0;              // of the weights that this was made of, 0 before
    std::array<std::uint8_t, 5> first{};  // portal of each side, and the number of all
    std::vector<std::uint16_t> places;    // of portals: y * (kTile + 1) + x within the tile
    std::vector<std::int32_t> costs;      // from each portal to each
  };
  // How a search came to a portal.
  struct Node {
    std::uint64_t cost = 0;
    std::uint32_t from = kStart;  // a portal ...
    std::uint32_t through = 0;    // ... and the tile between
    std::uint32_t search = 0;     // which search; what others wrote does not count
  };
  struct Entry {
    std::uint64_t key;
    std::uint32_t node;
  };
  struct Workspace;

  void adopt(const map::Costmap& costmap);
  const Tile& tile(const map::Costmap& costmap, std::uint32_t index, Workspace& work);
  void choose_portals(const Workspace& work, std::uint32_t index, Tile& tile) const;
  std::uint32_t side_of(std::uint32_t tile, std::size_t side) const;
  std::array<std::uint32_t, 2> tiles_beside(std::uint32_t side) const;
  map::Cell corner(std::uint32_t tile) const;
  std::vector<std::uint32_t> tiles_with(map::Cell cell) const;
  template <class Visit>
  void for_each_portal(const Tile& tile, std::uint32_t index, Visit visit) const;
  TileWay way_to(std::uint32_t node) const;

  int columns_ = 0;
  int rows_ = 0;
  map::Cell low_;  // of the costmap's frame, to find tiles again when it moves
  std::vector<Tile> tiles_;
  std::vector<Node> nodes_;  // kMostPortals for each side; the last is the goal
  std::uint32_t search_ = 0;
  map::Cell start_;
  std::vector<Entry> heap_;
  std::size_t tables_made_ = 0;
};

}  // namespace threewe::nav
