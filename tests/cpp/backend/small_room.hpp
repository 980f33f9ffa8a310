// A scene that is made at once, where the published ones take a while.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "threewe/backend/world.hpp"

namespace threewe::backend::testing {

/// One room without furniture, the robot's start 4.5 m from the wall ahead.
inline std::string small_room() {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "small_room.yaml";
  std::ofstream(file) << R"(
name: small_room
description: A room of 6 x 5 m
starts:
  - [1.5, 2, 0]
rooms:
  - {name: room, min: [0, 0], max: [6, 5], floor: wood, anchor: [3, 2]}
walls:
  - {a: [0, 0], b: [6, 0]}
  - {a: [6, 0], b: [6, 5]}
  - {a: [6, 5], b: [0, 5]}
  - {a: [0, 5], b: [0, 0]}
)";
  return file.string();
}

inline WorldOptions in_small_room(const std::string& robot, NoiseLevel noise = NoiseLevel::realistic) {
  WorldOptions options;
  options.scene = small_room();
  options.robots = {robot};
  options.noise = noise;
  return options;
}

}  // namespace threewe::backend::testing
