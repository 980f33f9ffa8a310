// The inner part of the tile graph: costs that spread through one tile of a costmap, vectorised. Whole numbers
// throughout, so that the order of additions does not matter.
#pragma once

#include <array>
#include <cstdint>

namespace threewe::nav::kernel {

/// A tile and the first row and column of the next ones, which neighbours share. Every step lies within some tile.
inline constexpr int kSide = 33;
/// Around it lie cells that no step enters, as far as steps reach, so that there is no edge to think of.
inline constexpr int kRim = 2;
inline constexpr int kRow = kSide + 2 * kRim;
inline constexpr int kCells = kRow * kRow;
constexpr int place(int x, int y) { return (y + kRim) * kRow + x + kRim; }

/// The weight of what cannot be entered, and the cost of what cannot be reached: one step into the former.
inline constexpr std::int32_t kWall = 1 << 20;
inline constexpr std::int32_t kUnreached = 1 << 27;

/// Steps to a neighbour, straight or diagonal, and like a knight's; half of them, the others lead back. A step costs
/// 256 times its length in cells times the mean of the weights under its line.
struct Steps {
  static constexpr int kCount = 8;
  static constexpr std::array<int, kCount> kOffsets = {-1,        -1 - kRow,     -kRow,        1 - kRow,
                                                       -2 - kRow, -1 - 2 * kRow, 1 - 2 * kRow, 2 - kRow};
  static constexpr int kSpare = 16;  // a whole vector is read and written at a time

  alignas(64) std::array<std::int32_t, kCells + kSpare> weight;
  alignas(64) std::array<std::array<std::int32_t, kCells + kSpare>, kCount> cost;
};

/// Fills in the costs for the weights.
void set_costs(Steps& steps);

/// What it costs to come to each cell from one place; `kUnreached` where no steps lead.
struct alignas(64) Costs {
  std::array<std::int32_t, kCells + Steps::kSpare> at;
};
/// The same from so many places at once.
inline constexpr int kLanes = 8;
struct alignas(64) ManyCosts {
  std::array<std::array<std::int32_t, kLanes>, kCells> at;
};

/// Lowers costs along all steps until none can be lowered any more: from where they are known to everywhere. Fast
/// sweeping (Zhao 2005), which needs no queue.
void spread(const Steps& steps, Costs& costs);
void spread(const Steps& steps, ManyCosts& costs);

}  // namespace threewe::nav::kernel
