// A step of a batch takes no memory from the heap once its environments have been through what they may meet.
#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "draw.hpp"
#include "threewe/env/batch.hpp"
#include "threewe/scene/generator.hpp"
#include "threewe/task/tasks.hpp"

namespace {
std::atomic<long> allocations{0};

void* allocated(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* const memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

// NOLINTBEGIN(misc-new-delete-overloads, cppcoreguidelines-no-malloc)
void* operator new(std::size_t bytes) { return allocated(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocated(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t& /*tag*/) noexcept {
  ++allocations;
  return std::malloc(bytes);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
// NOLINTEND(misc-new-delete-overloads, cppcoreguidelines-no-malloc)

namespace threewe::env {
namespace {

Options navigation(Gate gate, Duration period) {
  Options options;
  options.scenes = {std::make_shared<const scene::Scene>(scene::generate(1, {.size = {8.0, 6.0}}))};
  options.task = [](const task::TaskContext& context) { return task::make_navigation(context, {.goals = 8}); };
  options.hardware = load_profile("3we_standard_v2");
  options.worlds = 32;
  options.gate = gate;
  options.control_period = period;
  options.max_steps = 100;
  return options;
}

// Of one environment's step, with random actions and new episodes, after three episodes of each.
double allocations_of_a_step(Gate gate, Duration period) {
  Batch batch(navigation(gate, period));
  std::vector<Reset> resets(batch.rows());
  for (std::size_t i = 0; i < resets.size(); ++i) resets[i].seed = i;
  batch.reset(resets);
  Draw draw(1);
  std::vector<float> actions(3 * batch.rows());
  const auto step = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      for (float& a : actions) a = static_cast<float>(draw(-1.0, 1.0));
      batch.step(actions);
    }
  };
  step(300);
  const long before = allocations;
  step(200);
  return static_cast<double>(allocations - before) / static_cast<double>(200 * batch.rows());
}

TEST_CASE("a step takes no memory from the heap") {
  for (const Duration period : {20ms, 100ms}) {
    CHECK(allocations_of_a_step(Gate::limits, period) == 0.0);
    // but where the gate sees more points than ever before in this environment
    CHECK(allocations_of_a_step(Gate::full, period) < 0.03);
  }
}

}  // namespace
}  // namespace threewe::env
