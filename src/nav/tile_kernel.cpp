#include "nav/tile_kernel.hpp"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/tile_kernel.cpp"
#include "core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::kernel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::CappedTag<std::int32_t, kLanes>;
using V = hn::Vec<Ints>;
constexpr Ints kInts;

// A line along a row or column has half of it in each cell, a diagonal too: 128 and 128 sqrt(2). A knight's has a
// quarter of its sqrt(5) in each of four.
constexpr std::int32_t kStraight = 128;
constexpr std::int32_t kDiagonal = 181;
constexpr std::int32_t kKnight = 143;

HWY_ATTR void set_all_costs(Steps& steps) {
  const std::int32_t* weight = steps.weight.data();
  const auto set = [&](std::size_t step, std::int32_t factor, int beside, int between) HWY_ATTR {
    const int end = Steps::kOffsets[step];
    for (int i = place(0, 0); i < kCells; i += static_cast<int>(hn::Lanes(kInts))) {
      V sum = hn::Add(hn::LoadU(kInts, weight + i), hn::LoadU(kInts, weight + i + end));
      if (beside != 0) {
        sum = hn::Add(sum, hn::Add(hn::LoadU(kInts, weight + i + beside), hn::LoadU(kInts, weight + i + between)));
      }
      hn::StoreU(hn::Mul(sum, hn::Set(kInts, factor)), kInts, steps.cost[step].data() + i);
    }
  };
  set(0, kStraight, 0, 0);
  set(1, kDiagonal, 0, 0);
  set(2, kStraight, 0, 0);
  set(3, kDiagonal, 0, 0);
  set(4, kKnight, -1, -1 - kRow);
  set(5, kKnight, -kRow, -1 - kRow);
  set(6, kKnight, -kRow, 1 - kRow);
  set(7, kKnight, 1, 1 - kRow);
  for (auto& cost : steps.cost) std::fill(cost.begin() + kCells, cost.end(), kUnreached);
}

// Of many costs a vector holds those of one cell.
constexpr std::size_t kVectors = kLanes / hn::MaxLanes(kInts);

// One pass over all cells, row by row forwards or backwards, each from those before it. Whether any cost fell.
template <bool kForwards>
HWY_ATTR bool sweep(const Steps& steps, ManyCosts& costs) {
  constexpr int kSign = kForwards ? 1 : -1;
  const auto lanes_at = [&](int cell, std::size_t v) HWY_ATTR {
    return hn::Load(kInts, costs.at[static_cast<std::size_t>(cell)].data() + v * hn::Lanes(kInts));
  };
  V lowered[kVectors];
  for (V& l : lowered) l = hn::Zero(kInts);
  for (int row = 0; row < kSide; ++row) {
    V last[kVectors];
    for (V& l : last) l = hn::Set(kInts, kUnreached);
    for (int column = 0; column < kSide; ++column) {
      const int cell = kForwards ? place(column, row) : place(kSide - 1 - column, kSide - 1 - row);
      if (steps.weight[static_cast<std::size_t>(cell)] >= kWall) {
        for (V& l : last) l = hn::Set(kInts, kUnreached);
        continue;
      }
      // a step back from here lies at the other end of a step to here
      const auto step = [&](std::size_t i) HWY_ATTR {
        return hn::Set(kInts, steps.cost[i][static_cast<std::size_t>(kForwards ? cell : cell - Steps::kOffsets[i])]);
      };
      for (std::size_t v = 0; v < kVectors; ++v) {
        const auto by = [&](std::size_t i)
                            HWY_ATTR { return hn::Add(lanes_at(cell + kSign * Steps::kOffsets[i], v), step(i)); };
        const V before = lanes_at(cell, v);
        const V near = hn::Min(hn::Min(by(1), by(2)), hn::Min(by(3), before));
        const V far = hn::Min(hn::Min(by(4), by(5)), hn::Min(by(6), by(7)));
        const V least = hn::Min(hn::Min(near, far), hn::Add(last[v], step(0)));
        lowered[v] = hn::Or(lowered[v], hn::Xor(least, before));
        last[v] = least;
        hn::Store(least, kInts, costs.at[static_cast<std::size_t>(cell)].data() + v * hn::Lanes(kInts));
      }
    }
  }
  bool any = false;
  for (const V l : lowered) any = any || !hn::AllTrue(kInts, hn::Eq(l, hn::Zero(kInts)));
  return any;
}

// The same for costs from one place, where a vector holds neighbours in a row: first from the rows before, then along
// the row both ways.
template <bool kForwards>
HWY_ATTR bool sweep(const Steps& steps, Costs& costs) {
  constexpr int kSign = kForwards ? 1 : -1;
  std::int32_t* at = costs.at.data();
  V lowered = hn::Zero(kInts);
  bool any = false;
  for (int row = 0; row < kSide; ++row) {
    const int first = place(0, kForwards ? row : kSide - 1 - row);
    for (int cell = first; cell < first + kSide; cell += static_cast<int>(hn::Lanes(kInts))) {
      const auto by = [&](std::size_t i) HWY_ATTR {
        const V step = hn::LoadU(kInts, steps.cost[i].data() + (kForwards ? cell : cell - Steps::kOffsets[i]));
        return hn::Add(hn::LoadU(kInts, at + cell + std::ptrdiff_t{kSign} * Steps::kOffsets[i]), step);
      };
      const V before = hn::LoadU(kInts, at + cell);
      const V near = hn::Min(hn::Min(by(1), by(2)), hn::Min(by(3), before));
      const V far = hn::Min(hn::Min(by(4), by(5)), hn::Min(by(6), by(7)));
      const V least = hn::Min(near, far);
      lowered = hn::Or(lowered, hn::Xor(least, before));
      hn::StoreU(least, kInts, at + cell);
    }
    const std::int32_t* along = steps.cost[0].data();
    std::int32_t last = kUnreached;
    for (int cell = first; cell < first + kSide; ++cell) {
      last += along[cell];
      any = any || last < at[cell];
      last = at[cell] = std::min(at[cell], last);
    }
    for (int cell = first + kSide - 2; cell >= first; --cell) {
      last += along[cell + 1];
      any = any || last < at[cell];
      last = at[cell] = std::min(at[cell], last);
    }
  }
  return any || !hn::AllTrue(kInts, hn::Eq(lowered, hn::Zero(kInts)));
}

// After a sweep no step of its own direction lowers anything; so the first that changes nothing, either way, is the
// last.
template <class Any>
HWY_ATTR void spread_all(const Steps& steps, Any& costs) {
  sweep<true>(steps, costs);
  while (sweep<false>(steps, costs) && sweep<true>(steps, costs)) {
  }
}

HWY_ATTR void spread_one(const Steps& steps, Costs& costs) { spread_all(steps, costs); }
HWY_ATTR void spread_many(const Steps& steps, ManyCosts& costs) { spread_all(steps, costs); }

}  // namespace threewe::nav::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::nav::kernel {

HWY_EXPORT(set_all_costs);
HWY_EXPORT(spread_one);
HWY_EXPORT(spread_many);

void set_costs(Steps& steps) { HWY_DYNAMIC_DISPATCH(set_all_costs)(steps); }
void spread(const Steps& steps, Costs& costs) { HWY_DYNAMIC_DISPATCH(spread_one)(steps, costs); }
void spread(const Steps& steps, ManyCosts& costs) { HWY_DYNAMIC_DISPATCH(spread_many)(steps, costs); }

}  // namespace threewe::nav::kernel
#endif
