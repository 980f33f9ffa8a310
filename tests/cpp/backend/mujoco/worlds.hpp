// Worlds on MuJoCo, and how tests drive in them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "backend/mujoco/mujoco.hpp"
#include "backend/small_room.hpp"
#include "core/rng.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::testing {

inline std::unique_ptr<World> mujoco_world(const WorldOptions& options) {
  mujoco::use_library(MUJOCO_LIBRARY);
  return mujoco::make_world(options);
}

/// Its robots are connected.
inline std::unique_ptr<World> connected(const WorldOptions& options) {
  auto world = mujoco_world(options);
  for (std::size_t i = 0; i < world->robot_count(); ++i) world->robot(i).connect();
  return world;
}

/// A randomization that always draws the same.
inline std::string always(const std::string& knobs) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "always.yaml";
  std::ofstream(file) << "description: always the same\nreset: {" << knobs << "}\n";
  return file.string();
}

/// The newest data of one kind.
template <typename Data>
void keep_newest(std::vector<Sample>& samples, Data& newest) {
  for (Sample& sample : samples) {
    if (auto* data = std::get_if<Data>(&sample.data)) newest = std::move(*data);
  }
}

struct Readings {
  LaserScan scan;
  Odometry odometry;
};

/// Commands `velocity` to one robot for `periods` of 20 ms; the others stand.
inline void drive(World& world, const Velocity& velocity, int periods, Readings& readings, std::size_t robot = 0) {
  for (int i = 0; i < periods; ++i) {
    world.robot(robot).command(velocity, world.now() + 200ms);
    world.advance_to(world.now() + kControlPeriod);
    std::vector<Sample> samples = world.robot(robot).poll();
    keep_newest(samples, readings.scan);
    keep_newest(samples, readings.odometry);
  }
}

/// All robots drive by random commands, which last 0.2 s each.
inline void drive_anyhow(World& world, std::uint64_t seed, int first, int count) {
  const RngKey key{.seed = seed};
  for (int i = first; i < first + count; ++i) {
    for (int period = 0; period < 10; ++period) {
      for (std::size_t robot = 0; robot < world.robot_count(); ++robot) {
        const std::uint64_t draw = 100 * static_cast<std::uint64_t>(i) + robot;
        const Velocity velocity{uniform(key, draw, 0, -0.5, 0.5), uniform(key, draw, 1, -0.5, 0.5),
                                uniform(key, draw, 2, -1.0, 1.0)};
        world.robot(robot).command(velocity, world.now() + 200ms);
      }
      world.advance_to(world.now() + kControlPeriod);
      for (std::size_t robot = 0; robot < world.robot_count(); ++robot) world.robot(robot).poll();
    }
  }
}

inline const scene::TruthView& truth(World& world, std::size_t robot = 0) {
  const TruthService* service = world.truth_service();
  if (service == nullptr) throw std::logic_error("no simulated world");  // g++ fears a null
  return service->truth(robot);
}

/// What the lidar says of what is ahead [m].
inline double ahead(const LaserScan& scan) {
  return static_cast<double>(
      scan.ranges[static_cast<std::size_t>(std::lround(-scan.angle_min / scan.angle_increment))]);
}

}  // namespace threewe::backend::testing
