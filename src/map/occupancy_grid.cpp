#include "threewe/map/occupancy_grid.hpp"

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::map {

void check_bounds(const OccupancyGrid& grid) {
  if (grid.width < 0 || grid.height < 0 || !fits_a_grid(grid.width, grid.height)) {
    throw ContractError(fmt::format("map must have at most 8192 cells a side and 16.7 million in all, got {} x {}",
                                    grid.width, grid.height));
  }
  const auto cells = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  if (grid.data.size() != cells) {
    throw ContractError(fmt::format("map: {} cells in a grid of {} x {}", grid.data.size(), grid.width, grid.height));
  }
  if (!is_within(grid.resolution, kFinestResolution, kCoarsestResolution)) {
    throw ContractError(fmt::format("map: resolution must lie in [{:g}, {:g}] m, not {:g}", kFinestResolution,
                                    kCoarsestResolution, grid.resolution));
  }
  threewe::check_bounds("map: origin", grid.origin);
}

}  // namespace threewe::map
