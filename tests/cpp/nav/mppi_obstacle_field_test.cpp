// The obstacle nearest to the outline at each cell and heading, against a look at all of them, with any vectors.
#include "nav/mppi/obstacle_field.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/targets.hpp"
#include "draw.hpp"

namespace threewe::nav::mppi {
namespace {

struct Case {
  double length, width, reach, sight;  // [m]
  std::vector<Vec2> obstacles;
  Vec2 middle, low, high;
};

Case draw_case(std::uint64_t seed) {
  Draw draw(seed);
  Case c{draw(0.1, 0.5), draw(0.1, 0.4), draw(0.8, 2.5), draw(0.02, 0.2), {}, draw.point(-20.0, 20.0), {}, {}};
  c.low = c.middle - Vec2{draw(0.0, c.reach), draw(0.0, c.reach)};
  c.high = c.middle + Vec2{draw(0.0, c.reach), draw(0.0, c.reach)};
  for (int i = draw.whole(0, 12); i > 0; --i) {
    // some alone, some in a row
    Vec2 p = c.middle + draw.point(-1.3 * c.reach, 1.3 * c.reach);
    const Vec2 step = draw.point(-0.04, 0.04);
    for (int k = draw.whole(1, 8); k > 0; --k, p = p + step) c.obstacles.push_back(p);
  }
  return c;
}

// For each heading, row and column of the window, by the book.
class SlowTwin {
 public:
  SlowTwin(const Case& c, double unit)
      : half_length_(static_cast<float>(0.5 * c.length)),
        half_width_(static_cast<float>(0.5 * c.width)),
        sight_(static_cast<float>(c.sight)) {
    const double cell = std::max(Params{}.follower.step, c.reach / (0.5 * kSide - 1.0));
    cell_ = static_cast<float>(cell);
    Vec2 last{1e9, 1e9};
    for (const Vec2 p : c.obstacles) {
      if (distance(p, last) < Params{}.follower.thinning) continue;
      last = p;
      const auto x = static_cast<float>(p.x - c.middle.x + 0.5 * kSide * cell);
      const auto y = static_cast<float>(p.y - c.middle.y + 0.5 * kSide * cell);
      const auto in_units = [&](float along) {
        return static_cast<int>(std::lround((static_cast<double>(along) - 0.5 * kSide * cell) / unit));
      };
      stamps_.push_back({x, y, pack(in_units(x), in_units(y))});
    }
  }
  std::int32_t nearest(int bin, int row, int column) const {
    const exact::SinCos heading = exact::sincos((bin + 0.5) * exact::kPi / kBins);
    const auto sin = static_cast<float>(heading.sin);
    const auto cos = static_cast<float>(heading.cos);
    auto found = kNothing;
    float least = sight_ * sight_;
    for (const Stamp& stamp : stamps_) {
      const float dx = stamp.x - (static_cast<float>(column) + 0.5F) * cell_;
      const float dy = stamp.y - (static_cast<float>(row) + 0.5F) * cell_;
      const float x = std::fabs(cos * dx + sin * dy) - half_length_;
      const float y = std::fabs(cos * dy - sin * dx) - half_width_;
      const float out_x = std::max(x, 0.0F);
      const float out_y = std::max(y, 0.0F);
      const float away = (out_x * out_x + out_y * out_y) + std::min(std::max(x, y), 0.0F);
      if (away >= least) continue;
      least = away;
      found = stamp.packed;
    }
    return found;
  }

 private:
  float half_length_, half_width_, sight_;
  float cell_ = 0.0F;
  std::vector<Stamp> stamps_;
};

TEST_CASE("each cell and heading knows the obstacle that is nearest to the outline") {
  long seen = 0;
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    const Case c = draw_case(seed);
    ObstacleField field(Footprint::rectangle(c.length, c.width), c.reach, c.sight, {});
    const SlowTwin twin(c, field.unit());
    std::vector<std::int32_t> expected;
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      field.update(c.obstacles, c.middle, c.low, c.high);
      const FieldView view = field.view();
      std::vector<std::int32_t> found;
      const bool first = expected.empty();
      for (int bin = 0; bin < kBins; ++bin) {
        for (int row = static_cast<int>(view.first_row); row <= static_cast<int>(view.last_row); ++row) {
          for (int column = static_cast<int>(view.first_column); column <= static_cast<int>(view.last_column);
               ++column) {
            found.push_back(view.cells[(bin * kSide + row) * kSide + column]);
            if (first) expected.push_back(twin.nearest(bin, row, column));
          }
        }
      }
      REQUIRE(found == expected);
    }
    force_target("");
    seen += std::ranges::count_if(expected, [](std::int32_t packed) { return packed != kNothing; });
  }
  CHECK(seen > static_cast<long>(cases(100'000)));
}

}  // namespace
}  // namespace threewe::nav::mppi
