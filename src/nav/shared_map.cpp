#include "nav/shared_map.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::nav {
namespace {

using map::Cell, map::OccupancyGrid;

// The cells of our raster that both cover.
struct Frame {
  Cell low;   // in cells of our map
  Cell high;  // up to, but without
};

Frame with(const Frame& frame, const OccupancyGrid& ours, const OccupancyGrid& theirs) {
  const Vec2 size{theirs.width * theirs.resolution, theirs.height * theirs.resolution};
  const Cell low = ours.cell(theirs.origin);
  const Cell high = ours.cell(theirs.origin + size);
  const Frame wider{{std::min(frame.low.x, low.x), std::min(frame.low.y, low.y)},
                    {std::max(frame.high.x, high.x + 1), std::max(frame.high.y, high.y + 1)}};
  return map::fits_a_grid(wider.high.x - wider.low.x, wider.high.y - wider.low.y) ? wider : frame;
}

}  // namespace

void merge_maps(const OccupancyGrid& ours, std::span<const Peer> peers, OccupancyGrid& merged) {
  Frame frame{{0, 0}, {ours.width, ours.height}};
  for (const Peer& peer : peers) frame = with(frame, ours, *peer.map);

  merged.width = frame.high.x - frame.low.x;
  merged.height = frame.high.y - frame.low.y;
  merged.resolution = ours.resolution;
  merged.origin = ours.origin + ours.resolution * Vec2{1.0 * frame.low.x, 1.0 * frame.low.y};
  merged.data.resize(static_cast<std::size_t>(merged.width) * static_cast<std::size_t>(merged.height));
  for (int y = 0; y < merged.height; ++y) {
    for (int x = 0; x < merged.width; ++x) {
      std::int8_t value = ours.at({x + frame.low.x, y + frame.low.y});
      for (std::size_t i = 0; i < peers.size() && value == OccupancyGrid::kUnknown; ++i) {
        value = peers[i].map->at(peers[i].map->cell(merged.center({x, y})));
      }
      merged.data[merged.index({x, y})] = value;
    }
  }
}

}  // namespace threewe::nav
