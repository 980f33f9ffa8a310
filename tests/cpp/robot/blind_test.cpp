// Lidars of which many beams are invalid: nothing is touched that no beam has seen, and health says why a robot stands.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "robot/faulty_port.hpp"
#include "robot/warnings.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

// A robot whose lidar breaks at some time after it was connected.
struct Blinded {
  Blinded(const std::string& scene, const std::string& hardware, std::uint64_t seed, InjectedFault fault) {
    backend::WorldOptions options;
    options.scene = scene;
    options.robots = {hardware};
    options.seed = seed;
    auto faulty = std::make_unique<WorldOfFaults>(backend::make_world("mock", options));
    const auto& sensors = faulty->robot(0).features().sensors;
    const auto found = std::ranges::find(sensors, SensorType::lidar, &SensorInfo::type);
    fault.sensor = lidar = static_cast<std::uint16_t>(found - sensors.begin());
    fault.seed = seed;
    faulty->robot(0).break_with({fault});
    world = std::make_unique<World>(std::move(faulty));
    robot = std::make_unique<Robot>(*world);
  }
  const SensorHealth& health() const { return robot->health()[lidar]; }
  double contact() const { return robot->simulation()->max_collision_speed(); }

  Warnings warnings;
  std::uint16_t lidar = 0;
  std::unique_ptr<World> world;
  std::unique_ptr<Robot> robot;
};

const std::vector<std::string> kRobots = {"3we_standard_v2", "turtlebot_like"};

}  // namespace

TEST_CASE("however many beams are invalid, from the first or later, nothing is run into") {
  for (const double share : {0.2, 0.5, 0.8, 0.9, 0.97, 0.99, 1.0}) {
    for (const std::string& hardware : kRobots) {
      for (const Time from : {Time{}, Time{3s}}) {
        CAPTURE(share);
        CAPTURE(hardware);
        CAPTURE(to_seconds(from));
        Blinded d("office_v2", hardware, 3000001, {.kind = FaultKind::dropout, .size = share, .from = from});
        const MoveResult result = d.robot->wait(d.robot->move_forward(6.0, 0.05, 30.0));
        CHECK(d.contact() <= 0.05);
        if (share < 0.99) continue;
        CHECK(d.health().fault == SensorFault::blind);
        CHECK(result.reason == Reason::fault);
        CHECK(result.detail.find("'lidar' has been blind") != std::string::npos);
      }
    }
  }
}

TEST_CASE("a lidar that is covered on one side runs into nothing there") {
  for (const double bearing : {0.0, 0.5 * exact::kPi, exact::kPi}) {
    for (const double width : {0.5, 0.5 * exact::kPi}) {
      for (const std::string& hardware : kRobots) {
        CAPTURE(bearing);
        CAPTURE(width);
        CAPTURE(hardware);
        Blinded d("office_v2", hardware, 3000011,
                  {.kind = FaultKind::covered, .size = width, .from = Time{}, .bearing = bearing});
        (void)d.robot->wait(d.robot->move_forward(bearing == exact::kPi ? -6.0 : 6.0, 0.05, 30.0));
        CHECK(d.contact() <= 0.05);
        CHECK((d.health().fault == SensorFault::blind) == (width > 1.0));
      }
    }
  }
}

TEST_CASE("who has seen nothing has not explored it") {
  Blinded d("office_v2", "3we_standard_v2", 3000021, {.kind = FaultKind::dropout, .size = 1.0, .from = Time{}});
  const ExploreResult result = d.robot->wait(d.robot->explore(60.0));
  CHECK_FALSE(result.success);
  CHECK(result.explored_area == 0.0);
}
