// Distances along columns first, then the least of column^2 + dx^2 along rows. All of it fits into bytes.
#include <algorithm>
#include <cassert>

#include "map/costmap.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "map/distances.cpp"
#include "core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::map::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The least of the squares of a row with (dx, row) to where they are, for as many cells as a vector has.
template <class D>
HWY_INLINE void least_along_row(D d, const std::uint8_t* squares, std::uint8_t* least) {
  auto best = hn::LoadU(d, squares);
  for (int dx = 1; dx < kMaxDistance; ++dx) {
    const auto nearer = hn::Min(hn::LoadU(d, squares - dx), hn::LoadU(d, squares + dx));
    best = hn::Min(best, hn::SaturatedAdd(nearer, hn::Set(d, static_cast<std::uint8_t>(dx * dx))));
  }
  hn::StoreU(best, d, least);
}

// `columns`: rows of `stride` cells, 0 where occupied, else kMaxDistance, room on both sides of `width` included.
void measure_all(std::vector<std::uint8_t>& columns, std::size_t stride, std::size_t room, const Region& region,
                 std::vector<std::uint8_t>& squared) {
  const hn::ScalableTag<std::uint8_t> d;
  const auto add_one = [stride](const std::uint8_t* from, std::uint8_t* to) {
    for (std::size_t x = 0; x < stride; ++x) to[x] = std::min(to[x], static_cast<std::uint8_t>(from[x] + 1));
  };
  std::uint8_t* first = columns.data();
  std::uint8_t* last = first + columns.size() - stride;
  for (std::uint8_t* row = first; row != last; row += stride) add_one(row, row + stride);
  for (std::uint8_t* row = last; row != first; row -= stride) add_one(row, row - stride);

  const auto width = static_cast<std::size_t>(region.high.x - region.low.x);
  std::vector<std::uint8_t> least(width + hn::Lanes(d));
  for (int y = region.low.y; y < region.high.y; ++y) {
    std::uint8_t* row = first + static_cast<std::size_t>(y) * stride;
    for (std::size_t x = 0; x < stride; ++x) row[x] = static_cast<std::uint8_t>(row[x] * row[x]);
    const std::uint8_t* squares = row + room + region.low.x;
    for (std::size_t x = 0; x < width; x += hn::Lanes(d)) least_along_row(d, squares + x, &least[x]);
    squared.insert(squared.end(), least.begin(), least.begin() + static_cast<std::ptrdiff_t>(width));
  }
}

}  // namespace threewe::map::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::map {
namespace {

HWY_EXPORT(measure_all);

}  // namespace

void squared_distances(std::span<const std::uint8_t> occupied, int width, int height, const Region& region,
                       std::vector<std::uint8_t>& squared) {
  assert(region.low.x >= 0 && region.low.y >= 0 && region.high.x <= width && region.high.y <= height);
  squared.clear();
  if (region.empty()) return;

  // room on both sides, so that vectors along a row need not mind its ends
  constexpr std::size_t kRoom = 64 + kMaxDistance;
  const auto w = static_cast<std::size_t>(width);
  const auto h = static_cast<std::size_t>(height);
  const std::size_t stride = w + 2 * kRoom;
  std::vector<std::uint8_t> columns(stride * h, std::uint8_t{kMaxDistance});
  for (std::size_t y = 0; y < h; ++y) {
    const std::uint8_t* from = &occupied[y * w];
    std::uint8_t* to = &columns[y * stride + kRoom];
    for (std::size_t x = 0; x < w; ++x) to[x] = from[x] != 0 ? std::uint8_t{0} : std::uint8_t{kMaxDistance};
  }
  HWY_DYNAMIC_DISPATCH(measure_all)(columns, stride, kRoom, region, squared);
}

}  // namespace threewe::map
#endif
