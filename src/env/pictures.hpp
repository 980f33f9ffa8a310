// Lazily rendered camera images of the robots of one world.
#pragma once

#include <span>
#include <vector>

#include "sim/camera.hpp"
#include "sim/model.hpp"
#include "sim/people.hpp"
#include "sim/state.hpp"

namespace threewe::env {

class Pictures {
 public:
  /// None are left of the episode before.
  void begin(std::size_t robots) { taken_.assign(robots, {}); }
  /// After a step of physics: keeps what the cameras see, if they have just taken a picture.
  void note(const sim::Model& model, std::span<const sim::RobotState> robots, std::span<const sim::PersonState> people);
  /// Draws the newest picture that has reached a robot: (H, W, 3) BGR and (H, W) float depth, either of which may be
  /// empty. Zeros before the first.
  void draw(const sim::Model& model, std::size_t robot, const sim::RobotState& state, std::span<std::byte> color,
            std::span<std::byte> depth, sim::DrawScratch& scratch);

 private:
  std::vector<std::vector<sim::CapturePose>> taken_;  // by each robot, oldest first
};

}  // namespace threewe::env
