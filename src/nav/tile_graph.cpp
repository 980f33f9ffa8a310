#include "nav/tile_graph.hpp"

#include <algorithm>
#include <memory>

#include "core/exact.hpp"
#include "nav/tile_field.hpp"

namespace threewe::nav {

using map::Cell;
using map::Costmap;

namespace {

constexpr int kSpacing = 11;  // [cells] between portals where all is free; costs of ways are then some 2 % too high

// How portals lie within a tile.
constexpr int kLine = TileGraph::kTile + 1;
static_assert(kLine == kernel::kSide);
std::size_t index_of(int portal) { return static_cast<std::size_t>(kernel::place(portal % kLine, portal / kLine)); }
bool is_inside(Cell c) { return c.x >= 0 && c.y >= 0 && c.x < kLine && c.y < kLine; }

// Straight to the goal at the least weight. A little less than 256 for each cell, as steps' costs are rounded.
std::uint64_t least_cost(Cell a, Cell b) {
  const double dx = a.x - b.x;
  const double dy = a.y - b.y;
  return static_cast<std::uint64_t>(255.75 * Costmap::kFree * exact::sqrt(dx * dx + dy * dy));
}

}  // namespace

struct TileGraph::Workspace {
  kernel::Steps steps;
  kernel::Costs costs;
  kernel::ManyCosts many;

  // Costs from one cell to all of a tile.
  void spread_from(const Costmap& costmap, Cell corner, Cell start, Cell from) {
    load_steps(costmap, corner, start, steps);
    costs.at.fill(kernel::kUnreached);
    costs.at[static_cast<std::size_t>(kernel::place(from.x - corner.x, from.y - corner.y))] = 0;
    kernel::spread(steps, costs);
  }
  std::int32_t cost_to(Cell inside) const {
    return costs.at[static_cast<std::size_t>(kernel::place(inside.x, inside.y))];
  }
  std::int32_t cost_to(std::uint16_t portal) const { return costs.at[index_of(portal)]; }
};

// From the start to the portals of its tiles, from portal to portal, and to the goal.
std::optional<TileWay> TileGraph::find(const Costmap& costmap, Cell start, Cell goal) {
  if (!costmap.contains(start) || !costmap.contains(goal)) return {};
  adopt(costmap);
  ++search_;
  start_ = start;
  const auto work = std::make_unique_for_overwrite<Workspace>();
  const auto goal_node = static_cast<std::uint32_t>(nodes_.size() - 1);
  const std::uint32_t goal_tile = tiles_with(goal).front();

  heap_.clear();
  const auto later = [](const Entry& a, const Entry& b) { return a.key != b.key ? a.key > b.key : a.node > b.node; };
  const auto relax = [&](std::uint32_t node, Cell cell, std::uint64_t cost, std::uint32_t from, std::uint32_t through) {
    Node& n = nodes_[node];
    if (n.search == search_ && n.cost <= cost) return;
    n = {cost, from, through, search_};
    heap_.push_back({cost + least_cost(cell, goal), node});
    std::push_heap(heap_.begin(), heap_.end(), later);
  };

  for (const std::uint32_t index : tiles_with(start)) {
    const Tile& t = tile(costmap, index, *work);
    work->spread_from(costmap, corner(index), start, start);
    for_each_portal(t, index, [&](std::uint32_t node, Cell cell, std::size_t i) {
      const std::int32_t cost = work->cost_to(t.places[i]);
      if (cost < kernel::kUnreached) relax(node, cell, static_cast<std::uint64_t>(cost), kStart, index);
    });
    const Cell in{goal.x - corner(index).x, goal.y - corner(index).y};
    if (!is_inside(in)) continue;
    const std::int32_t cost = work->cost_to(in);
    if (cost < kernel::kUnreached) relax(goal_node, goal, static_cast<std::uint64_t>(cost), kStart, index);
  }

  // steps cost the same either way
  std::vector<std::int32_t> to_goal;
  const Tile& last = tile(costmap, goal_tile, *work);
  work->spread_from(costmap, corner(goal_tile), start, goal);
  for (const std::uint16_t p : last.places) to_goal.push_back(work->cost_to(p));

  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), later);
    const Entry entry = heap_.back();
    heap_.pop_back();
    const Node here = nodes_[entry.node];
    if (entry.node == goal_node) return way_to(goal_node);

    const std::uint32_t side = entry.node / kMostPortals;
    const std::uint32_t number = entry.node % kMostPortals;
    for (const std::uint32_t index : tiles_beside(side)) {
      const Tile& t = tile(costmap, index, *work);
      std::size_t s = 0;
      while (side_of(index, s) != side) ++s;
      const std::size_t row = t.first[s] + number;
      if (entry.key !=
          here.cost +
              least_cost({corner(index).x + t.places[row] % kLine, corner(index).y + t.places[row] / kLine}, goal)) {
        break;  // a cheaper way was found since
      }
      const std::int32_t* costs = &t.costs[row * t.places.size()];
      for_each_portal(t, index, [&](std::uint32_t node, Cell cell, std::size_t i) {
        if (costs[i] < kernel::kUnreached)
          relax(node, cell, here.cost + static_cast<std::uint64_t>(costs[i]), entry.node, index);
      });
      if (index == goal_tile && to_goal[row] < kernel::kUnreached) {
        relax(goal_node, goal, here.cost + static_cast<std::uint64_t>(to_goal[row]), entry.node, index);
      }
    }
  }
  return {};
}

bool TileGraph::reaches(const Costmap& costmap, Cell cell) {
  const auto work = std::make_unique_for_overwrite<Workspace>();
  const std::uint32_t index = tiles_with(cell).front();
  const Tile& t = tile(costmap, index, *work);
  work->spread_from(costmap, corner(index), start_, cell);
  bool reached = false;
  for_each_portal(t, index, [&](std::uint32_t node, Cell, std::size_t i) {
    reached = reached || (nodes_[node].search == search_ && work->cost_to(t.places[i]) < kernel::kUnreached);
  });
  const Cell in{start_.x - corner(index).x, start_.y - corner(index).y};
  return reached || (is_inside(in) && work->cost_to(in) < kernel::kUnreached);
}

// Tiles keep what is known of them when the frame moves; stamps say whether it is still true.
void TileGraph::adopt(const Costmap& costmap) {
  const int columns = (costmap.width() + kTile - 1) / kTile;
  const int rows = (costmap.height() + kTile - 1) / kTile;
  if (columns == columns_ && rows == rows_ && costmap.low() == low_) return;
  std::vector<Tile> moved(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const Cell by{(low_.x - costmap.low().x) / kTile, (low_.y - costmap.low().y) / kTile};
  for (int y = std::max(0, -by.y); y < rows_ && y + by.y < rows; ++y) {
    for (int x = std::max(0, -by.x); x < columns_ && x + by.x < columns; ++x) {
      moved[static_cast<std::size_t>(y + by.y) * static_cast<std::size_t>(columns) +
            static_cast<std::size_t>(x + by.x)] =
          std::move(
              tiles_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)]);
    }
  }
  tiles_ = std::move(moved);
  columns_ = columns;
  rows_ = rows;
  low_ = costmap.low();
  nodes_.assign(2 * tiles_.size() * kMostPortals + 1, Node{});
  search_ = 0;
}

// A tile with its tables up to date.
const TileGraph::Tile& TileGraph::tile(const Costmap& costmap, std::uint32_t index, Workspace& work) {
  Tile& t = tiles_[index];
  const std::uint64_t stamp = costmap.stamp(corner(index));
  if (t.stamp == stamp) return t;
  t.stamp = stamp;
  ++tables_made_;

  load_steps(costmap, corner(index), {-1, -1}, work.steps);
  choose_portals(work, index, t);
  t.costs.resize(t.places.size() * t.places.size());
  for (std::size_t done = 0; done < t.places.size(); done += kernel::kLanes) {
    const std::size_t end = std::min(done + kernel::kLanes, t.places.size());
    for (auto& lanes : work.many.at) lanes.fill(kernel::kUnreached);
    for (std::size_t i = done; i < end; ++i) work.many.at[index_of(t.places[i])][i - done] = 0;
    kernel::spread(work.steps, work.many);
    for (std::size_t i = done; i < end; ++i) {
      for (std::size_t j = 0; j < t.places.size(); ++j) {
        t.costs[i * t.places.size() + j] = work.many.at[index_of(t.places[j])][i - done];
      }
    }
  }
  return t;
}

// Each run of free cells on a side is cut into pieces of about kSpacing, with a portal in the cheapest cell of each:
// the middle of a doorway, the middle of a piece in the open. Both tiles of a side choose the same.
void TileGraph::choose_portals(const Workspace& work, std::uint32_t index, Tile& t) const {
  t.places.clear();
  const Cell at{corner(index).x / kTile, corner(index).y / kTile};
  const std::array<bool, 4> shared = {at.x > 0, at.x + 1 < columns_, at.y > 0, at.y + 1 < rows_};
  const std::array<int, 4> from = {0, kTile, 0, kTile * kLine};
  const std::array<int, 4> step = {kLine, kLine, 1, 1};
  for (std::size_t side = 0; side < 4; ++side) {
    t.first[side] = static_cast<std::uint8_t>(t.places.size());
    const auto cell = [&](int along) { return from[side] + along * step[side]; };
    const auto weight = [&](int along) { return work.steps.weight[index_of(cell(along))]; };
    for (int begin = 0; shared[side] && begin < kLine;) {
      int end = begin;
      while (end < kLine && weight(end) < kernel::kWall) ++end;
      const int pieces = end == begin ? 0 : std::max(1, (end - begin + kSpacing / 2) / kSpacing);
      for (int i = 0; i < pieces; ++i) {
        const int low = begin + (end - begin) * i / pieces;
        const int high = begin + (end - begin) * (i + 1) / pieces;
        int best = low;
        const auto off = [&](int along) { return std::abs(2 * along - (low + high - 1)); };
        for (int along = low + 1; along < high; ++along) {
          const bool cheaper = weight(along) < weight(best);
          if (cheaper || (weight(along) == weight(best) && off(along) < off(best))) best = along;
        }
        t.places.push_back(static_cast<std::uint16_t>(cell(best)));
      }
      begin = end + 1;
    }
  }
  t.first[4] = static_cast<std::uint8_t>(t.places.size());
}

// Sides are numbered by the tile to their east or north, those across x first.
std::uint32_t TileGraph::side_of(std::uint32_t index, std::size_t side) const {
  const auto count = static_cast<std::uint32_t>(tiles_.size());
  const auto columns = static_cast<std::uint32_t>(columns_);
  switch (side) {
    case 0: return index;
    case 1: return index + 1;
    case 2: return count + index;
    default: return count + index + columns;
  }
}

std::array<std::uint32_t, 2> TileGraph::tiles_beside(std::uint32_t side) const {
  const auto count = static_cast<std::uint32_t>(tiles_.size());
  if (side < count) return {side - 1, side};
  return {side - count - static_cast<std::uint32_t>(columns_), side - count};
}

Cell TileGraph::corner(std::uint32_t index) const {
  const auto columns = static_cast<std::uint32_t>(columns_);
  return {static_cast<int>(index % columns) * kTile, static_cast<int>(index / columns) * kTile};
}

// A cell on a shared line belongs to two tiles, in a corner to four. The first is the one that it is counted in.
std::vector<std::uint32_t> TileGraph::tiles_with(Cell cell) const {
  std::vector<std::uint32_t> tiles;
  for (int y = cell.y / kTile; y >= std::max(0, (cell.y - 1) / kTile); --y) {
    for (int x = cell.x / kTile; x >= std::max(0, (cell.x - 1) / kTile); --x) {
      tiles.push_back(static_cast<std::uint32_t>(y * columns_ + x));
    }
  }
  return tiles;
}

template <class Visit>
void TileGraph::for_each_portal(const Tile& t, std::uint32_t index, Visit visit) const {
  const Cell low = corner(index);
  for (std::size_t side = 0; side < 4; ++side) {
    std::uint32_t node = side_of(index, side) * kMostPortals;
    for (std::size_t i = t.first[side]; i < t.first[side + 1]; ++i, ++node) {
      visit(node, Cell{low.x + t.places[i] % kLine, low.y + t.places[i] / kLine}, i);
    }
  }
}

TileWay TileGraph::way_to(std::uint32_t node) const {
  TileWay way;
  way.cost = nodes_[node].cost;
  for (;; node = nodes_[node].from) {
    way.tiles.push_back(corner(nodes_[node].through));
    if (nodes_[node].from == kStart) break;
  }
  std::reverse(way.tiles.begin(), way.tiles.end());
  return way;
}

std::size_t TileGraph::memory() const {
  std::size_t bytes =
      tiles_.capacity() * sizeof(Tile) + nodes_.capacity() * sizeof(Node) + heap_.capacity() * sizeof(Entry);
  for (const Tile& t : tiles_) {
    bytes += t.places.capacity() * sizeof(std::uint16_t) + t.costs.capacity() * sizeof(std::int32_t);
  }
  return bytes;
}

}  // namespace threewe::nav
