// Pictures per second in the office, from a ring of poses in its rooms.
#include <benchmark/benchmark.h>

#include <memory>
#include <span>
#include <vector>

#include "core/exact.hpp"
#include "sim/camera.hpp"
#include "sim/step.hpp"
#include "threewe/scene/scene.hpp"

namespace {

using namespace threewe;

const scene::Scene& office() {
  static const scene::Scene instance = scene::Scene::load("office_v2");
  return instance;
}

// Eight headings at the anchor of every room.
std::vector<sim::CameraPose> ring() {
  std::vector<sim::CameraPose> poses;
  for (int i = 0; i < 8; ++i) {
    for (const scene::Room& room : office().rooms) {
      poses.push_back({{room.anchor.x, room.anchor.y, 0.25 * exact::kPi * (i - 3)}, 0.12});
    }
  }
  return poses;
}

enum Wanted : int { colour = 1, depth = 2, ids = 4 };

void render(benchmark::State& state) {
  const sim::Renderer renderer(office());
  const sim::Shading shading{0, 0};
  const CameraIntrinsics camera =
      make_intrinsics(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), 1.2);
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  std::vector<std::uint8_t> bgr(state.range(2) & colour ? 3 * pixels : 0);
  std::vector<float> metres(state.range(2) & depth ? pixels : 0);
  std::vector<std::int16_t> seen(state.range(2) & ids ? pixels : 0);
  sim::RenderScratch scratch;
  const auto poses = ring();
  std::size_t i = 0;
  for (auto _ : state) {
    renderer.render(camera, poses[i++ % poses.size()], shading, {bgr, metres, seen}, scratch);
    benchmark::ClobberMemory();
  }
  state.counters["frames_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(render)
    ->Args({64, 64, colour | depth})
    ->Args({128, 128, colour | depth})
    ->Args({640, 480, colour})
    ->Args({640, 480, colour | depth})
    ->Args({640, 480, colour | depth | ids})
    ->Args({640, 480, depth})
    ->Unit(benchmark::kMicrosecond);

// What an environment pays for a picture of its robot's camera: from the state to pixels with noise, varied every time.
void draw(benchmark::State& state) {
  const auto model = sim::make_model(std::make_shared<const scene::Scene>(office()), {load_profile("3we_depth_v2")});
  const int size = static_cast<int>(state.range(0));
  const CameraIntrinsics camera = make_intrinsics(size, size, model->robots[0].profile.camera->horizontal_fov);
  const std::size_t pixels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  std::vector<std::uint8_t> bgr(3 * pixels);
  std::vector<float> metres(pixels);
  sim::DrawScratch scratch;
  sim::CapturePose capture;
  std::vector<sim::RobotState> robots;
  for (const sim::CameraPose& view : ring()) {
    models::Variation variation;
    variation.light = 0.8;
    variation.texture = static_cast<double>(robots.size());
    robots.push_back(sim::begin(*model, 0, view.pose, robots.size(), 0, variation));
  }
  std::size_t i = 0;
  for (auto _ : state) {
    sim::capture_pose(std::span(robots).subspan(i++ % robots.size(), 1), {}, 0, capture);
    sim::draw(*model, capture, camera, {bgr, metres}, scratch);
    benchmark::ClobberMemory();
  }
  state.counters["frames_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(draw)->Arg(64)->Unit(benchmark::kMicrosecond);

// Getting to know a scene.
void build(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(sim::Renderer(office()));
}
BENCHMARK(build)->Unit(benchmark::kMillisecond);

}  // namespace
