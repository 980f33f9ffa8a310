// Ours beside them, in C++: the lidar and the camera. Steps of environments are timed through Python, as they are used.
#include "core/exact.hpp"
#include "sim/camera.hpp"
#include "sim/ray_caster.hpp"
#include "sim/renderer.hpp"
#include "threewe/scene/scene.hpp"
#include "world.hpp"

namespace {

using namespace threewe;

void time_scans(const scene::Scene& office, const peers::World& world, int beams) {
  const sim::RayCaster caster(office.at_height(world.lidar_height), world.lidar_range);
  std::vector<float> ranges(static_cast<std::size_t>(beams));
  const auto turn = [&](const peers::Place& pose) {
    caster.cast({pose.x, pose.y, pose.theta}, 0.0, 2.0 * exact::kPi / beams, ranges);
  };
  const auto range = [&](int i) { return static_cast<double>(ranges[static_cast<std::size_t>(i)]); };
  peers::report_scans(R"("who": "ours", "differs": "exact, in 2D, C++")", world, beams, turn, range);
}

void time_pictures(const scene::Scene& office, const peers::World& world, int width, int height) {
  const sim::Renderer renderer(office);
  const CameraIntrinsics camera = make_intrinsics(width, height, world.field_of_view);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> colour(3 * pixels);
  std::vector<float> depth(pixels);
  sim::RenderScratch scratch;
  const std::string fields =
      R"("kind": "picture", "who": "ours", "differs": "one pass; textured, lit through windows, with a ceiling; C++")";
  peers::report(fields, std::to_string(width) + "x" + std::to_string(height), static_cast<double>(peers::kFew), [&] {
    for (std::size_t i = 0; i < peers::kFew; ++i) {
      const peers::Place& pose = world.poses[i];
      renderer.render(camera, {{pose.x, pose.y, pose.theta}, world.camera_height}, {0, 0}, {colour, depth, {}},
                      scratch);
    }
  });
}

}  // namespace

int main(int, char** argv) {
  const peers::World world = peers::read_world(argv[1]);
  const scene::Scene office = scene::Scene::load("office_v2");
  for (const int beams : peers::kBeams) time_scans(office, world, beams);
  time_pictures(office, world, 64, 64);
  time_pictures(office, world, 160, 120);
  time_pictures(office, world, 640, 480);
}
