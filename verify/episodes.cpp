// Ten seconds of learning environments, every task with everything on, told as a hash of all that is observed, rewarded
// and measured in them:
//
//   verify_episodes SEED    on every vector target that this machine has
//
// One line a target, and its hash. All should be equal.
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "all_tasks.hpp"
#include "core/rng.hpp"
#include "core/targets.hpp"
#include "hash.hpp"
#include "number.hpp"
#include "threewe/scene/generator.hpp"

using namespace threewe;

namespace {

constexpr int kSteps = 100;  // of 0.1 s
constexpr std::size_t kWorlds = 4;

env::Options options(const env::TaskFactory& task, std::uint64_t seed) {
  env::Options options;
  options.scenes = {std::make_shared<const scene::Scene>(scene::generate(seed, {}))};
  options.task = task;
  options.hardware = load_profile("3we_depth_v2");
  options.observed.image = options.observed.depth = true;
  options.localization_model = models::load_localization("slam_v2");
  options.randomization = models::load_randomization("hard");
  options.max_steps = kSteps * 2 / 5;  // so that each world begins a third episode
  options.worlds = kWorlds;
  options.autoreset = env::Autoreset::same_step;
  return options;
}

std::uint64_t play(env::Batch& batch, std::uint64_t seed) {
  Hash hash;
  const auto look = [&] {
    for (const env::Array& array : batch.observations()) hash.add(std::span(array.data));
    hash.add(batch.rewards());
    hash.add(batch.terminated());
    hash.add(batch.metrics());
    hash.add(batch.true_poses());
  };
  std::vector<env::Reset> resets(kWorlds);
  for (std::size_t i = 0; i < kWorlds; ++i) resets[i] = {.seed = seed + i, .episode = 0};
  batch.reset(resets);
  look();
  std::vector<float> actions(3 * kWorlds);
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    for (std::uint32_t i = 0; i < actions.size(); ++i) {
      actions[i] = static_cast<float>(uniform({.seed = seed}, step / 10, i, -1.0, 1.0));
    }
    batch.step(actions);
    look();
  }
  return hash.value();
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 2 ? argv[1] : "");
  if (!seed) {
    std::fputs("usage: verify_episodes SEED\n", stderr);
    return 2;
  }
  std::map<std::string, Hash> found;
  for (const env::TaskFactory& task : all_tasks()) {
    env::Batch batch(options(task, *seed));
    for (const std::string& target : available_targets()) {
      force_target(target);
      found[target].add(play(batch, *seed));
    }
  }
  for (const auto& [target, hash] : found) print_hash(target, hash.value());
  return 0;
}
