// The controller that robots drive with, alone on its courses:
//
//   verify_control SEED
//
// A line of JSON for each course and robot of either kinematics: whether it came to its end, and how near [m] its
// outline came to what is around. The controller is the path follower as it is in every robot, with its own settings.
#include <cstdint>
#include <cstdio>

#include <fmt/format.h>

#include "hardware/parameters.hpp"
#include "nav/mppi_course.hpp"
#include "nav/path_follower.hpp"
#include "number.hpp"

using namespace threewe;

namespace {

nav::testing::Outcome drive(const RobotProfile& profile, const nav::testing::Course& course) {
  nav::PathFollower follower(profile, params_for<nav::Params>(profile, "nav"));
  return nav::testing::drive(profile, course, [&](const nav::MppiObservation& seen, std::span<const Vec2> path) {
    std::vector<Vec2> in_base;
    for (const Vec2 point : seen.obstacles) in_base.push_back(inverse(seen.odom_from_base) * point);
    follower.update(in_base, 0.0);
    return follower.follow(path, seen);
  });
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 2 ? argv[1] : "");
  if (!seed) {
    std::fputs("usage: verify_control SEED\n", stderr);
    return 2;
  }
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(robot);
    for (const nav::testing::NamedCourse& course : nav::testing::kCourses) {
      const auto outcome = drive(profile, course.make(profile, *seed));
      fmt::print(
          R"({{"hardware": "{}", "course": "{}", "arrived": {}, "seconds": {:.2f}, "clearance": {:.4f}, "contact_speed": {:.4f}}})"
          "\n",
          robot, course.name, outcome.arrived, outcome.seconds, outcome.clearance, outcome.contact_speed);
    }
  }
  return 0;
}
