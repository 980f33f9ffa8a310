// The controller alone on its courses, with some numbers of samples:
//
//   verify_control SEED SAMPLES...
//
// For each number it prints how many of the courses were driven to their end, by robots of both kinematics, touching
// nothing, and how many there were.
#include <cstdint>
#include <cstdio>

#include <fmt/format.h>

#include "nav/mppi_course.hpp"
#include "number.hpp"

using namespace threewe;

namespace {

int driven(std::uint64_t seed, int samples, int& courses) {
  int count = 0;
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(robot);
    for (const nav::testing::NamedCourse& course : nav::testing::kCourses) {
      const auto outcome = nav::testing::drive(profile, course.make(profile, seed), {.samples = samples, .seed = seed});
      count += outcome.arrived && outcome.clearance > 0.0 ? 1 : 0;
      ++courses;
    }
  }
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc > 2 ? argv[1] : "");
  for (int i = 2; i < argc && seed; ++i) {
    const auto samples = parse_number(argv[i]);
    if (!samples) break;
    int courses = 0;
    const int count = driven(*seed, static_cast<int>(*samples), courses);
    fmt::print("{} {} {}\n", *samples, count, courses);
    if (i + 1 == argc) return 0;
  }
  std::fputs("usage: verify_control SEED SAMPLES...\n", stderr);
  return 2;
}
