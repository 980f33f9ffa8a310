#include "perception/scan_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/exact.hpp"
#include "slam/range_noise_estimator.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::perception {
namespace {

constexpr std::ptrdiff_t kAside = 4;  // steps by which the turn may be off ...
constexpr std::ptrdiff_t kStep = 2;   // ... of so many beams

bool hits(const LaserScan& scan, std::size_t beam) {
  const auto range = static_cast<double>(scan.ranges[beam]);
  return range > 0.0 && range < scan.range_max;
}

// The same when the lidar turned by so many beams.
Shift shift_when_turned(const Params::Scan& params, const LaserScan& before, const LaserScan& scan,
                        std::ptrdiff_t turned) {
  const auto beams = static_cast<std::ptrdiff_t>(scan.ranges.size());
  std::vector<float> longer;
  longer.reserve(scan.ranges.size());
  for (std::ptrdiff_t i = 0; i < beams; ++i) {
    const auto then = static_cast<std::size_t>(((i + turned) % beams + beams) % beams);
    const auto now = static_cast<std::size_t>(i);
    if (hits(scan, now) && hits(before, then)) longer.push_back(scan.ranges[now] - before.ranges[then]);
  }
  if (longer.size() < static_cast<std::size_t>(params.fewest_beams)) return {};
  const auto middle = longer.begin() + static_cast<std::ptrdiff_t>(longer.size() / 2);
  std::nth_element(longer.begin(), middle, longer.end());
  const float median = *middle;
  const auto agree =
      std::ranges::count_if(longer, [&](float d) { return std::fabs(d - median) < static_cast<float>(params.agree); });
  return {static_cast<double>(median), static_cast<double>(agree) / static_cast<double>(longer.size())};
}

}  // namespace

Shift shift_between(const LaserScan& before, const LaserScan& scan, double turned, const Params::Scan& params) {
  const std::size_t n = scan.ranges.size();
  if (before.ranges.size() != n || n == 0) return {};
  const auto predicted = static_cast<std::ptrdiff_t>(std::floor(turned / scan.angle_increment + 0.5));
  Shift best;
  for (std::ptrdiff_t i = 0; i <= 2 * kAside; ++i) {
    // the predicted turn first, then ever farther from it
    const std::ptrdiff_t aside = i % 2 == 0 ? i / 2 : -(i + 1) / 2;
    const Shift found = shift_when_turned(params, before, scan, predicted + kStep * aside);
    if (found.share > best.share) best = found;
  }
  return best;
}

SensorFault ScanCheck::check(Time measured, const LaserScan& scan, const Pose2D& at) {
  const double noise = slam::range_noise_of(scan);
  const bool known = noise > 0.0;  // in the open too few beams hit anything
  if (known && usual_noise_ == 0.0) usual_noise_ = std::max(least_noise_, noise);  // as it is from the first
  if (known && noise > params_.noisy * usual_noise_) return SensorFault::noisy;

  View view{measured, scan, at};
  judge_shift(view);
  before_ = view;
  if (shift_ != 0.0) return SensorFault::shifted;

  if (known) usual_noise_ = std::max(least_noise_, usual_noise_ + params_.follows * (noise - usual_noise_));
  reference_ = std::move(view);
  return SensorFault::none;
}

// Shifted since the reference, or not any more.
void ScanCheck::judge_shift(const View& view) {
  const auto since = [&](const View& then) {
    return shift_between(then.scan, view.scan, wrap_angle(view.at.theta - then.at.theta), params_);
  };
  if (reference_.scan.ranges.empty() || view.stamp - reference_.stamp > params_.believed_after) shift_ = 0.0;
  if (reference_.scan.ranges.empty()) return;

  if (shift_ == 0.0) {
    const Shift shift = since(reference_);
    const double by_driving = distance(view.at.position(), reference_.at.position());
    if (shift.share >= params_.most_beams && std::fabs(shift.metres) > params_.shift + by_driving)
      shift_ = shift.metres;
    return;
  }
  // it is over when ranges jump back, which is plain to see once the robot stands
  const Shift back = since(before_);
  if (back.share >= params_.most_beams && std::fabs(back.metres + shift_) < params_.back * std::fabs(shift_))
    shift_ = 0.0;
}

}  // namespace threewe::perception
