// Drives blindly into what is ahead, below the gate, in the embedded simulator and in Gazebo, and prints the largest
// collision speed [m/s] and the distance driven [m] of each.
#include <cstdio>

#include "threewe/backend/registry.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;

int main() {
  for (const char* name : {"mock", "gazebo"}) {
    backend::WorldOptions options;
    if (std::string_view(name) == "mock") options.noise = NoiseLevel::ideal;
    try {
      const auto world = backend::make_world(name, options);
      backend::RobotPort& port = world->robot(0);
      port.connect();
      while (world->now() < 15s) {
        port.command({0.5, 0.0, 0.0}, world->now() + 200ms);
        world->advance_to(world->now() + kControlPeriod);
        (void)port.poll();
      }
      const backend::TruthService* service = world->truth_service();
      if (service == nullptr) return 1;
      const scene::TruthView& truth = service->truth(0);
      std::printf("%.4f %.4f\n", truth.max_collision_speed(), truth.distance_driven());
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", name, error.what());
      return 1;
    }
  }
  return 0;
}
