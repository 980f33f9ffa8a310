#include "nav/tile_field.hpp"

#include <algorithm>
#include <cstddef>

namespace threewe::nav {

void load_steps(const map::Costmap& costmap, map::Cell corner, map::Cell start, kernel::Steps& steps) {
  using map::Costmap;
  steps.weight.fill(kernel::kWall);
  const int columns = std::min(kernel::kSide, costmap.width() - corner.x);
  const int rows = std::min(kernel::kSide, costmap.height() - corner.y);
  for (int y = 0; y < rows; ++y) {
    const Costmap::Weight* source = &costmap.weights()[costmap.index({corner.x, corner.y + y})];
    std::int32_t* target = &steps.weight[static_cast<std::size_t>(kernel::place(0, y))];
    for (int x = 0; x < columns; ++x) target[x] = source[x] == Costmap::kLethal ? kernel::kWall : source[x];
  }
  const map::Cell inside{start.x - corner.x, start.y - corner.y};
  if (inside.x >= 0 && inside.y >= 0 && inside.x < columns && inside.y < rows) {
    std::int32_t& weight = steps.weight[static_cast<std::size_t>(kernel::place(inside.x, inside.y))];
    weight = std::min(weight, kStartWeight);
  }
  kernel::set_costs(steps);
}

}  // namespace threewe::nav
