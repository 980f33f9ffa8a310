// A robot's camera in a simulated world: what is in sight is kept as the picture is taken, and drawn when it is looked
// at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/model.hpp"
#include "sim/people.hpp"
#include "sim/renderer.hpp"
#include "sim/state.hpp"
#include "threewe/core/camera.hpp"

namespace threewe::sim {

/// A moment of a world: all that a picture shows follows from this and the model.
struct CapturePose {
  RngKey key;              ///< of the camera's noise; its robot holds the camera
  std::uint64_t step = 0;  ///< at whose end it was taken
  models::Variation variation;
  std::vector<Pose2D> robots;
  std::vector<PersonState> people;
};

/// Whether the camera took a picture at the end of the last step: the first step that ends at a multiple of its period,
/// or after it.
bool picture_ready(const RobotModel& robot, const RobotState& state);

/// The moment that `world[robot]` sees now. `world` are the robots of one world.
CapturePose capture_pose(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot);
/// The same into a shot that keeps its memory.
void capture_pose(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot,
                  CapturePose& capture);

/// Working memory of one thread that draws. Keeps its size from picture to picture; holds nothing between them.
struct DrawScratch {
  RenderScratch render;
  std::vector<VisibleSolid> figures;
};

/// Where a picture goes, row by row. An empty span is left out, and costs nothing.
struct PictureSpans {
  std::span<std::uint8_t> color;  ///< (H, W, 3), blue, green, red
  std::span<float> depth;         ///< (H, W) [m] along the optical axis, invalid = 0.0
};

/// Draws what the robot's camera would deliver if its view had these intrinsics: with noise. Allocates nothing once
/// `scratch` has grown. Depth of a camera that measures none is refused with a ConfigError; a robot without a camera is
/// a programmer's mistake.
void draw(const Model& model, const CapturePose& capture, const CameraIntrinsics& camera, const PictureSpans& picture,
          DrawScratch& scratch);

/// What the robot's camera delivers of it: with noise, and depth where it measures any.
RGBDImage draw_picture(const Model& model, const CapturePose& capture);

/// What some camera would truly show of it, with or without the robot itself.
SemanticImage draw_truth(const Model& model, const CapturePose& capture, const CameraIntrinsics& camera,
                         const CameraPose& view, bool with_itself);

}  // namespace threewe::sim
