#include "threewe/slam/localizer.hpp"

#include <algorithm>

#include "core/exact.hpp"

namespace threewe::slam {

double PoseEstimate::position_uncertainty() const {
  // 95 % quantiles of chi-square with one and two degrees of freedom: exact for an error along one axis and for one
  // alike in all directions; in between the probability is 95.0 to 95.8 %
  constexpr double kOneAxis = 3.8415;
  constexpr double kTwoAxes = 5.9915;
  const double mean = 0.5 * (covariance[0] + covariance[4]);
  const double half = exact::hypot(0.5 * (covariance[0] - covariance[4]), covariance[1]);
  return exact::sqrt(kOneAxis * (mean + half) + (kTwoAxes - kOneAxis) * std::max(mean - half, 0.0));
}

}  // namespace threewe::slam
