// What every peer in C++ is given, and how it is timed: world.py says the same in Python.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

namespace peers {

inline constexpr int kBeams[] = {64, 360};
inline constexpr double kForward = 0.3;       // [m/s]
inline constexpr double kTurn = 0.5;          // [rad/s]
inline constexpr double kPhysics = 0.01;      // [s] of a step of physics
inline constexpr int kRun = 10;               // steps from each place
inline constexpr std::size_t kLookedAt = 64;  // of the places: the mean of all ranges from there
inline constexpr std::size_t kFew = 32;       // of the places, for what takes long
inline constexpr int kRepeats = 5;            // timings
inline constexpr double kShortest = 0.2;      // [s] of each

struct Solid {
  double x, y, theta, length, width, radius, low, high;  // [m]; with a radius a disc
};
struct Place {
  double x, y, theta;
};
struct World {
  std::vector<Solid> solids;
  std::vector<Place> poses;
  double lidar_height = 0.0, lidar_range = 0.0;     // [m]
  double camera_height = 0.0, field_of_view = 0.0;  // [m], [rad]
  int substeps = 10;                                // of physics in a step
  double period() const { return substeps * kPhysics; }
};

inline World read_world(const char* path) {
  World world;
  std::ifstream file(path);
  for (std::string word; file >> word;) {
    if (word == "solid") {
      Solid& s = world.solids.emplace_back();
      file >> s.x >> s.y >> s.theta >> s.length >> s.width >> s.radius >> s.low >> s.high;
    } else if (word == "pose") {
      Place& p = world.poses.emplace_back();
      file >> p.x >> p.y >> p.theta;
    } else if (word == "lidar") {
      file >> world.lidar_height >> world.lidar_range;
    } else if (word == "camera") {
      file >> world.camera_height >> world.field_of_view;
    } else if (word == "substeps") {
      file >> world.substeps;
    }
  }
  return world;
}

// What the lidar can meet.
inline std::vector<Solid> cut(const World& world) {
  std::vector<Solid> found;
  for (const Solid& solid : world.solids) {
    if (solid.low <= world.lidar_height && world.lidar_height < solid.high) found.push_back(solid);
  }
  return found;
}

inline double cpu_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Prints the seconds that each of the `units` of a piece of work takes, as JSON after the fields given: several
// timings, after one to warm up.
template <class Work>
void report(const std::string& fields, const std::string& size, double units, const Work& work) {
  const auto seconds = [&](int rounds) {
    const double begin = cpu_seconds();
    for (int i = 0; i < rounds; ++i) work();
    return cpu_seconds() - begin;
  };
  int rounds = 1;
  for (double took = seconds(rounds); took < kShortest; took = seconds(rounds)) {
    rounds = std::max(2 * rounds, static_cast<int>(std::ceil(rounds * kShortest / std::max(took, 1e-3))));
  }
  std::printf("{%s, \"size\": \"%s\", \"seconds\": [", fields.c_str(), size.c_str());
  for (int i = 0; i < kRepeats; ++i) std::printf("%s%.6g", i ? ", " : "", seconds(rounds) / (rounds * units));
  std::printf("]}\n");
  std::fflush(stdout);
}

// Times one turn of the lidar from each of the places; `range(beam)` is what the last one met.
template <class Scan, class Range>
void report_scans(const std::string& fields, const World& world, int beams, const Scan& scan, const Range& range) {
  double sum = 0.0;
  for (std::size_t place = 0; place < kLookedAt; ++place) {
    scan(world.poses[place]);
    for (int i = 0; i < beams; ++i) sum += range(i);
  }
  const std::string facts = "\"kind\": \"scan\", \"range\": " + std::to_string(world.lidar_range) +
                            ", \"mean_range\": " + std::to_string(sum / (beams * static_cast<double>(kLookedAt))) +
                            ", " + fields;
  report(facts, std::to_string(beams), beams * static_cast<double>(world.poses.size()), [&] {
    for (const Place& pose : world.poses) scan(pose);
  });
}

}  // namespace peers
