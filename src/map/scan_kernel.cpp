// Lines are walked side by side, one in each lane; evidence is added to as many cells in a row as a vector has bytes.
#include "map/scan_kernel.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "map/scan_kernel.cpp"
#include "core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::map::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, 8>;
using D = hn::Vec<Doubles>;
constexpr std::size_t kLanes = hn::MaxLanes(Doubles());

// See walk_grid_line: the cell in which a line begins, the fraction of the line at which the next one begins, how much
// each takes, and how many steps are left.
struct Axis {
  D cell, next, step, left, sign;
};

HWY_INLINE Axis axis(D from, D to) {
  const Doubles d;
  const D zero = hn::Zero(d);
  const D one = hn::Set(d, 1.0);
  const D along = hn::Sub(to, from);
  const D cell = hn::Floor(from);
  const D step = hn::Div(one, hn::Abs(along));  // infinity where the line does not go along this axis
  const auto up = hn::Gt(along, zero);
  const D rest = hn::IfThenElse(up, hn::Sub(hn::Add(cell, one), from), hn::Sub(from, cell));
  const D next = hn::IfThenElse(hn::Eq(along, zero), step, hn::Mul(rest, step));
  return {cell, next, step, hn::Abs(hn::Sub(hn::Floor(to), cell)), hn::IfThenElse(up, one, hn::Neg(one))};
}

// A step along an axis in the lanes that go along it.
template <class M>
HWY_INLINE void go_on(M forward, Axis& axis) {
  const Doubles d;
  axis.next = hn::IfThenElse(forward, hn::Add(axis.next, axis.step), axis.next);
  axis.left = hn::Sub(axis.left, hn::IfThenElseZero(forward, hn::Set(d, 1.0)));
}

HWY_INLINE void mark_block(const std::array<std::array<double, kLanes>, 4>& ends, int width, std::uint8_t* marks) {
  const Doubles d;
  const D zero = hn::Zero(d);
  Axis x = axis(hn::LoadU(d, ends[0].data()), hn::LoadU(d, ends[2].data()));
  Axis y = axis(hn::LoadU(d, ends[1].data()), hn::LoadU(d, ends[3].data()));
  const D row = hn::Set(d, static_cast<double>(width));
  const D by_y = hn::Mul(y.sign, row);
  D index = hn::Add(hn::Mul(y.cell, row), x.cell);

  std::array<std::int32_t, kLanes> at{};
  const D steps = hn::Add(x.left, y.left);
  for (auto n = static_cast<int>(hn::GetLane(hn::MaxOfLanes(d, steps))); n >= 0; --n) {
    hn::StoreU(hn::DemoteTo(hn::Rebind<std::int32_t, Doubles>(), index), hn::Rebind<std::int32_t, Doubles>(),
               at.data());
    for (const std::int32_t i : at) marks[i] = kPassed;
    const auto y_over = hn::Le(y.left, zero);
    const auto along_x = hn::And(hn::Gt(x.left, zero), hn::Or(y_over, hn::Lt(x.next, y.next)));
    const auto along_y = hn::Not(hn::Or(along_x, y_over));
    index = hn::Add(index, hn::IfThenElse(along_x, x.sign, hn::IfThenElseZero(along_y, by_y)));
    go_on(along_x, x);
    go_on(along_y, y);
  }
}

void mark_all(std::span<const GridLine> lines, int width, std::uint8_t* marks) {
  for (std::size_t first = 0; first < lines.size(); first += kLanes) {
    std::array<std::array<double, kLanes>, 4> ends{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const GridLine& line = lines[std::min(first + lane, lines.size() - 1)];
      ends[0][lane] = line.from.x, ends[1][lane] = line.from.y;
      ends[2][lane] = line.to.x, ends[3][lane] = line.to.y;
    }
    mark_block(ends, width, marks);
  }
}

// A vector of cells, from `at` on.
template <class Tag>
HWY_INLINE void add_to_vector(Tag d, const Evidence& evidence, std::size_t at, std::uint8_t* marks,
                              std::int8_t* log_odds, std::vector<std::uint32_t>& changed) {
  const hn::RebindToSigned<Tag> i;
  const auto mark = hn::LoadU(d, marks + at);
  const auto seen = hn::Ne(mark, hn::Zero(d));
  if (hn::AllFalse(d, seen)) return;
  hn::StoreU(hn::Zero(d), d, marks + at);

  const auto hit = hn::RebindMask(i, hn::Eq(mark, hn::Set(d, kHit)));
  const auto before = hn::LoadU(i, log_odds + at);
  const auto sum = hn::SaturatedAdd(before, hn::IfThenElse(hit, hn::Set(i, evidence.hit), hn::Set(i, evidence.pass)));
  const auto beside_zero = hn::IfThenElse(hit, hn::Set(i, 1), hn::Set(i, -1));
  const auto known = hn::IfThenElse(hn::Eq(sum, hn::Zero(i)), beside_zero, sum);
  const auto clamped = hn::Min(hn::Max(known, hn::Set(i, evidence.min)), hn::Set(i, evidence.max));
  const auto after = hn::IfThenElse(hn::RebindMask(i, seen), clamped, before);
  hn::StoreU(after, i, log_odds + at);

  std::array<std::uint8_t, 8> bits{};
  hn::StoreMaskBits(i, hn::Or(hn::Ne(after, before), hit), bits.data());
  for (std::size_t byte = 0; byte < (hn::Lanes(d) + 7) / 8; ++byte) {
    for (unsigned rest = bits[byte]; rest != 0; rest &= rest - 1) {
      changed.push_back(static_cast<std::uint32_t>(at + 8 * byte) + static_cast<std::uint32_t>(std::countr_zero(rest)));
    }
  }
}

void add_to_all(const Evidence& evidence, std::size_t first, std::size_t last, std::span<std::uint8_t> marks,
                std::int8_t* log_odds, std::vector<std::uint32_t>& changed) {
  const hn::ScalableTag<std::uint8_t> many;
  const hn::CappedTag<std::uint8_t, 1> one;
  std::size_t at = first;
  for (; at < last && at + hn::Lanes(many) <= marks.size(); at += hn::Lanes(many)) {
    add_to_vector(many, evidence, at, marks.data(), log_odds, changed);
  }
  for (; at < last; ++at) add_to_vector(one, evidence, at, marks.data(), log_odds, changed);
}

}  // namespace threewe::map::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::map {
namespace {

HWY_EXPORT(mark_all);
HWY_EXPORT(add_to_all);

}  // namespace

void mark_passed(std::span<const GridLine> lines, int width, std::span<std::uint8_t> marks) {
  HWY_DYNAMIC_DISPATCH(mark_all)(lines, width, marks.data());
}

void add_evidence(const Evidence& evidence, std::size_t first, std::size_t last, std::span<std::uint8_t> marks,
                  std::span<std::int8_t> log_odds, std::vector<std::uint32_t>& changed) {
  assert(last <= marks.size() && marks.size() == log_odds.size());
  HWY_DYNAMIC_DISPATCH(add_to_all)(evidence, first, last, marks, log_odds.data(), changed);
}

}  // namespace threewe::map
#endif
