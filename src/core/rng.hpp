// Counter-based random numbers: noise is a pure function of where it is used, so that switching one sensor off changes
// no other.
#pragma once

#include <array>
#include <cstdint>

namespace threewe {

/// Who draws. Every independent source of randomness has its own stream; the order is part of the recorded format.
enum class Stream : std::uint32_t {
  episode,  // draws made once per episode: biases, scales, start poses
  lidar,
  imu,
  odometry,
  motor,
  ultrasonic,
  camera,
  battery,
  people,
  scene,
  sampler,
  localization,
  randomization,
};

/// Names one sequence of random numbers.
struct RngKey {
  std::uint64_t seed = 0;
  std::uint32_t episode = 0;
  std::uint16_t robot = 0;
  std::uint16_t sensor = 0;  ///< which of several sensors of one kind
  Stream stream = Stream::episode;
  friend bool operator==(const RngKey&, const RngKey&) = default;

  /// All but seed and episode in one word: robot 12 bits, sensor 12, stream 8.
  std::uint32_t place() const {
    return (robot & 0xFFFU) << 20 | (sensor & 0xFFFU) << 8 | (static_cast<std::uint32_t>(stream) & 0xFFU);
  }
};

/// Four random words for (`key`, `sample`, `lane`): Philox4x32-10 (Salmon et al. 2011), a bijection of its counter.
std::array<std::uint32_t, 4> random_bits(const RngKey& key, std::uint64_t sample, std::uint32_t lane = 0);

/// Uniform in [0, 1), 53 random bits.
double uniform(const RngKey& key, std::uint64_t sample, std::uint32_t lane = 0);
/// Uniform in [low, high).
double uniform(const RngKey& key, std::uint64_t sample, std::uint32_t lane, double low, double high);
/// Standard normal, by the inverse distribution function (Wichura 1988, AS 241).
double normal(const RngKey& key, std::uint64_t sample, std::uint32_t lane = 0);

/// The quantile of the standard normal distribution at `p` in (0, 1) (Wichura 1988, AS 241; 1e-16 relative).
double normal_quantile(double p);

}  // namespace threewe
