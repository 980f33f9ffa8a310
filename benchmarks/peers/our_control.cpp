// Our controller in the room of mppi_bench.cpp, without people; writes the room for the peers.
#include <optional>

#include "../control_room.hpp"
#include "hardware/parameters.hpp"
#include "nav/mppi.hpp"
#include "world.hpp"

namespace {

using namespace threewe;

constexpr const char* kRobot = "3we_standard_v2";
constexpr double kArrived = 0.1;    // [m] from the end of the path
constexpr double kPatience = 30.0;  // [s]

const std::vector<Vec2> kPoints = scan_of_a_room(0.0);
const nav::MppiTask kTask{.path = kPathThroughADoor, .margin = 0.05};

void write(const char* path) {
  std::ofstream file(path);
  for (const Vec2 p : kPoints) file << "point " << p.x << ' ' << p.y << '\n';
  for (const Vec2 p : kPathThroughADoor) file << "path " << p.x << ' ' << p.y << '\n';
}

// Drives a base that does at once what is commanded: how long it takes [s], and how near its middle comes to a point
// [m].
struct Drive {
  std::optional<double> seconds;
  double nearest = 1e9;
};
Drive drive() {
  const RobotProfile profile = load_profile(kRobot);
  nav::Mppi mppi(profile, params_for<nav::Params>(profile, "nav"));
  Drive made;
  Pose2D pose;
  Velocity command;
  for (Time now{}; !made.seconds && to_seconds(now) < kPatience; now += kControlPeriod) {
    command = mppi.step({now, pose, command, kPoints}, kTask);
    pose = integrate(pose, command, to_seconds(kControlPeriod));
    for (const Vec2 p : kPoints) made.nearest = std::min(made.nearest, distance(pose.position(), p));
    if (distance(pose.position(), kPathThroughADoor.back()) < kArrived) made.seconds = to_seconds(now);
  }
  return made;
}

// What a plan takes, with so many samples: robots make one in each fifth tick.
void time_plans(int samples, const std::string& fields) {
  const RobotProfile profile = load_profile(kRobot);
  auto params = params_for<nav::Params>(profile, "nav");
  params.mppi.samples = samples;
  nav::Mppi mppi(profile, params);
  Velocity command;
  Time now{};
  constexpr int kPlans = 20;
  peers::report(fields, std::to_string(samples) + "x56", kPlans, [&] {
    for (int i = 0; i < kPlans * params.mppi.periods; ++i, now += kControlPeriod) {
      command = mppi.step({now, {0.0, 0.02, 0.1}, command, kPoints}, kTask);
    }
  });
}

}  // namespace

int main(int, char** argv) {
  write(argv[1]);
  const Drive drove = drive();
  const std::string fields =
      R"("kind": "control", "who": "ours", "differs": "the outline, critics of smoothness and heading )"
      R"(too, limits of acceleration, delay foreseen; C++", "arrived": )" +
      std::to_string(drove.seconds.value_or(-1.0)) + ", \"nearest\": " + std::to_string(drove.nearest);
  time_plans(nav::Params{}.mppi.samples, fields);
  time_plans(2000, fields);  // as many as the peers roll out
}
