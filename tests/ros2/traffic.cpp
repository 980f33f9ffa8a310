// What comes through the backend `real` from ros2_streams, and when: as an autonomy stack gets it, without one.
//
//   ros2_traffic PROFILE SECONDS
//
// It commands a velocity each control period and looks for samples all the time. It prints, as JSON, the numbers that
// scans and depths have, each with when it was there, in nanoseconds of the computer's monotonic clock, and what is
// said of the way to the robot.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "threewe/backend/registry.hpp"
#include "threewe/core/time.hpp"

using namespace threewe;
using Clock = std::chrono::steady_clock;

namespace {

struct Arrival {
  int number = 0;
  std::int64_t time = 0;
};

int number_of(float metres) { return static_cast<int>(std::lround((metres - 1.0F) * 1024.0F)); }

std::string json(const std::vector<Arrival>& arrivals) {
  std::string text;
  for (const auto& [number, time] : arrivals) text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", number, time);
  return "[" + text + "]";
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fputs("usage: ros2_traffic PROFILE SECONDS\n", stderr);
    return 2;
  }
  try {
    backend::WorldOptions options;
    options.robots = {arguments[1]};
    const auto world = backend::make_world("real", options);
    backend::RobotPort& port = world->robot(0);
    port.connect();
    std::vector<Arrival> scans, images;
    std::string fault;
    const auto end = Clock::now() + std::chrono::duration<double>(std::stod(arguments[2]));
    for (Time next = world->now(); Clock::now() < end; std::this_thread::sleep_for(std::chrono::microseconds(50))) {
      if (world->now() >= next) {
        next += kControlPeriod;
        port.command({0.1, 0.0, 0.0}, world->now() + 10 * kControlPeriod);
      }
      const std::vector<Sample> samples = port.poll();
      const std::int64_t now = Clock::now().time_since_epoch().count();
      for (const Sample& sample : samples) {
        if (const auto* scan = std::get_if<LaserScan>(&sample.data)) scans.push_back({number_of(scan->ranges[0]), now});
        const auto* picture = std::get_if<Picture>(&sample.data);
        if (picture != nullptr) images.push_back({number_of(picture->image().depth[0]), now});
      }
      if (std::string words = port.link_fault(); !words.empty()) fault = std::move(words);
    }
    port.disconnect();
    fmt::print("{{\"scans\": {}, \"images\": {}, \"fault\": \"{}\"}}\n", json(scans), json(images), fault);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_traffic: %s\n", error.what());
    return 1;
  }
  return 0;
}
