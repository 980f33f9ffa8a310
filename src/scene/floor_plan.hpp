// Rooms, walls and doorways of a generated scene, in whole centimetres.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/rng.hpp"

namespace threewe::scene {

/// A rectangle along the axes [cm].
struct Box {
  int x0 = 0;
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;

  int width() const { return x1 - x0; }
  int depth() const { return y1 - y0; }
  bool overlaps(const Box& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
  bool contains(const Box& o) const { return x0 <= o.x0 && y0 <= o.y0 && o.x1 <= x1 && o.y1 <= y1; }
  friend bool operator==(const Box&, const Box&) = default;
};

/// Draws, one after the other, from one key.
class RandomStream {
 public:
  explicit RandomStream(const RngKey& key) : key_(key) {}
  /// A whole number, `low` and `high` included.
  int between(int low, int high) { return low + static_cast<int>(uniform(key_, sample_++) * (high - low + 1)); }
  bool chance(double probability) { return uniform(key_, sample_++) < probability; }
  template <typename Items>
  const auto& pick(const Items& of) {
    return of[static_cast<std::size_t>(between(0, static_cast<int>(of.size()) - 1))];
  }
  template <typename T>
  void shuffle(std::vector<T>& items) {
    for (int i = static_cast<int>(items.size()) - 1; i > 0; --i) {
      std::swap(items[static_cast<std::size_t>(i)], items[static_cast<std::size_t>(between(0, i))]);
    }
  }

 private:
  RngKey key_;
  std::uint64_t sample_ = 0;
};

/// A wall along an axis.
struct WallLine {
  bool along_x = false;
  int at = 0;    ///< [cm], its other coordinate
  int from = 0;  ///< [cm]
  int to = 0;    ///< [cm]
  bool outer = false;
};

/// A doorway between two rooms.
struct Passage {
  std::size_t room_a = 0;  ///< west or south of the wall
  std::size_t room_b = 0;
  std::size_t line = 0;
  int at = 0;     ///< [cm] of its middle, along the wall's axis
  int width = 0;  ///< [cm]
};

struct FloorPlan {
  std::vector<Box> rooms;  ///< between the middles of their walls
  int corridors = 0;       ///< how many of the first rooms are corridors: 0 or 1
  std::vector<WallLine> lines;
  std::vector<Passage> passages;  ///< connect all rooms
};

/// A building of `width` x `depth` [cm]: a corridor if there is space, rooms by splitting what is left in two, again
/// and again, doorways that connect them all, and some more. Doors are the narrower, the higher the difficulty (0..1).
FloorPlan draw_floor_plan(int width, int depth, double difficulty, RandomStream& random);

}  // namespace threewe::scene
