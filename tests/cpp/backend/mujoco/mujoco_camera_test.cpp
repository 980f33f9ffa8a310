// What cameras see on MuJoCo, against what the embedded simulator's see from the same place.
#if THREEWE_WITH_MUJOCO
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "backend/mock/mock_world.hpp"
#include "backend/mujoco/worlds.hpp"

namespace threewe::backend {
namespace {

using namespace testing;

WorldOptions with_depth(const std::string& scene, std::size_t robots = 1) {
  WorldOptions options;
  options.scene = scene;
  options.robots = std::vector<std::string>(robots, "3we_depth_v2");
  options.noise = NoiseLevel::ideal;
  return options;
}

/// The newest picture of a robot that stands for 0.2 s.
Picture take_picture(World& world) {
  Picture newest;
  for (int i = 0; i < 10; ++i) {
    world.advance_to(world.now() + kControlPeriod);
    std::vector<Sample> samples = world.robot(0).poll();
    keep_newest(samples, newest);
  }
  return newest;
}

/// The share of pixels that show another thing, or that at another depth.
double difference(const SemanticImage& a, const SemanticImage& b) {
  std::size_t differ = 0;
  for (std::size_t i = 0; i < a.ids.size(); ++i) {
    const float off = std::abs(a.image.depth[i] - b.image.depth[i]);
    if (a.ids[i] != b.ids[i] || off > std::max(0.02F, 0.01F * b.image.depth[i])) ++differ;
  }
  return static_cast<double>(differ) / static_cast<double>(a.ids.size());
}

/// Of all pixels that show something, blue, green, red.
std::array<double, 3> mean_color(const SemanticImage& truth) {
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < truth.image.color.size(); ++i) sum[i % 3] += truth.image.color[i];
  for (double& channel : sum) channel /= static_cast<double>(truth.ids.size());
  return sum;
}

TEST_CASE("any camera shows the same things, as far off, in about the same colours") {
  for (const std::string scene : {"office_v2", "outdoor_v1", "dynamic_v1"}) {
    const auto world = connected(with_depth(scene));
    mock::MockWorld mock(with_depth(scene));
    CAPTURE(scene);
    const CameraIntrinsics square = make_intrinsics(160, 120, 1.4);
    const CameraIntrinsics shifted{120, 100, 90.0, 90.0, 40.5, 70.25};
    const CameraIntrinsics wide{100, 120, 60.0, 110.0, 50.0, 60.0};  // its pixels are not square
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const Pose2D pose = truth(*world).sample_free_pose(seed);
      const double height = 0.1 + 0.12 * static_cast<double>(seed);
      for (const CameraIntrinsics& camera : {square, shifted, wide}) {
        const SemanticImage seen = truth(*world).look(camera, pose, height, true);
        const SemanticImage expected = truth(mock).look(camera, pose, height, true);
        CHECK(seen.names == expected.names);
        CHECK_MESSAGE(difference(seen, expected) < 0.02, seed << " " << camera.width);  // edges are in it
        for (std::size_t i = 0; i < 3; ++i) {
          CHECK(mean_color(seen)[i] == doctest::Approx(mean_color(expected)[i]).epsilon(0.35));
        }
      }
    }
  }
}

TEST_CASE("a picture is the same to the bit on every thread, and outlives its world") {
  auto world = connected(with_depth("apartment_v1"));
  auto twin = connected(with_depth("apartment_v1"));
  const Picture first = take_picture(*world);
  const Picture second = take_picture(*twin);
  world.reset();
  RGBDImage elsewhere;
  std::thread([&] { elsewhere = second.image(); }).join();
  CHECK(first.image() == elsewhere);
  CHECK(first.image().intrinsics.width == 640);
  CHECK(!first.image().depth.empty());
}

TEST_CASE("worlds draw side by side") {
  std::vector<Picture> pictures;
  for (int i = 0; i < 3; ++i) pictures.push_back(take_picture(*connected(with_depth("apartment_v1"))));
  std::vector<std::thread> threads;
  for (const Picture& picture : pictures) threads.emplace_back([&picture] { CHECK(!picture.image().color.empty()); });
  for (std::thread& thread : threads) thread.join();
  CHECK(pictures[0].image() == pictures[1].image());
  CHECK(pictures[0].image() == pictures[2].image());
}

TEST_CASE("a robot sees another, and itself only where it is asked to") {
  WorldOptions options = with_depth("warehouse_v1", 2);
  const Pose2D start = truth(*connected(with_depth("warehouse_v1"))).true_pose();
  options.poses = {start, start * Pose2D{0.8, 0.0, 0.0}};
  const auto world = connected(options);
  world->advance_to(500ms);
  const CameraIntrinsics camera = make_intrinsics(80, 60, 1.4);
  const auto names_in = [&](const Pose2D& pose, bool with_itself) {
    const SemanticImage seen = truth(*world).look(camera, pose, 0.1, with_itself);
    std::vector<std::string> names;
    for (const std::int16_t id : seen.ids) names.push_back(seen.names[static_cast<std::size_t>(id)]);
    return names;
  };
  const auto among = [](const std::vector<std::string>& names, const char* name) {
    return std::ranges::count(names, name);
  };
  CHECK(among(names_in(start, false), "robot_1") > 20);
  CHECK(among(names_in(start, false), "robot_0") == 0);
  const Pose2D behind = start * Pose2D{-0.6, 0.0, 0.0};
  CHECK(among(names_in(behind, true), "robot_0") > 20);
  CHECK(among(names_in(behind, false), "robot_0") == 0);
}

TEST_CASE("other textures change colours alone") {
  WorldOptions options = with_depth("apartment_v1");
  const auto pictures = [&options](const char* texture) {
    options.randomization = always(texture);
    const auto world = connected(options);
    return std::pair(take_picture(*world).image(),
                     truth(*world).look(make_intrinsics(160, 120, 1.4), {0.3, 0.2, 0.5}, 0.6, true));
  };
  const auto [plain, plainly_there] = pictures("texture: 0");
  const auto [brick, there] = pictures("texture: 3");
  const auto changed = [](const RGBDImage& a, const RGBDImage& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.color.size(); ++i) count += std::abs(a.color[i] - b.color[i]) > 3 ? 1U : 0U;
    return static_cast<double>(count) / static_cast<double>(a.color.size());
  };
  CHECK(changed(plain, brick) > 0.3);
  CHECK(changed(plainly_there.image, there.image) > 0.3);
  CHECK(brick == pictures("texture: 3").first);
  CHECK(changed(brick, pictures("texture: 4").first) > 0.1);
  CHECK(brick.depth == plain.depth);
  CHECK(there.image.depth == plainly_there.image.depth);
  CHECK(there.ids == plainly_there.ids);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(mean_color(there)[i] == doctest::Approx(mean_color(plainly_there)[i]).epsilon(0.2));
  }
}

TEST_CASE("light and exposure vary") {
  WorldOptions options = with_depth("apartment_v1");
  const auto brightness = [&options] {
    const auto world = connected(options);
    const Picture picture = take_picture(*world);
    double sum = 0.0;
    for (const std::uint8_t value : picture.image().color) sum += value;
    return sum / static_cast<double>(picture.image().color.size());
  };
  const double usual = brightness();
  options.randomization = always("light: 0.5");
  CHECK(brightness() == doctest::Approx(0.5 * usual).epsilon(0.02));
}

}  // namespace
}  // namespace threewe::backend
#endif
