#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "backend/mock/mock_world.hpp"
#include "sim/camera.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;
using namespace threewe::backend;

namespace {

WorldOptions options(NoiseLevel noise) {
  WorldOptions options;
  options.robots = {"3we_depth_v2"};
  options.noise = noise;
  options.seed = 5;
  return options;
}

// The pictures that arrive in the next seconds of a robot that drives an arc.
std::vector<Sample> pictures_of(World& world, double seconds) {
  std::vector<Sample> pictures;
  const Time end = world.now() + from_seconds(seconds);
  while (world.now() < end) {
    world.robot(0).command({0.3, 0.1, 0.5}, world.now() + 200ms);
    world.advance_to(world.now() + 20ms);
    for (Sample& sample : world.robot(0).poll()) {
      if (std::holds_alternative<Picture>(sample.data)) pictures.push_back(std::move(sample));
    }
  }
  return pictures;
}

const RGBDImage& image_of(const Sample& sample) { return std::get<Picture>(sample.data).image(); }

std::unique_ptr<World> connected(NoiseLevel noise) {
  std::unique_ptr<World> world = make_world("mock", options(noise));
  world->robot(0).connect();
  return world;
}

}  // namespace

TEST_CASE("pictures come at the camera's rate, and as late as the profile says") {
  const auto world = connected(NoiseLevel::realistic);
  const std::vector<Sample> pictures = pictures_of(*world, 1.0);
  const CameraSpec& camera = *world->robot(0).profile().camera;
  REQUIRE(pictures.size() == 27);  // 30 were taken, the last 3 are on their way
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    CHECK(pictures[i].sequence == i);
    const Time due = static_cast<Duration::rep>(i + 1) * camera.period;
    CHECK(pictures[i].measured >= due);
    CHECK(pictures[i].measured < due + 10ms);
    CHECK(pictures[i].received - pictures[i].measured >= camera.latency);
    CHECK(pictures[i].received - pictures[i].measured < camera.latency + 20ms);
  }
  CHECK(image_of(pictures[0]).color.size() == std::size_t{640} * 480 * 3);
  CHECK(image_of(pictures[0]).depth.size() == std::size_t{640} * 480);
}

TEST_CASE("a picture shows what was in sight as it was taken, not as it is looked at") {
  const auto world = connected(NoiseLevel::ideal);
  const CameraSpec& camera = *world->robot(0).profile().camera;
  world->advance_to(300ms);
  (void)world->robot(0).poll();
  for (int i = 0; i < 40; ++i) {
    world->robot(0).command({0.3, 0.1, 0.5}, world->now() + 200ms);
    world->advance_to(world->now() + 10ms);
    const Pose2D eye = world->truth_service()->truth(0).true_pose() * camera.base_from_camera;
    const std::vector<Sample> samples = world->robot(0).poll();
    if (!std::holds_alternative<Picture>(samples.back().data)) continue;
    const SemanticImage truth =
        world->truth_service()->truth(0).look(camera.intrinsics(), eye, camera.mount_height, false);
    world->robot(0).command({0.3, 0.1, 0.5}, world->now() + 200ms);
    world->advance_to(world->now() + 10ms);  // it has moved on before anybody looks
    CHECK(image_of(samples.back()).color == truth.image.color);
    i += 1;
  }
}

TEST_CASE("every picture has noise of its own, which seed and time alone decide") {
  const auto world = connected(NoiseLevel::realistic);
  const auto again = connected(NoiseLevel::realistic);
  (void)world->robot(0).poll();
  const auto stand = [](World& w) {
    w.advance_to(w.now() + 200ms);
    std::vector<Sample> pictures;
    for (Sample& sample : w.robot(0).poll()) {
      if (std::holds_alternative<Picture>(sample.data)) pictures.push_back(std::move(sample));
    }
    return pictures;
  };
  const std::vector<Sample> pictures = stand(*world);
  const std::vector<Sample> others = stand(*again);
  REQUIRE(pictures.size() == 3);
  CHECK(image_of(pictures[0]).color != image_of(pictures[1]).color);
  CHECK(image_of(others[1]) == image_of(pictures[1]));  // though its first was never looked at
}

TEST_CASE("pictures on their way are saved and restored") {
  const auto world = connected(NoiseLevel::realistic);
  (void)pictures_of(*world, 0.5);
  const std::vector<std::byte> saved = world->save();
  const std::vector<Sample> first = pictures_of(*world, 0.3);
  world->restore(saved);
  const std::vector<Sample> second = pictures_of(*world, 0.3);
  const auto elsewhere = connected(NoiseLevel::realistic);
  elsewhere->restore(saved);
  const std::vector<Sample> third = pictures_of(*elsewhere, 0.3);
  REQUIRE(first.size() == second.size());
  REQUIRE(first.size() == third.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].measured == second[i].measured);
    CHECK(image_of(first[i]) == image_of(second[i]));
    CHECK(image_of(first[i]) == image_of(third[i]));
  }
}

TEST_CASE("nobody looks, nothing is drawn") {
  const auto world = connected(NoiseLevel::realistic);
  for (const Sample& sample : pictures_of(*world, 0.5)) CHECK(!std::get<Picture>(sample.data).is_drawn());
}
