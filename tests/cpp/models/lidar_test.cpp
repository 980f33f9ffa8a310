#include "models/lidar.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/targets.hpp"
#include "draw.hpp"

using namespace threewe;
using namespace threewe::models;

namespace {

LidarSpec ld06() { return *load_profile("3we_standard_v2").lidar; }

LidarSpec perfect(LidarSpec spec) {
  spec.sigma = spec.bias = spec.dropout = 0.0;
  return spec;
}

// The oracle of the resampling: for each beam, every point whose angle lies within half an increment; one on the edge
// between two beams counts for both.
std::vector<float> slow_resample(const LidarSpec& spec, const std::vector<float>& points) {
  const ScanPattern pattern = scan_pattern(spec);
  const double increment = 2.0 * M_PI / spec.beams;
  std::vector<float> beams;
  for (int i = 0; i < spec.beams; ++i) {
    const double angle = -M_PI + i * increment;
    bool any_return = false;
    bool any_far = false;
    float nearest = 0.0F;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double apart =
          std::remainder(pattern.first_angle + static_cast<double>(k) * pattern.angle_step - angle, 2.0 * M_PI);
      if (std::fabs(apart) > 0.5 * increment + 1e-9 || points[k] == 0.0F) continue;
      if (points[k] >= static_cast<float>(spec.range_max)) {
        any_far = true;
      } else if (!any_return || points[k] < nearest) {
        any_return = true;
        nearest = points[k];
      }
    }
    beams.push_back(any_return ? nearest : any_far ? static_cast<float>(spec.range_max) : 0.0F);
  }
  return beams;
}

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};

Statistics statistics(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / n)};
}

}  // namespace

TEST_CASE("450 clockwise points become 360 counter-clockwise beams: the nearest return of each degree") {
  const LidarSpec spec = ld06();
  const RngKey key{.seed = 5};
  for (std::uint64_t round = 0; round < 200; ++round) {
    CAPTURE(round);
    std::vector<float> points;
    for (std::uint32_t k = 0; k < 450; ++k) {
      const double kind = uniform(key, round, k);
      points.push_back(kind < 0.3   ? 0.0F
                       : kind < 0.6 ? 12.0F
                                    : static_cast<float>(uniform(key, round, 1000 + k, 0.02, 11.9)));
    }
    CHECK(make_scan(spec, points).ranges == slow_resample(spec, points));
  }
}

TEST_CASE("resampling, for other devices too") {
  LidarSpec spec = ld06();
  for (const auto& [points_per_turn, beams] : {std::pair{450, 360}, {230, 230}, {360, 360}, {460, 360}, {7, 5}}) {
    for (const bool clockwise : {true, false}) {
      CAPTURE(points_per_turn);
      CAPTURE(clockwise);
      spec.points_per_turn = points_per_turn;
      spec.beams = beams;
      spec.clockwise = clockwise;
      std::vector<float> points;
      points.reserve(static_cast<std::size_t>(points_per_turn));
      for (int k = 0; k < points_per_turn; ++k) points.push_back(1.0F + 0.01F * static_cast<float>((k * 37) % 101));
      const LaserScan scan = make_scan(spec, points);
      CHECK(scan.ranges == slow_resample(spec, points));
      // at least one point falls into each beam
      for (const float range : scan.ranges) CHECK(range > 0.0F);
    }
  }
}

TEST_CASE("resampling turns nothing: a place and its mirror image are seen as mirror images") {
  for (const auto& [points_per_turn, beams] : {std::pair{450, 360}, {360, 360}, {500, 72}, {7, 5}}) {
    CAPTURE(points_per_turn);
    LidarSpec spec = ld06();
    spec.points_per_turn = points_per_turn;
    spec.beams = beams;
    std::vector<float> points;
    for (int k = 0; k < points_per_turn; ++k) points.push_back(1.0F + 0.01F * static_cast<float>((k * 37) % 101));
    std::vector<float> seen = make_scan(spec, points).ranges;
    std::ranges::reverse(points);
    std::ranges::reverse(seen);
    CHECK(make_scan(spec, points).ranges == seen);
  }
}

TEST_CASE("a beam: nearest of its returns, range_max for no-returns alone, 0 when all were invalid") {
  LidarSpec spec = ld06();
  spec.points_per_turn = 8;
  spec.beams = 4;
  spec.clockwise = false;
  const std::vector<float> points{2.0F, 1.0F, 12.0F, 3.0F, 0.0F, 12.0F, 0.0F, 0.0F};
  CHECK(make_scan(spec, points).ranges == std::vector<float>{1.0F, 3.0F, 12.0F, 0.0F});
  spec.clockwise = true;
  CHECK(make_scan(spec, points).ranges == std::vector<float>{0.0F, 12.0F, 3.0F, 1.0F});
}

TEST_CASE("the scan is uniform and counter-clockwise from -pi") {
  const LidarSpec spec = ld06();
  const LaserScan scan = make_scan(spec, std::vector<float>(450, 1.0F));
  CHECK(scan.angle_min == -exact::kPi);
  CHECK(scan.angle_increment == doctest::Approx(M_PI / 180));
  CHECK(scan.ranges.size() == 360);
  CHECK(scan.range_min == 0.02);
  CHECK(scan.range_max == 12.0);
  CHECK(scan.time_increment == doctest::Approx(-0.1 / 360));
}

TEST_CASE("each beam is stamped with the time at which the device pointed along it") {
  for (const bool clockwise : {true, false}) {
    for (const int points_per_turn : {450, 360}) {
      CAPTURE(clockwise);
      CAPTURE(points_per_turn);
      LidarSpec spec = ld06();
      spec.clockwise = clockwise;
      spec.points_per_turn = points_per_turn;
      const ScanPattern pattern = scan_pattern(spec);
      const LaserScan scan = make_scan(spec, std::vector<float>(static_cast<std::size_t>(points_per_turn), 1.0F));
      const Time begin = 700ms;
      const double beam0 = to_seconds(scan_time(spec, begin));
      for (int i = 0; i < 360; ++i) {
        // where the device points at that time, by its constant speed
        const double seconds = beam0 + i * scan.time_increment - to_seconds(begin);
        const double turned = pattern.first_angle + (clockwise ? -1.0 : 1.0) * 2.0 * M_PI * seconds / 0.1;
        CHECK(std::remainder(turned - (scan.angle_min + i * scan.angle_increment), 2 * M_PI) ==
              doctest::Approx(0.0).epsilon(1e-6).scale(1.0));
        CHECK(seconds > -1e-9);
        CHECK(seconds < 0.1);
      }
    }
  }
  // written out once: the last point of 450 is taken 100/450 ms before the end of the turn, half a point before the
  // edge, half a beam before which lies beam 0
  CHECK(scan_time(ld06(), 0ms) == Time(99'750'000));
}

TEST_CASE("a scan taken at one time carries the time of the turn's end") {
  LidarSpec spec = ld06();
  spec.rolling = false;
  CHECK(scan_time(spec, 300ms) == 400ms);
  CHECK(make_scan(spec, std::vector<float>(450, 1.0F)).time_increment == 0.0);
}

TEST_CASE("a perfect lidar changes nothing but what is out of range") {
  const LidarSpec spec = perfect(ld06());
  std::vector<float> ranges{0.01F, 0.02F, 5.0F, 11.999F, 12.0F};
  measure_ranges(spec, {}, 0.0, 0, ranges);
  CHECK(ranges == std::vector<float>{0.0F, 0.02F, 5.0F, 11.999F, 12.0F});
}

TEST_CASE("scatter, bias and dropouts have the stated distributions, and each switch changes that one thing") {
  constexpr std::size_t kCount = 200'000;
  const RngKey key{.seed = 77, .stream = Stream::lidar};
  const auto measure = [&](const LidarSpec& spec, double bias) {
    std::vector<float> ranges(kCount, 4.0F);
    measure_ranges(spec, key, bias, 0, ranges);
    return ranges;
  };
  const LidarSpec real = ld06();
  LidarSpec no_dropout = real;
  no_dropout.dropout = 0.0;
  LidarSpec no_scatter = real;
  no_scatter.sigma = 0.0;

  // scatter alone: 10 mm around the truth
  std::vector<double> errors;
  for (const float range : measure(no_dropout, 0.0)) errors.push_back(static_cast<double>(range) - 4.0);
  const Statistics scatter = statistics(errors);
  CHECK(std::fabs(scatter.mean) < 5 * 0.01 / std::sqrt(kCount));
  CHECK(scatter.deviation == doctest::Approx(0.01).epsilon(0.01));
  std::size_t within = 0;
  for (const double error : errors) within += std::fabs(error) < 0.01 ? 1 : 0;
  CHECK(static_cast<double>(within) / kCount == doctest::Approx(0.6827).epsilon(0.01));

  // dropouts are 1 %, and the points that stay are those without dropouts
  const auto all = measure(real, 0.0);
  const auto kept = measure(no_dropout, 0.0);
  std::size_t lost = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (all[i] == 0.0F) {
      ++lost;
    } else {
      CHECK(all[i] == kept[i]);
    }
  }
  CHECK(static_cast<double>(lost) / kCount == doctest::Approx(0.01).epsilon(0.1));

  // without scatter the same points drop out, and the others are exact
  const auto clean = measure(no_scatter, 0.0);
  for (std::size_t i = 0; i < kCount; ++i) CHECK(clean[i] == (all[i] == 0.0F ? 0.0F : 4.0F));

  // the bias moves every range by itself
  const auto biased = measure(no_dropout, 0.02);
  for (std::size_t i = 0; i < 1000; ++i) {
    CHECK(static_cast<double>(biased[i] - kept[i]) == doctest::Approx(0.02).epsilon(1e-4));
  }
}

// Scatter and fate of one point, in double precision, as `measure_ranges` draws them.
struct SlowDraw {
  double scatter;
  std::uint32_t fate;
};
SlowDraw draw_slowly(const RngKey& key, std::uint64_t point) {
  const auto words = random_bits(key, point / 2);
  const auto share = [](std::uint32_t word) { return ((word >> 9) + 0.5) * 0x1p-23; };
  const double size = std::sqrt(-2.0 * std::log(share(words[0])));
  const double angle = 2.0 * exact::kPi * share(words[1]);
  return {size * (point % 2 ? std::sin(angle) : std::cos(angle)), words[2 + point % 2] >> 8};
}

TEST_CASE("many points at once are measured as one after the other, with the same bits on every target") {
  // as wide as the range, so that each bit of the scatter counts, and from where sample numbers leave 32 bits
  LidarSpec wide = ld06();
  wide.sigma = 3.0;
  wide.range_min = -100.0;
  for (const LidarSpec& spec : {ld06(), wide, perfect(ld06())}) {
    for (const std::uint64_t first : {std::uint64_t{0}, (std::uint64_t{1} << 33) - 20'001}) {
      const RngKey key{.seed = 0x123456789abcdef0U + first, .episode = 7, .robot = 3, .stream = Stream::lidar};
      std::vector<float> truth(40'001);
      for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = static_cast<float>(i % 1250) * 0.01F;
      const double bias = spec.bias / 3.0;
      const auto measure = [&] {
        std::vector<float> ranges = truth;
        measure_ranges(spec, key, bias, first, ranges);
        return ranges;
      };
      const std::vector<float> ranges = measure();
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const auto [scatter, fate] = draw_slowly(key, first + i);
        const double moved = static_cast<double>(truth[i]) + bias + spec.sigma * scatter;
        const double measured = static_cast<double>(truth[i]) < spec.range_max ? std::min(moved, spec.range_max) : 12.0;
        if (std::fabs(measured - spec.range_min) < 1e-5) continue;  // either is right
        const bool lost = fate < spec.dropout * 0x1p24 || measured < spec.range_min;
        const double error = static_cast<double>(ranges[i]) - (lost ? 0.0 : measured);
        wrong += std::fabs(error) > 2e-6 + 3e-6 * spec.sigma ? 1 : 0;
      }
      CHECK(wrong == 0);
      for (const std::string& target : available_targets()) {
        CAPTURE(target);
        force_target(target);
        CHECK(measure() == ranges);
      }
      force_target("");
    }
  }
}

TEST_CASE("without scatter and dropouts any number of points is measured to the bit as one by one") {
  LidarSpec spec = perfect(ld06());
  for (const float bias : {0.0F, 0.0123F, -0.03F}) {
    for (std::size_t count = 1; count < 70; ++count) {
      std::vector<float> ranges(count);
      for (std::size_t i = 0; i < count; ++i) ranges[i] = 0.0171F * static_cast<float>((i * 97 + count * 31) % 710);
      ranges[count / 2] = 12.0F;
      std::vector<float> slow = ranges;
      for (float& range : slow) {
        const float measured = range >= 12.0F ? 12.0F : std::min(range + bias, 12.0F);
        range = measured < static_cast<float>(spec.range_min) ? 0.0F : measured;
      }
      for (const std::string& target : available_targets()) {
        CAPTURE(target);
        force_target(target);
        std::vector<float> fast = ranges;
        measure_ranges(spec, {}, static_cast<double>(bias), 7, fast);
        CHECK(fast == slow);
      }
      force_target("");
    }
  }
}

TEST_CASE("which points are dropped, and how much too short one is, is known without measuring") {
  LidarSpec spec = ld06();
  int dropping = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    spec.points_per_turn = draw.whole(4, 450);
    spec.dropout = draw(0.0, 0.3);
    const Variation variation{.lidar_noise = draw(0.0, 2.0), .lidar_dropout = draw(0.0, 1.5)};
    const RngKey key{.seed = seed, .episode = 2, .stream = Stream::lidar};
    const auto points = static_cast<std::size_t>(spec.points_per_turn);
    const std::uint64_t first = seed % 5 * points;
    const double bias = lidar_bias(spec, key);
    std::vector<float> ranges(points, 3.0F);
    measure_ranges(spec, key, bias, first, ranges, variation);
    bool together = false;
    double worst = 0.0;
    for (std::size_t i = 0; i < points; ++i) {
      if (ranges[i] > 0.0F) worst = std::max(worst, 3.0 - static_cast<double>(ranges[i]));
      together =
          together || (ranges[i] == 0.0F && ranges[(i + 1) % points] == 0.0F && ranges[(i + 2) % points] == 0.0F);
    }
    CHECK(worst <= most_too_short(spec, bias, variation));
    dropping += together ? 1 : 0;
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      CHECK(drops_neighbours(spec, key, first, variation) == together);
    }
    force_target("");
  }
  CHECK(dropping > 40);
}

TEST_CASE("noise depends on the point alone, not on how the points are grouped") {
  const LidarSpec spec = ld06();
  const RngKey key{.seed = 3, .stream = Stream::lidar};
  std::vector<float> whole(450, 3.0F);
  measure_ranges(spec, key, 0.01, 900, whole);
  std::vector<float> parts(450, 3.0F);
  for (std::size_t first = 0; first < 450; first += 45) {
    measure_ranges(spec, key, 0.01, 900 + first, std::span(parts).subspan(first, 45));  // whose ends cut pairs in two
  }
  CHECK(parts == whole);
}

TEST_CASE("each unit's bias is drawn once per episode, within its bounds") {
  const LidarSpec spec = ld06();
  std::vector<double> biases;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    const RngKey key{.seed = seed, .stream = Stream::lidar};
    biases.push_back(lidar_bias(spec, key));
    CHECK(std::fabs(biases.back()) <= 0.03);
    CHECK(lidar_bias(spec, key) == biases.back());
  }
  const Statistics found = statistics(biases);
  CHECK(std::fabs(found.mean) < 0.002);
  CHECK(found.deviation == doctest::Approx(0.03 / std::sqrt(3.0)).epsilon(0.05));
}
