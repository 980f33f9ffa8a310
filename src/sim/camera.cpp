#include "sim/camera.hpp"

#include <algorithm>
#include <cassert>

#include "models/camera.hpp"
#include "sim/actor_geometry.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

// Working memory that outlives a picture: one for each thread that draws.
DrawScratch& scratch() {
  thread_local DrawScratch scratch;
  return scratch;
}

std::size_t pixels_of(const CameraIntrinsics& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

Shading shading_of(const CapturePose& capture) {
  const auto [b, g, r] = models::color_gains(capture.variation, capture.key);
  const auto gain = [](double x) { return static_cast<float>(std::min(x, static_cast<double>(kMostGain))); };
  return {capture.key.seed,
          capture.key.episode,
          static_cast<std::uint32_t>(capture.variation.texture),
          {gain(b), gain(g), gain(r)},
          static_cast<float>(capture.variation.detail)};
}

// What moves is drawn where it was, but for the robot `without`.
void render(const Model& model, const CapturePose& capture, std::size_t without, const CameraIntrinsics& camera,
            const CameraPose& view, const Images& images, DrawScratch& scratch) {
  find_actors(model, capture.robots, without, capture.people, capture.key.seed, capture.key.episode, scratch.figures);
  const Shading shading = shading_of(capture);
  model.renderer().render(camera, view, shading, images, scratch.render, scratch.figures);
}

}  // namespace

bool picture_ready(const RobotModel& robot, const RobotState& state) {
  if (!robot.profile.camera || state.steps == 0) return false;
  const Duration period = robot.profile.camera->period;
  return state.time() / period > (state.time() - kStep) / period;
}

CapturePose capture_pose(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot) {
  CapturePose capture;
  capture_pose(world, people, robot, capture);
  return capture;
}

void capture_pose(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot,
                  CapturePose& capture) {
  const RobotState& state = world[robot];
  capture.key = state.key(Stream::camera);
  capture.step = state.steps;
  capture.variation = state.variation;
  capture.robots.clear();
  for (const RobotState& each : world) capture.robots.push_back(each.pose);
  capture.people.assign(people.begin(), people.end());
}

void draw(const Model& model, const CapturePose& capture, const CameraIntrinsics& camera, const PictureSpans& picture,
          DrawScratch& scratch) {
  const std::size_t robot = capture.key.robot;
  assert(model.robots[robot].profile.camera);
  const CameraSpec spec = models::varied(*model.robots[robot].profile.camera, capture.variation);
  if (!picture.depth.empty() && !spec.depth) throw ConfigError("depth is asked of a camera that measures none");

  const CameraPose view{capture.robots[robot] * spec.base_from_camera, spec.mount_height};
  render(model, capture, robot, camera, view, {picture.color, picture.depth, {}}, scratch);
  models::add_color_noise(spec, capture.key, capture.step, picture.color);
  if (!picture.depth.empty()) models::measure_depth(*spec.depth, capture.key, capture.step, picture.depth);
}

RGBDImage draw_picture(const Model& model, const CapturePose& capture) {
  assert(model.robots[capture.key.robot].profile.camera);
  const CameraSpec& spec = *model.robots[capture.key.robot].profile.camera;
  RGBDImage picture{spec.intrinsics(), {}, {}};
  picture.color.resize(3 * pixels_of(picture.intrinsics));
  if (spec.depth) picture.depth.resize(pixels_of(picture.intrinsics));
  draw(model, capture, picture.intrinsics, {picture.color, picture.depth}, scratch());
  return picture;
}

SemanticImage draw_truth(const Model& model, const CapturePose& capture, const CameraIntrinsics& camera,
                         const CameraPose& view, bool with_itself) {
  check(camera);
  const std::size_t pixels = pixels_of(camera);
  SemanticImage truth{{camera, std::vector<std::uint8_t>(3 * pixels), std::vector<float>(pixels)},
                      std::vector<std::int16_t>(pixels),
                      id_names(model)};
  render(model, capture, with_itself ? capture.robots.size() : capture.key.robot, camera, view,
         {truth.image.color, truth.image.depth, truth.ids}, scratch());
  return truth;
}

}  // namespace threewe::sim
