// What a robot's camera delivers of a moment, drawn into anybody's memory.
#include "sim/camera.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "models/camera.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

// A clinic with people, and two robots that have driven for a while.
struct Clinic {
  std::shared_ptr<const Model> model;
  std::vector<RobotState> robots;
  std::vector<PersonState> people;

  explicit Clinic(const models::Variation& variation = {}) {
    const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load("dynamic_v1"));
    model = make_model(scene, {load_profile("3we_depth_v2"), load_profile("3we_standard_v2")});
    for (std::size_t i = 0; i < 2; ++i) robots.push_back(begin(*model, i, scene->starts[i], 5, 0, variation));
    people = begin_people(*model, robots, 5);
    const std::vector<Velocity> commands(2, {0.2, 0.0, 0.3});
    for (int i = 0; i < 120; ++i) step(*model, robots, commands, people);
  }
  CapturePose capture(std::size_t robot = 0) const { return capture_pose(robots, people, robot); }
};

struct Drawn {
  std::vector<std::uint8_t> color;
  std::vector<float> depth;
  friend bool operator==(const Drawn&, const Drawn&) = default;
};

Drawn draw_at(const Clinic& clinic, const CapturePose& capture, const CameraIntrinsics& camera, DrawScratch& scratch) {
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  Drawn drawn{std::vector<std::uint8_t>(3 * pixels), std::vector<float>(pixels)};
  draw(*clinic.model, capture, camera, {drawn.color, drawn.depth}, scratch);
  return drawn;
}

}  // namespace

TEST_CASE("at its own size a camera draws what it delivers") {
  const Clinic clinic;
  DrawScratch scratch;
  const RGBDImage picture = draw_picture(*clinic.model, clinic.capture());
  const Drawn drawn = draw_at(clinic, clinic.capture(), picture.intrinsics, scratch);
  CHECK(drawn.color == picture.color);
  CHECK(drawn.depth == picture.depth);
}

TEST_CASE("scratch and shots remember nothing") {
  const Clinic clinic;
  const CameraIntrinsics small = make_intrinsics(64, 64, 1.2);
  const CameraIntrinsics large = make_intrinsics(96, 40, 0.9);
  DrawScratch fresh;
  const Drawn expected = draw_at(clinic, clinic.capture(), small, fresh);

  DrawScratch used;
  CapturePose capture = clinic.capture(1);
  capture.robots.resize(7);
  draw_at(clinic, clinic.capture(), large, used);
  capture_pose(clinic.robots, clinic.people, 0, capture);
  CHECK(draw_at(clinic, capture, small, used) == expected);
}

TEST_CASE("an image that nobody asks for changes no other") {
  const Clinic clinic;
  const CameraIntrinsics camera = make_intrinsics(64, 64, 1.2);
  DrawScratch scratch;
  const Drawn both = draw_at(clinic, clinic.capture(), camera, scratch);
  Drawn one{std::vector<std::uint8_t>(std::size_t{3} * 4096), std::vector<float>(4096)};
  draw(*clinic.model, clinic.capture(), camera, {one.color, {}}, scratch);
  draw(*clinic.model, clinic.capture(), camera, {{}, one.depth}, scratch);
  CHECK(one == both);
}

TEST_CASE("depth of a camera that measures none is refused") {
  const Clinic clinic;
  DrawScratch scratch;
  CHECK_THROWS_AS(draw_at(clinic, clinic.capture(1), make_intrinsics(8, 8, 1.2), scratch), ConfigError);
}

TEST_CASE("a camera that is moved on its mount sees what is seen from there") {
  models::Variation variation;
  variation.camera_offset = {0.03, -0.02, 0.1};
  variation.camera_height = 0.04;
  variation.camera_noise = 0.0;
  const Clinic clinic(variation);
  const CameraSpec& spec = *clinic.model->robots[0].profile.camera;
  const Pose2D& mount = spec.base_from_camera;
  const Pose2D moved{mount.x + 0.03, mount.y - 0.02, mount.theta + 0.1};
  const CameraIntrinsics camera = make_intrinsics(80, 60, spec.horizontal_fov);
  const SemanticImage truth = draw_truth(*clinic.model, clinic.capture(), camera,
                                         {clinic.robots[0].pose * moved, spec.mount_height + 0.04}, false);
  DrawScratch scratch;
  const Drawn drawn = draw_at(clinic, clinic.capture(), camera, scratch);
  CHECK(drawn.color == truth.image.color);
  for (std::size_t i = 0; i < drawn.depth.size(); ++i) {
    const float true_depth = truth.image.depth[i];
    const bool within = static_cast<double>(true_depth) >= spec.depth->range_min &&
                        static_cast<double>(true_depth) <= spec.depth->range_max;
    CHECK(drawn.depth[i] == (within ? true_depth : 0.0F));
  }
}

TEST_CASE("noise grows by its factor and moves nothing") {
  const auto noise = [](double factor) {
    models::Variation variation;
    variation.camera_noise = factor;
    const Clinic clinic(variation);
    DrawScratch scratch;
    return draw_at(clinic, clinic.capture(), make_intrinsics(80, 60, 1.2), scratch);
  };
  const Drawn clean = noise(0.0);
  const auto spread = [&](const Drawn& drawn) {
    double colors = 0.0;
    double depths = 0.0;
    for (std::size_t i = 0; i < drawn.color.size(); ++i) {
      const int off = drawn.color[i] - clean.color[i];
      colors += off * off;
    }
    for (std::size_t i = 0; i < drawn.depth.size(); ++i) {
      if (drawn.depth[i] == 0.0F || clean.depth[i] == 0.0F) continue;
      const auto depth = static_cast<double>(clean.depth[i]);
      const double off = (static_cast<double>(drawn.depth[i]) - depth) / (depth * depth);
      depths += off * off;
    }
    return std::pair{std::sqrt(colors), std::sqrt(depths)};
  };
  const auto [color_1, depth_1] = spread(noise(1.0));
  const auto [color_3, depth_3] = spread(noise(3.0));
  CHECK(color_3 / color_1 == doctest::Approx(3.0).epsilon(0.05));
  CHECK(depth_3 / depth_1 == doctest::Approx(3.0).epsilon(0.05));
}

namespace {

// A picture without noise, and what is truly there.
SemanticImage truth_with(const models::Variation& variation) {
  const Clinic clinic(variation);
  const CameraSpec& spec = *clinic.model->robots[0].profile.camera;
  return draw_truth(*clinic.model, clinic.capture(), make_intrinsics(120, 90, spec.horizontal_fov),
                    {clinic.robots[0].pose * spec.base_from_camera, spec.mount_height}, false);
}

// Whether each value of a picture is another's times a factor: by channel, to within a level, up to 255.
bool is_scaled(const RGBDImage& picture, const RGBDImage& plain, const std::array<double, 3>& factors) {
  for (std::size_t i = 0; i < plain.color.size(); ++i) {
    if (plain.color[i] == 255) continue;  // it may have been more
    const double expected = std::min(255.0, factors[i % 3] * plain.color[i]);
    if (std::fabs(picture.color[i] - expected) > 1.0 + 0.6 * factors[i % 3]) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("light and exposure scale brightness until it saturates, and nothing else") {
  const SemanticImage plain = truth_with({});
  for (const auto& [light, exposure] : {std::pair{0.5, 1.0}, {1.5, 1.0}, {1.0, 0.6}, {1.0, 2.0}, {1.4, 0.7}}) {
    models::Variation variation;
    variation.light = light;
    variation.exposure = exposure;
    const SemanticImage varied = truth_with(variation);
    const double factor = light * exposure;
    CHECK(is_scaled(varied.image, plain.image, {factor, factor, factor}));
    CHECK(varied.image.color != plain.image.color);
    CHECK(varied.image.depth == plain.image.depth);
    CHECK(varied.ids == plain.ids);
  }
}

TEST_CASE("colours jitter by channel, each episode otherwise, and nothing else changes") {
  models::Variation variation;
  variation.color_jitter = 0.1;
  const SemanticImage plain = truth_with({});
  const SemanticImage varied = truth_with(variation);
  const Clinic clinic(variation);
  CHECK(is_scaled(varied.image, plain.image, models::color_gains(variation, clinic.capture().key)));
  CHECK(varied.image.color != plain.image.color);
  CHECK(varied.image.depth == plain.image.depth);
  CHECK(varied.ids == plain.ids);
}

// What a variation makes of a picture: nothing but its colors changes, and these do unless they stay as they are.
SemanticImage with_other_colors(const SemanticImage& plain, const models::Variation& variation, bool as_they_are) {
  SemanticImage varied = truth_with(variation);
  CHECK((varied.image.color == plain.image.color) == as_they_are);
  CHECK(varied.image.depth == plain.image.depth);
  CHECK(varied.ids == plain.ids);
  return varied;
}

TEST_CASE("less detail changes colours alone") {
  const SemanticImage plain = truth_with({});
  for (const double detail : {0.0, 0.3, 1.0}) {
    models::Variation variation;
    variation.detail = detail;
    (void)with_other_colors(plain, variation, detail == 1.0);
  }
}

TEST_CASE("other textures change colours alone") {
  const SemanticImage plain = truth_with({});
  std::set<std::string> pictures;
  for (int texture = 0; texture < 6; ++texture) {
    models::Variation variation;
    variation.texture = texture;
    const SemanticImage varied = with_other_colors(plain, variation, texture == 0);
    pictures.insert({varied.image.color.begin(), varied.image.color.end()});
  }
  CHECK(pictures.size() == 6);
}
