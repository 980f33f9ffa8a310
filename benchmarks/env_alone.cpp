// What env_bench.py holds the Python batch API against: the same environments without Python, and how much an
// arithmetic-only loop gains from threads.
//
//   env_alone steps BEAMS TICKS SECONDS    seconds of a step of one of 1,024 environments, as often as env_bench.py
//   env_alone spin THREADS SECONDS         loops a second, of all threads together
#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "threewe/core/rng.hpp"
#include "threewe/env/batch.hpp"
#include "threewe/task/navigation.hpp"

using namespace threewe;

namespace {

constexpr std::size_t kEnvs = 1024;
constexpr int kRepeats = 5;

double cpu_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// As env_steps.py chooses them.
env::Options options(const std::string& beams, int ticks) {
  env::Options options;
  options.scenes = {std::make_shared<const scene::Scene>(scene::Scene::load("office_v2"))};
  options.task = [](const task::Setting& setting) { return task::make_navigation(setting, {}); };
  options.hardware = with_noise(load_profile(THREEWE_BENCHMARKS "/robots/bench_" + beams + ".yaml"), NoiseLevel::ideal);
  options.observed.pose = options.observed.velocity = false;
  options.localization_model = models::load_localization("slam_v1");
  options.gate = env::Gate::limits;
  options.control_period = ticks * kControlPeriod;
  options.worlds = kEnvs;
  return options;
}

void time_steps(const std::string& beams, int ticks, double seconds) {
  env::Batch batch(options(beams, ticks));
  std::vector<env::Reset> resets(kEnvs);
  for (std::size_t i = 0; i < kEnvs; ++i) resets[i].seed = i;
  batch.reset(resets);
  std::vector<std::vector<float>> actions(20, std::vector<float>(3 * kEnvs));
  for (std::size_t i = 0; i < actions.size(); ++i) {
    for (std::size_t j = 0; j < actions[i].size(); ++j) {
      actions[i][j] = static_cast<float>(uniform({.seed = i}, j, 0, -1.0, 1.0));
    }
  }
  for (int repeat = 0; repeat <= kRepeats; ++repeat) {
    std::size_t steps = 0;
    const double begin = cpu_seconds();
    while (cpu_seconds() - begin < seconds / (kRepeats + 1)) batch.step(actions[steps++ / 10 % actions.size()]);
    if (repeat > 0) std::printf("%.6g\n", (cpu_seconds() - begin) / static_cast<double>(steps * kEnvs));
  }
}

// Multiplications and additions in registers: nothing but the two hardware threads can slow it.
void spin(int threads, double seconds) {
  std::atomic<bool> over = false;
  std::atomic<long> loops = 0;
  std::vector<std::thread> running;
  for (int i = 0; i < threads; ++i) {
    running.emplace_back([&] {
      double values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
      long done = 0;
      for (; !over; ++done) {
        for (int turn = 0; turn < 1000; ++turn) {
          for (double& value : values) value = 0.999 * value + 0.001;
        }
        asm volatile("" ::"r"(values) : "memory");  // or the compiler leaves all of it out
      }
      loops += done;
    });
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  over = true;
  for (std::thread& thread : running) thread.join();
  std::printf("%.6g\n", static_cast<double>(loops) / seconds);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  if (what == "steps" && argc == 5) {
    time_steps(argv[2], std::stoi(argv[3]), std::stod(argv[4]));
  } else if (what == "spin" && argc == 4) {
    spin(std::stoi(argv[2]), std::stod(argv[3]));
  } else {
    std::fputs("usage: env_alone steps BEAMS TICKS SECONDS | spin THREADS SECONDS\n", stderr);
    return 2;
  }
  return 0;
}
