// Learn: many environments at once, and a policy to beat, which drives in the free direction nearest to the goal's.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include "threewe/env/batch.hpp"
#include "threewe/task/tasks.hpp"
#include "threewe/threewe.hpp"

namespace {

using namespace threewe;

constexpr int kBeams = 72;

env::Options make_options(std::size_t worlds) {
  env::Options options;
  for (const char* name : {"apartment_v1", "office_v2"}) {
    options.scenes.push_back(std::make_shared<const scene::Scene>(scene::Scene::load(name)));
  }
  options.task = [](const task::TaskContext& context) {
    task::NavigationOptions reactive;  // 2 to 8 m, without detours
    reactive.longest = 8.0;
    reactive.detours = 0.0;
    return task::make_navigation(context, reactive);
  };
  options.hardware = load_profile("3we_standard_v2");
  options.localization_model = models::load_localization("slam_v2");
  options.observed.pose = options.observed.velocity = false;
  options.lidar_beams = kBeams;
  options.max_steps = 300;
  options.worlds = worlds;
  return options;
}

// What robot i observes of something.
template <std::size_t Size>
std::array<float, Size> observed(const env::Array& array, std::size_t i) {
  std::array<float, Size> values{};
  std::memcpy(values.data(), &array.data[i * array.row_bytes], sizeof(values));
  return values;
}

float wrapped(float angle) { return std::remainder(angle, 2.0F * std::numbers::pi_v<float>); }

std::array<float, 3> act(const std::array<float, kBeams>& lidar, const std::array<float, 2>& goal) {
  // free is where nothing is within 0.7 m, nor before the goal, in 30 degrees to either side
  const float needed = std::min(0.7F, std::hypot(goal[0], goal[1]));
  const float bearing = std::atan2(goal[1], goal[0]);
  float best = 1e9F;
  float way = 0.0F;
  for (int beam = 0; beam < kBeams; ++beam) {
    const float angle = (static_cast<float>(beam) / kBeams * 2.0F - 1.0F) * std::numbers::pi_v<float>;
    float cost = std::abs(wrapped(angle - bearing));
    for (int k = -6; k <= 6; ++k) {
      if (lidar[static_cast<std::size_t>((beam + k + kBeams) % kBeams)] >= needed) continue;
      cost += 4.0F;
      break;
    }
    if (cost < best) way = angle;
    best = std::min(best, cost);
  }
  const float ahead = std::clamp(std::cos(way), 0.0F, 1.0F);
  return {ahead * ahead, 0.0F, std::clamp(2.0F * way, -1.0F, 1.0F)};
}

}  // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  env::Batch batch(make_options(quick ? 16 : 256));
  std::vector<env::Reset> resets(batch.rows());
  for (std::size_t i = 0; i < resets.size(); ++i) resets[i].seed = i;
  batch.reset(resets);

  std::size_t arrived = 0;
  std::size_t bumped = 0;
  std::vector<bool> over(batch.rows());
  std::vector<float> actions(3 * batch.rows());
  while (std::ranges::find(over, false) != over.end()) {
    for (std::size_t i = 0; i < batch.rows(); ++i) {
      const auto lidar = observed<kBeams>(batch.observations()[0], i);
      const auto goal = observed<2>(batch.observations()[1], i);
      std::ranges::copy(act(lidar, goal), &actions[3 * i]);
    }
    batch.step(actions);
    for (std::size_t i = 0; i < batch.rows(); ++i) {
      if (batch.ended()[i] == 0 || over[i]) continue;  // an environment's first episode counts
      over[i] = true;
      const auto metrics = batch.metrics().subspan(i * batch.metric_names().size());
      if (metrics[0] > 0.0) ++arrived;  // success
      if (metrics[5] > 0.05) ++bumped;  // collision_speed
    }
  }
  std::cout << batch.rows() << " episodes: " << 100 * arrived / batch.rows() << " % arrived, "
            << 100 * bumped / batch.rows() << " % bumped into something\n";
}
