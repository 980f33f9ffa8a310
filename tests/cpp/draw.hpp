// Random cases. A test that draws them captures its seed, so that a failure prints it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Whether the code is compiled with sanitizers, which make it some twenty times as slow.
#ifdef __SANITIZE_ADDRESS__
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// How many random cases a test takes; a tenth with sanitizers.
constexpr std::uint64_t cases(std::uint64_t count) {
  return kSanitized ? std::max<std::uint64_t>(count / 10, 1) : count;
}

/// Draws numbers that are the same with every standard library.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}
  /// Uniform in [low, high).
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  /// Each of low ... high equally often.
  int whole(int low, int high) {
    return low + static_cast<int>(bits_() % static_cast<unsigned>(std::max(high - low + 1, 1)));
  }
  /// Both coordinates uniform in [low, high).
  Vec2 point(double low, double high) {
    const double x = (*this)(low, high);
    return {x, (*this)(low, high)};
  }
  /// The same, and any heading.
  Pose2D pose(double low, double high) {
    const Vec2 position = point(low, high);
    return {position.x, position.y, wrap_angle((*this)(-7.0, 7.0))};
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace threewe
