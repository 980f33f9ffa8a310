#include "sim/camera.hpp"

#include <algorithm>
#include <cassert>

#include "models/camera.hpp"
#include "sim/figures.hpp"
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

Paint paint_of(const Shot& shot) {
  const auto [b, g, r] = models::color_gains(shot.variation, shot.key);
  const auto gain = [](double x) { return static_cast<float>(std::min(x, static_cast<double>(kMostGain))); };
  return {
      shot.key.seed, shot.key.episode, static_cast<std::uint32_t>(shot.variation.texture), {gain(b), gain(g), gain(r)}};
}

// What moves is drawn where it was, but for the robot `without`.
void render(const Model& model, const Shot& shot, std::size_t without, const CameraIntrinsics& camera,
            const CameraPose& view, const Images& images, DrawScratch& scratch) {
  find_figures(model, shot.robots, without, shot.people, shot.key.seed, shot.key.episode, scratch.figures);
  const Paint paint = paint_of(shot);
  model.renderer().render(camera, view, paint, images, scratch.render, scratch.figures);
}

}  // namespace

bool picture_ready(const RobotModel& robot, const RobotState& state) {
  if (!robot.profile.camera || state.steps == 0) return false;
  const Duration period = robot.profile.camera->period;
  return state.time() / period > (state.time() - kStep) / period;
}

Shot take_shot(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot) {
  Shot shot;
  take_shot(world, people, robot, shot);
  return shot;
}

void take_shot(std::span<const RobotState> world, std::span<const PersonState> people, std::size_t robot, Shot& shot) {
  const RobotState& state = world[robot];
  shot.key = state.key(Stream::camera);
  shot.step = state.steps;
  shot.variation = state.variation;
  shot.robots.clear();
  for (const RobotState& each : world) shot.robots.push_back(each.pose);
  shot.people.assign(people.begin(), people.end());
}

void draw(const Model& model, const Shot& shot, const CameraIntrinsics& camera, const PictureSpans& picture,
          DrawScratch& scratch) {
  const std::size_t robot = shot.key.robot;
  assert(model.robots[robot].profile.camera);
  const CameraSpec spec = models::varied(*model.robots[robot].profile.camera, shot.variation);
  if (!picture.depth.empty() && !spec.depth) throw ConfigError("depth is asked of a camera that measures none");

  const CameraPose view{shot.robots[robot] * spec.base_from_camera, spec.mount_height};
  render(model, shot, robot, camera, view, {picture.color, picture.depth, {}}, scratch);
  models::add_color_noise(spec, shot.key, shot.step, picture.color);
  if (!picture.depth.empty()) models::measure_depth(*spec.depth, shot.key, shot.step, picture.depth);
}

RGBDImage draw_picture(const Model& model, const Shot& shot) {
  assert(model.robots[shot.key.robot].profile.camera);
  const CameraSpec& spec = *model.robots[shot.key.robot].profile.camera;
  RGBDImage picture{spec.intrinsics(), {}, {}};
  picture.color.resize(3 * pixels_of(picture.intrinsics));
  if (spec.depth) picture.depth.resize(pixels_of(picture.intrinsics));
  draw(model, shot, picture.intrinsics, {picture.color, picture.depth}, scratch());
  return picture;
}

SemanticImage draw_truth(const Model& model, const Shot& shot, const CameraIntrinsics& camera, const CameraPose& view,
                         bool with_itself) {
  check(camera);
  const std::size_t pixels = pixels_of(camera);
  SemanticImage truth{{camera, std::vector<std::uint8_t>(3 * pixels), std::vector<float>(pixels)},
                      std::vector<std::int16_t>(pixels),
                      id_names(model)};
  render(model, shot, with_itself ? shot.robots.size() : shot.key.robot, camera, view,
         {truth.image.color, truth.image.depth, truth.ids}, scratch());
  return truth;
}

}  // namespace threewe::sim
