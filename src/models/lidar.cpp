#include "models/lidar.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory_resource>
#include <vector>

#include "core/exact.hpp"
#include "models/lidar_noise.hpp"

namespace threewe::models {

ScanPattern scan_pattern(const LidarSpec& spec) {
  constexpr double kTurn = 2.0 * exact::kPi;
  // from the edge behind beam 0 (counter-clockwise) or beyond the last beam (clockwise), half a point inwards
  const double edge = -exact::kPi - 0.5 * kTurn / spec.beams;
  const double inwards = 0.5 * kTurn / spec.points_per_turn;
  if (spec.clockwise) return {edge + kTurn - inwards, -kTurn / spec.points_per_turn};
  return {edge + inwards, kTurn / spec.points_per_turn};
}

double lidar_bias(const LidarSpec& spec, const RngKey& key) {
  RngKey episode = key;
  episode.stream = Stream::episode;
  return uniform(episode, static_cast<std::uint64_t>(Stream::lidar), 0, -spec.bias, spec.bias);
}

void measure_ranges(const LidarSpec& spec, const RngKey& key, double bias, std::uint64_t first, std::span<float> ranges,
                    const Variation& variation) {
  add_noise(key, first,
            {.bias = static_cast<float>(variation.lidar_noise * bias),
             .sigma = static_cast<float>(variation.lidar_noise * spec.sigma),
             .dropout = static_cast<float>(variation.lidar_dropout * spec.dropout),
             .near = static_cast<float>(spec.range_min),
             .far = static_cast<float>(spec.range_max)},
            ranges);
}

double most_too_short(const LidarSpec& spec, double bias, const Variation& variation) {
  constexpr double kMostDeviations = 5.8;  // of `add_noise`: sqrt(-2 ln 2^-24)
  return variation.lidar_noise * (kMostDeviations * spec.sigma + std::max(-bias, 0.0)) + 1e-5;
}

bool drops_neighbours(const LidarSpec& spec, const RngKey& key, std::uint64_t first, const Variation& variation) {
  const auto dropout = static_cast<float>(variation.lidar_dropout * spec.dropout);
  if (!(dropout > 0.0F)) return false;
  const auto points = static_cast<std::size_t>(spec.points_per_turn);
  alignas(std::size_t) std::array<std::byte, 2048> room;  // NOLINT: what is used is filled
  std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
  std::pmr::vector<std::size_t> dropped(&memory);
  dropped.reserve(room.size() / sizeof(std::size_t));
  append_dropped_points(key, first, points, dropout, dropped);
  for (std::size_t i = 0; i < dropped.size() && dropped[i] < 2; ++i) dropped.push_back(dropped[i] + points);
  for (std::size_t i = 2; i < dropped.size(); ++i) {
    if (dropped[i] == dropped[i - 2] + 2) return true;
  }
  return false;
}

std::vector<PointBeams> beams_of_points(const LidarSpec& spec) {
  const auto beams = static_cast<std::size_t>(spec.beams);
  const auto points = static_cast<std::size_t>(spec.points_per_turn);
  const auto beam = [&](std::size_t i) { return static_cast<std::uint16_t>(spec.clockwise ? beams - 1 - i : i); };
  std::vector<PointBeams> counts_for(points);
  for (std::size_t k = 0; k < points; ++k) {
    // point k sits at (k + 1/2) / points of the turn; one on the edge of two beams counts for both, since to give all
    // such points to beams on one side would turn what is seen
    const std::size_t place = (2 * k + 1) * beams;
    const std::size_t turn = 2 * points;
    counts_for[k] = {beam((place - 1) / turn), beam(place / turn)};
  }
  return counts_for;
}

void fill_scan(std::span<const PointBeams> beams_of_points, std::span<const float> points, std::span<float> ranges) {
  // nothing is farther than any return; 0 beams hold no point yet, or only invalid ones
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  std::ranges::fill(ranges, kNothing);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const float range = points[k] == 0.0F ? kNothing : points[k];
    const auto [first, second] = beams_of_points[k];
    ranges[first] = std::min(ranges[first], range);
    if (second != first) ranges[second] = std::min(ranges[second], range);
  }
  for (float& range : ranges) range = range == kNothing ? 0.0F : range;
}

LaserScan make_scan(const LidarSpec& spec, std::span<const float> points) {
  const auto beams = static_cast<std::size_t>(spec.beams);
  LaserScan scan;
  scan.angle_min = -exact::kPi;
  scan.angle_increment = 2.0 * exact::kPi / spec.beams;
  scan.time_increment = 0.0;
  if (spec.rolling) scan.time_increment = (spec.clockwise ? -1.0 : 1.0) * to_seconds(spec.turn) / spec.beams;
  scan.range_min = spec.range_min;
  scan.range_max = spec.range_max;

  scan.ranges.resize(beams);
  fill_scan(beams_of_points(spec), points, scan.ranges);
  return scan;
}

Time scan_time(const LidarSpec& spec, Time turn_begin) {
  if (!spec.rolling) return turn_begin + spec.turn;
  // beam 0's middle is half a beam from the edge where the turn begins (counter-clockwise) or ends (clockwise), and the
  // first point, half a point from that edge, is taken as the turn begins
  const std::int64_t turn = spec.turn.count();
  const std::int64_t beams = spec.beams;
  const std::int64_t points = spec.points_per_turn;
  const std::int64_t half_beams = spec.clockwise ? 2 * beams - 1 : 1;
  // turn * (half_beams / (2 beams) - 1 / (2 points)), rounded to the nearest nanosecond; never negative, as a turn has
  // at least as many points as beams
  const std::int64_t numerator = turn * (half_beams * points - beams);
  const std::int64_t denominator = 2 * beams * points;
  return turn_begin + Duration((2 * numerator + denominator) / (2 * denominator));
}

}  // namespace threewe::models
