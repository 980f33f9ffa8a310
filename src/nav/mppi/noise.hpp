// Noise that is drawn once and used again from other places of the pool at each tick.
#pragma once

#include <vector>

#include "nav/mppi/rollout.hpp"

namespace threewe::nav::mppi {

/// (kNoiseRows + kSteps, kBlock): sixteen sequences of normal deviates whose neighbours in time are alike, so that a
/// sample keeps to what it tries. Every pool is this one.
const std::vector<float>& noise_pool();

/// Which variations of its mean plans a tick tries: rows of the pool, drawn for (`seed`, `tick`), and the sign of their
/// noise. Most vary the first mean; every eighth block is one of `means` others in turn, and the first of them all is
/// small, so that the plan itself is among the samples.
std::vector<Block> draw_blocks(int samples, std::uint32_t means, const std::array<float, 3>& deviation,
                               std::uint64_t seed, std::uint64_t tick);

}  // namespace threewe::nav::mppi
