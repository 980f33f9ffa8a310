// The renderer against a ray tracer that tries every solid for every pixel, on every vector target of this machine.
#include "sim/renderer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "core/exact.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "sim/comparison.hpp"
#include "sim/ray_tracer.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

constexpr double kPi = exact::kPi;
scene::Prism random_prism(Draw& draw) {
  scene::Prism prism;
  prism.shape = draw.whole(0, 2) ? scene::Prism::Shape::box : scene::Prism::Shape::cylinder;
  prism.pose = draw.pose(-0.4, 0.4);
  prism.length = draw(0.02, 1.2);
  prism.width = draw(0.02, 0.8);
  prism.radius = draw(0.01, 0.4);
  const double heights[] = {0.0, 0.12, 0.4, 0.75, 1.2, 2.6};  // stacked, hanging, and at the height of the camera
  const int low = draw.whole(0, 4);
  prism.z_min = heights[low];
  prism.z_max = draw.whole(0, 1) ? heights[draw.whole(low + 1, 5)] : prism.z_min + draw(0.01, 1.0);
  const char* const materials[] = {"wood", "metal", "plastic", "fabric", "leaf", "ceramic", "glass", "stone", "paper"};
  prism.material = materials[draw.whole(0, 8)];
  return prism;
}

// Rooms with and without a ceiling, walls of one height or several, objects anywhere, also through one another.
scene::Scene random_scene(Draw& draw) {
  scene::Scene scene;
  const double size = draw(3.0, 12.0);
  const double height = draw(2.2, 3.0);
  const auto wall = [&](Vec2 a, Vec2 b) { scene.walls.push_back({a, b, draw(0.05, 0.3), height}); };
  if (draw.whole(0, 3)) {
    wall({0.0, 0.0}, {size, 0.0});
    wall({size, 0.0}, {size, size});
    wall({size, size}, {0.0, size});
    wall({0.0, size}, {0.0, 0.0});
  }
  for (int i = draw.whole(0, 4); i > 0; --i) {
    const Vec2 a = draw.point(0.0, size);
    wall(a, a + rotate({draw(0.5, 4.0), 0.0}, draw.whole(0, 1) ? 0.5 * kPi * draw.whole(0, 3) : draw(-kPi, kPi)));
  }
  if (draw.whole(0, 3) == 0) {
    for (scene::Wall& w : scene.walls) w.height = draw(0.3, 3.0);
  }
  scene.ceiling = draw.whole(0, 2) != 0;
  const std::string floors[] = {"wood", "tile", "carpet", "concrete", "vinyl", "grass", "gravel", "paving", "asphalt"};
  if (draw.whole(0, 2)) {
    const double middle = draw(1.0, size - 1.0);
    scene.rooms.push_back({"west", {0.0, 0.0}, {middle, size}, floors[draw.whole(0, 8)], {}});
    scene.rooms.push_back({"east", {middle, 0.0}, {size, size}, floors[draw.whole(0, 8)], {}});
  }
  for (int i = draw.whole(0, 3); i > 0; --i) {
    const Vec2 corner = draw.point(0.0, size);
    const Vec2 far = corner + Vec2{draw(0.1, 4.0), draw(0.1, 4.0)};
    scene.patches.push_back({"patch", corner, far, floors[draw.whole(0, 8)], draw(0.3, 1.0)});
  }
  for (int i = draw.whole(0, 12); i > 0; --i) {
    scene::Object object;
    object.pose = draw.pose(0.0, size);
    for (int k = draw.whole(1, 5); k > 0; --k) object.prisms.push_back(random_prism(draw));
    scene.objects.push_back(object);
  }
  scene.max = {size, size};
  return scene;
}

CameraIntrinsics random_camera(Draw& draw) {
  const std::pair<int, int> sizes[] = {{48, 36}, {64, 64}, {1, 1}, {1, 120}, {120, 1}, {33, 17}, {50, 40}, {300, 9}};
  const auto [width, height] = sizes[draw.whole(0, 7)];
  CameraIntrinsics camera = make_intrinsics(width, height, draw(0.3, 2.2));
  if (width == 1) camera.fx = camera.fy = draw(20.0, 60.0);
  if (draw.whole(0, 2) == 0) camera.cx += draw(-20.0, 20.0), camera.cy += draw(-20.0, 20.0), camera.fy *= 1.3;
  return camera;
}

CameraPose random_view(Draw& draw, const scene::Scene& scene) {
  CameraPose view{draw.pose(-0.5, scene.max.x + 0.5), draw(0.02, 2.0)};
  if (draw.whole(0, 3) == 0) view.height = draw.whole(0, 1) ? 0.12 : 0.75;
  if (draw.whole(0, 4) == 0) view.pose.theta = 0.5 * kPi * draw.whole(-1, 2);
  return view;
}

TEST_CASE("random scenes") {
  Comparison comparison;
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    Draw draw(seed);
    const scene::Scene scene = random_scene(draw);
    const Renderer renderer(scene);
    for (int k = 0; k < 3; ++k) {
      const CameraIntrinsics camera = random_camera(draw);
      const CameraPose view = random_view(draw, scene);
      const Shading shading{seed, 0};
      comparison.compare({scene, camera, view, shading}, camera, take(renderer, camera, view, shading));
      INFO("seed ", seed, ", picture ", k, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
  }
  MESSAGE(comparison.pixels, " pixels, ", comparison.grazing, " on edges, ", comparison.other_level,
          " on another level of texture, ", comparison.other_texel, " on another texel");
  CHECK(comparison.grazing < comparison.pixels / 200);
  CHECK(comparison.other_level < comparison.pixels / 200);
  CHECK(comparison.other_texel < comparison.pixels / 100);
}

TEST_CASE("beside walls, at corners, among and under furniture") {
  Comparison comparison;
  for (std::uint64_t seed = 1000; seed < 1200; ++seed) {
    Draw draw(seed);
    const scene::Scene scene = random_scene(draw);
    const Renderer renderer(scene);
    if (renderer.solids().empty()) continue;
    const auto last = static_cast<int>(renderer.solids().size()) - 1;
    const scene::Solid& solid = renderer.solids()[static_cast<std::size_t>(draw.whole(0, last))].solid;
    const CameraIntrinsics camera = random_camera(draw);
    CameraPose view = random_view(draw, scene);
    const double gap = std::exp(draw(std::log(1e-4), std::log(0.5)));
    const Vec2 place = draw.whole(0, 1) ? solid.center : solid.center + rotate({solid.radius + gap, 0.0}, draw(-3, 3));
    const Vec2 target = (solid.shape == scene::Solid::Shape::box ? solid.corners[0] : solid.center) - place;
    view.pose = {place.x, place.y, draw.whole(0, 1) ? draw(-kPi, kPi) : exact::atan2(target.y, target.x)};
    const Shading shading{seed, 0};
    comparison.compare({scene, camera, view, shading}, camera, take(renderer, camera, view, shading));
    INFO("seed ", seed, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }
  MESSAGE(comparison.pixels, " pixels, ", comparison.grazing, " on edges");
}

TEST_CASE("the shipped scenes") {
  for (const std::string& name : scene::scene_names()) {
    const scene::Scene scene = scene::Scene::load(name);
    const Renderer renderer(scene);
    Comparison comparison;
    for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
      Draw draw(seed);
      const CameraIntrinsics camera = make_intrinsics(80, 60, draw(0.5, 1.8));
      const CameraPose view{{draw(scene.min.x, scene.max.x), draw(scene.min.y, scene.max.y), draw(-kPi, kPi)},
                            draw(0.05, 1.5)};
      const Shading shading{seed, 1};
      comparison.compare({scene, camera, view, shading}, camera, take(renderer, camera, view, shading));
      INFO(name, ", seed ", seed, ", ", comparison.first_wrong);
      REQUIRE(comparison.wrong == 0);
    }
    MESSAGE(name, ": ", comparison.pixels, " pixels, ", comparison.grazing, " on edges");
  }
}

TEST_CASE("a doorway has a lintel") {
  const scene::Scene scene = scene::Scene::load("office_v2");
  const Renderer renderer(scene);
  for (const scene::Door& door : scene.doors) {
    CAPTURE(door.name);
    const auto over = [&](const VisibleSolid& s) {
      return s.id == kWallId && s.solid.z_min == view::kDoorHeight && distance(s.solid.center, door.center) < 1e-9;
    };
    CHECK(std::ranges::count_if(renderer.solids(), over) == 1);
  }
}

TEST_CASE("pictures of less detail") {
  Comparison comparison;
  for (std::uint64_t seed = 5000; seed < 5080; ++seed) {
    Draw draw(seed);
    const scene::Scene scene = draw.whole(0, 1) ? random_scene(draw) : scene::Scene::load("office_v2");
    const Renderer renderer(scene);
    const CameraIntrinsics camera = random_camera(draw);
    const CameraPose view = random_view(draw, scene);
    const float detail = draw.whole(0, 2) ? static_cast<float>(draw(0.0, 1.0)) : 0.0F;
    const Shading shading{seed, 0, static_cast<std::uint32_t>(draw.whole(0, 5)), {1.0F, 1.0F, 1.0F}, detail};
    comparison.compare({scene, camera, view, shading}, camera, take(renderer, camera, view, shading));
    INFO("seed ", seed, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }
}

TEST_CASE("without detail walls have the colour of their light, whatever they are made of") {
  const scene::Scene scene = scene::Scene::load("office_v2");
  const Renderer renderer(scene);
  const CameraIntrinsics camera = make_intrinsics(64, 48, 1.5);
  const CameraPose view{{2.0, 2.0, 0.0}, 0.3};
  const auto colours_of_walls = [&](const Shading& shading) {
    const Picture picture = take(renderer, camera, view, shading);
    std::set<std::vector<std::uint8_t>> colours;
    for (std::size_t i = 0; i < picture.ids.size(); ++i) {
      if (picture.ids[i] != kWallId) continue;
      const auto pixel = picture.colour.begin() + static_cast<std::ptrdiff_t>(3 * i);
      colours.insert({pixel, pixel + 3});
    }
    return colours;
  };
  const auto plain = colours_of_walls({.detail = 0.0F});
  CHECK(plain.size() <= 5);  // one for each direction, and one of lintels from below
  CHECK(colours_of_walls({.texture = 7, .detail = 0.0F}) == plain);
  CHECK(colours_of_walls({}).size() > 20);
}

TEST_CASE("other patterns, and light of any colour") {
  Comparison comparison;
  for (std::uint64_t seed = 4000; seed < 4060; ++seed) {
    Draw draw(seed);
    const scene::Scene scene = random_scene(draw);
    const Renderer renderer(scene);
    const CameraIntrinsics camera = random_camera(draw);
    const CameraPose view = random_view(draw, scene);
    const auto gain = [&] { return static_cast<float>(draw.whole(0, 5) ? draw(0.2, 2.5) : 0.0); };
    const Shading shading{seed, 0, static_cast<std::uint32_t>(draw.whole(0, 50)), {gain(), gain(), gain()}};
    comparison.compare({scene, camera, view, shading}, camera, take(renderer, camera, view, shading));
    INFO("seed ", seed, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }
}

TEST_CASE("surfaces wear each of the patterns for their use, one as often as the other") {
  using enum Material;
  const auto worn_by = [](Material material) {
    std::map<Material, int> counts;
    for (std::uint32_t texture = 1; texture <= 9000; ++texture) {
      ++counts[view::patterns_of(texture)[static_cast<std::size_t>(material)]];
    }
    return counts;
  };
  const auto floors = worn_by(floor_tile);
  CHECK(floors.size() == 9);
  for (const auto& [material, count] : floors) CHECK(std::abs(count - 1000) < 150);
  CHECK(worn_by(wood).size() == 11);
  CHECK(worn_by(shading).size() == 6);
  CHECK(worn_by(ceiling).size() == 4);
  for (const Material same : {window, picture, sky, skin, trim}) CHECK(worn_by(same).size() == 1);

  const auto plain = view::patterns_of(0);
  for (std::size_t m = 0; m < plain.size(); ++m) CHECK(plain[m] == static_cast<Material>(m));
}

TEST_CASE("what moves is drawn as what stands") {
  Comparison comparison;
  for (std::uint64_t seed = 2000; seed < 2050; ++seed) {
    Draw draw(seed);
    const scene::Scene scene = random_scene(draw);
    const Renderer renderer(scene);
    const Shading shading{seed, 0};
    std::vector<VisibleSolid> moving;
    for (int i = draw.whole(1, 5); i > 0; --i) {
      VisibleSolid solid{scene::solid_of(random_prism(draw), draw.pose(0.0, scene.max.x), -1), Material::fabric, 100};
      solid.colour = {20.0F, 120.0F, 200.0F};
      moving.push_back(solid);
    }
    const CameraIntrinsics camera = random_camera(draw);
    const CameraPose view = random_view(draw, scene);
    comparison.compare({scene, camera, view, shading, moving}, camera, take(renderer, camera, view, shading, moving));
    INFO("seed ", seed, ", ", comparison.first_wrong);
    REQUIRE(comparison.wrong == 0);
  }
}

TEST_CASE("the lidar's plane cut out of the depth image is the scan") {
  int rays = 0;
  int wrong = 0;
  for (const std::string name : {"office_v2", "corridor_v1"}) {
    const scene::Scene scene = scene::Scene::load(name);
    const Renderer renderer(scene);
    const CameraIntrinsics camera{320, 1, 200.0, 200.0, 160.0, 0.5};  // one row, level
    for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
      Draw draw(seed);
      const CameraPose view{{draw(scene.min.x, scene.max.x), draw(scene.min.y, scene.max.y), draw(-kPi, kPi)},
                            draw(0.05, 1.9)};
      const scene::Slice slice = scene.at_height(view.height);
      const Picture picture = take(renderer, camera, view, Shading{0, 0});
      for (int column = 0; column < camera.width; ++column) {
        const double s = (camera.cx - (column + 0.5)) / camera.fx;
        const double angle = view.pose.theta + exact::atan2(s, 1.0);
        const double range = scene::cast_ray(slice, view.pose.position(), angle, 100.0);
        const auto depth = static_cast<double>(picture.depth[static_cast<std::size_t>(column)]);
        const double seen = depth > 0.0 ? depth * std::hypot(1.0, s) : 100.0;
        ++rays;
        wrong += std::fabs(seen - range) > 0.01 ? 1 : 0;
      }
    }
  }
  MESSAGE(rays, " rays, ", wrong, " differ");
  CHECK(wrong * 1000 < rays);
}

TEST_CASE("an image that is left out changes no other") {
  const scene::Scene scene = scene::Scene::load("office_v2");
  const Renderer renderer(scene);
  const Shading shading{3, 4};
  const CameraIntrinsics camera = make_intrinsics(50, 40, 1.2);
  const CameraPose view{{0.0, 0.0, 0.3}, 0.12};
  const Picture all = take(renderer, camera, view, shading);
  for (int which = 0; which < 8; ++which) {
    Picture picture(camera);
    const Picture untouched(camera);
    Images images;
    if (which & 1) images.colour = picture.colour;
    if (which & 2) images.depth = picture.depth;
    if (which & 4) images.ids = picture.ids;
    RenderScratch scratch;
    renderer.render(camera, view, shading, images, scratch);
    CHECK(picture.colour == (which & 1 ? all : untouched).colour);
    CHECK(picture.depth == (which & 2 ? all : untouched).depth);
    CHECK(picture.ids == (which & 4 ? all : untouched).ids);
  }
}

TEST_CASE("colours are blue, green, red") {
  scene::Scene scene;
  const Renderer renderer(scene);
  VisibleSolid red{scene::make_box({2.0, 0.0, 0.0}, 0.5, 4.0), Material::plastic, 9};
  red.solid.z_max = 2.0;
  red.colour = {20.0F, 40.0F, 220.0F};
  const CameraIntrinsics camera = make_intrinsics(8, 8, 0.5);
  const Picture picture = take(renderer, camera, {{}, 0.5}, Shading{0, 0}, std::span(&red, 1));
  for (std::size_t i = 0; i < 64; ++i) {
    CHECK(picture.colour[3 * i + 2] > 130);
    CHECK(picture.colour[3 * i] < 40);
  }
}

TEST_CASE("an episode's colours are a pure function of seed, episode and object") {
  const scene::Scene scene = scene::Scene::load("office_v2");
  const Renderer renderer(scene);
  const std::size_t count = renderer.solids().size();
  const auto colours = [&](const Shading& shading) {
    std::vector<Colour> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(renderer.colour(shading, i));
    return all;
  };
  CHECK(colours({5, 6}) == colours({5, 6}));
  CHECK(colours({5, 6}) != colours({5, 7}));
  CHECK(colours({5, 6}) != colours({6, 6}));

  // every object comes in six tints at least
  for (std::size_t i = 0; i < count; ++i) {
    if (renderer.solids()[i].id < kFirstObjectId) continue;
    std::set<std::tuple<float, float, float>> tints;
    for (std::uint32_t episode = 0; episode < 100; ++episode) {
      const Colour c = renderer.colour({0, episode}, i);
      tints.insert({c.b, c.g, c.r});
    }
    CHECK(tints.size() >= 6);
  }
}

// Everything that the kernel does, in bits.
std::vector<Picture> all_kinds_of_pictures() {
  std::vector<Picture> all;
  for (std::uint64_t seed = 3000; seed < 3040; ++seed) {
    Draw draw(seed);
    const scene::Scene scene = random_scene(draw);
    const Renderer renderer(scene);
    Shading shading{seed, 0, static_cast<std::uint32_t>(draw.whole(0, 2)), {static_cast<float>(draw(0.1, 2.0))}};
    shading.detail = seed % 2 == 0 ? 1.0F : 0.3F;
    all.push_back(take(renderer, random_camera(draw), random_view(draw, scene), shading));
  }
  return all;
}

TEST_CASE("the same bits on every target") {
  const auto expected = all_kinds_of_pictures();
  const auto targets = available_targets();
  for (const std::string& target : targets) {
    force_target(target);
    CAPTURE(target);
    CHECK(all_kinds_of_pictures() == expected);
    force_target("");
  }
  if (targets.size() < 2) MESSAGE("not shown: this machine has one target only");
  MESSAGE(targets.size(), " targets executed");
}

TEST_CASE("threads share a renderer, and scratch remembers nothing") {
  const scene::Scene scene = scene::Scene::load("corridor_v1");
  const Renderer renderer(scene);
  const Shading shading{1, 2};
  const auto series = [&] {
    std::vector<Picture> pictures;
    RenderScratch scratch;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      Draw draw(seed);
      const CameraIntrinsics camera = random_camera(draw);
      Picture& picture = pictures.emplace_back(camera);
      renderer.render(camera, random_view(draw, scene), shading, picture.images(), scratch);
    }
    return pictures;
  };
  std::vector<Picture> expected;
  expected.reserve(10);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Draw draw(seed);
    const CameraIntrinsics camera = random_camera(draw);
    expected.push_back(take(renderer, camera, random_view(draw, scene), shading));
  }
  std::vector<std::vector<Picture>> results(3);
  std::vector<std::thread> threads;
  for (auto& result : results) threads.emplace_back([&] { result = series(); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) CHECK(result == expected);
}

TEST_CASE("a scene with more objects than there are ids is refused") {
  scene::Scene scene;
  scene.objects.resize(32764);
  CHECK_NOTHROW(Renderer{scene});
  scene.objects.resize(32765);
  CHECK_THROWS_AS(Renderer{scene}, ConfigError);
}

TEST_CASE("impossible pictures are refused") {
  const scene::Scene scene;
  const Renderer renderer(scene);
  const Shading shading{0, 0};
  RenderScratch scratch;
  const auto refuses = [&](const CameraIntrinsics& camera, const CameraPose& view, const Images& images) {
    CHECK_THROWS_AS(renderer.render(camera, view, shading, images, scratch), ConfigError);
  };
  const CameraPose view{{}, 0.12};
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{
           {0, 10}, {10, 0}, {-1, 10}, {16385, 1}, {1, 16385}, {16384, 16384}, {1000000000, 1}}) {
    refuses({width, height, 10.0, 10.0, 5.0, 5.0}, view, {});
  }
  refuses({8, 8, 0.0, 10.0, 5.0, 5.0}, view, {});
  refuses({8, 8, 10.0, -1.0, 5.0, 5.0}, view, {});
  refuses({8, 8, 10.0, 10.0, NAN, 5.0}, view, {});
  refuses({8, 8, 1e7, 10.0, 5.0, 5.0}, view, {});
  refuses(make_intrinsics(8, 8, 1.0), {{1e300, 0.0, 0.0}, 0.1}, {});
  refuses(make_intrinsics(8, 8, 1.0), {{}, 0.0}, {});
  refuses(make_intrinsics(8, 8, 1.0), {{NAN, 0.0, 0.0}, 0.1}, {});
  for (const float gain : {-0.1F, 50.1F, NAN}) {
    const Shading glaring{0, 0, 0, {1.0F, gain, 1.0F}};
    CHECK_THROWS_AS(renderer.render(make_intrinsics(8, 8, 1.0), view, glaring, {}, scratch), ConfigError);
  }
  Picture small(make_intrinsics(7, 8, 1.0));
  refuses(make_intrinsics(8, 8, 1.0), view, small.images());
}

}  // namespace
}  // namespace threewe::sim
