// Cell grid over a scene: one value for every square cell.
#pragma once

#include <cstddef>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::scene {

/// Column along x and row along y of a cell.
struct CellIndex {
  int x = 0;  ///< column
  int y = 0;  ///< row
  friend bool operator==(const CellIndex&, const CellIndex&) = default;
};

/// Where the cells of a grid are. Cell (0, 0) has its lower left corner at `origin`; axes are the scene's.
struct GridFrame {
  Vec2 origin;              ///< [m]
  double resolution = 0.0;  ///< [m], the side of a cell
  int width = 0;            ///< cells along x
  int height = 0;           ///< cells along y
  friend bool operator==(const GridFrame&, const GridFrame&) = default;

  /// How many cells there are.
  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  /// Whether there is such a cell.
  bool contains(CellIndex c) const { return c.x >= 0 && c.y >= 0 && c.x < width && c.y < height; }
  /// The place of a cell, row by row. The cell must be on the grid.
  std::size_t index(CellIndex c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c.x);
  }
  /// The cell at such a place.
  CellIndex cell(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(width);
    return {static_cast<int>(index % columns), static_cast<int>(index / columns)};
  }
  /// The cell that holds a point, which may lie outside the grid. The point's coordinates must be finite.
  CellIndex cell(Vec2 point) const {
    return {to_cell((point.x - origin.x) / resolution, width), to_cell((point.y - origin.y) / resolution, height)};
  }
  /// The middle [m] of a cell.
  Vec2 center(CellIndex c) const { return {origin.x + (c.x + 0.5) * resolution, origin.y + (c.y + 0.5) * resolution}; }

 private:
  // far outside is just outside, so that any finite point can be converted
  static int to_cell(double cells, int count) {
    if (!(cells >= 0.0)) return -1;
    return cells < count ? static_cast<int>(cells) : count;
  }
};

/// One value for every cell of a frame, row by row.
template <typename T>
struct CellGrid {
  GridFrame frame;       ///< where the cells are
  std::vector<T> cells;  ///< (height, width), row-major

  CellGrid() = default;
  /// The same value everywhere.
  CellGrid(const GridFrame& where, const T& value) : frame(where), cells(where.size(), value) {}

  /// The value at a cell of the grid.
  T& operator[](CellIndex c) { return cells[frame.index(c)]; }
  /// The value at a cell of the grid.
  const T& operator[](CellIndex c) const { return cells[frame.index(c)]; }
  /// The value at a cell, `outside` beyond the grid.
  T value_or(CellIndex c, T outside) const { return frame.contains(c) ? (*this)[c] : outside; }
  friend bool operator==(const CellGrid&, const CellGrid&) = default;
};

/// A set of cells: 1 inside, 0 outside.
using CellSet = CellGrid<unsigned char>;

}  // namespace threewe::scene
