// A million random steps of learning environments in a generated scene, all that is observed held against its space:
//
//   verify_soak SEED full|limits
//
// Prints how many steps were taken, how many values were not within their spaces, and how many robots outside the
// walls.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "all_tasks.hpp"
#include "core/rng.hpp"
#include "number.hpp"
#include "threewe/scene/generator.hpp"

using namespace threewe;

namespace {

constexpr std::size_t kWorlds = 1024;
constexpr std::uint64_t kSteps = 1000;  // of each

env::Options options(std::uint64_t seed, env::Gate gate) {
  const auto one_of = [&](std::uint64_t sample, const auto& all) {
    return all[static_cast<std::size_t>(uniform({.seed = seed}, sample, 0, 0.0, static_cast<double>(all.size())))];
  };
  constexpr std::array<std::string_view, 4> kRandomizations{"none", "mild", "paper", "hard"};
  constexpr std::array<std::string_view, 2> kProfiles{"3we_standard_v2", "3we_depth_v2"};
  constexpr std::array kNoises{NoiseLevel::ideal, NoiseLevel::realistic};
  env::Options options;
  options.scenes = {std::make_shared<const scene::Scene>(
      scene::generate(seed, {.difficulty = uniform({.seed = seed}, 0, 0, 0.0, 1.0)}))};
  options.task = one_of(1, all_tasks());
  options.randomization = models::load_randomization(one_of(2, kRandomizations));
  options.hardware = with_noise(load_profile(one_of(3, kProfiles)), one_of(4, kNoises));
  options.localization_model = models::load_localization("slam_v2");
  options.gate = gate;
  options.worlds = kWorlds;
  return options;
}

template <class T>
std::size_t outside(const env::Array& array) {
  const std::span values(reinterpret_cast<const T*>(array.data.data()), array.data.size() / sizeof(T));
  return static_cast<std::size_t>(std::ranges::count_if(values, [&](T value) {
    const auto number = static_cast<double>(value);
    const bool within = number >= array.field.low && number <= array.field.high;  // what is no number is not
    return !within;
  }));
}

std::size_t outside(const env::Batch& batch) {
  std::size_t count = 0;
  for (const env::Array& array : batch.observations()) {
    switch (array.field.type) {
      case task::Field::Type::uint8: count += outside<std::uint8_t>(array); break;
      case task::Field::Type::int32: count += outside<std::int32_t>(array); break;
      case task::Field::Type::float32: count += outside<float>(array); break;
    }
  }
  for (const double reward : batch.rewards()) count += std::isfinite(reward) ? 0U : 1U;
  return count;
}

std::size_t escaped(const env::Batch& batch, const scene::Scene& scene) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < batch.rows(); ++i) {
    const double x = batch.true_poses()[3 * i];
    const double y = batch.true_poses()[3 * i + 1];
    const bool within = x >= scene.min.x && x <= scene.max.x && y >= scene.min.y && y <= scene.max.y;
    count += within ? 0U : 1U;
  }
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 3 ? argv[1] : "");
  const std::string_view gate = argc == 3 ? argv[2] : "";
  if (!seed || (gate != "full" && gate != "limits")) {
    std::fputs("usage: verify_soak SEED full|limits\n", stderr);
    return 2;
  }
  env::Batch batch(options(*seed, gate == "full" ? env::Gate::full : env::Gate::limits));
  std::vector<env::Reset> resets(kWorlds);
  for (std::size_t i = 0; i < kWorlds; ++i) resets[i] = {.seed = *seed + i};
  batch.reset(resets);
  std::vector<float> actions(3 * kWorlds);
  std::size_t bad = outside(batch);
  std::size_t out = 0;
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    if (step % 10 == 0) {
      for (std::uint32_t i = 0; i < actions.size(); ++i) {
        actions[i] = static_cast<float>(uniform({.seed = *seed}, 10 + step, i, -1.0, 1.0));
      }
    }
    batch.step(actions);
    bad += outside(batch);
    out += escaped(batch, *batch.options().scenes[0]);
  }
  std::printf("steps=%zu bad=%zu escaped=%zu\n", static_cast<std::size_t>(kSteps) * kWorlds, bad, out);
  return 0;
}
