#include "sim/actor_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "core/rng.hpp"
#include "scene/surfaces.hpp"
#include "sim/renderer/materials.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

using view::rgb;

constexpr std::array kShirts = {rgb(168, 62, 56),  rgb(62, 98, 146),  rgb(226, 222, 212), rgb(84, 122, 88),
                                rgb(214, 158, 70), rgb(112, 84, 128), rgb(70, 74, 82),    rgb(86, 144, 150)};
constexpr std::array kTrousers = {rgb(52, 60, 84), rgb(66, 64, 62),   rgb(108, 96, 78),
                                  rgb(38, 40, 46), rgb(94, 104, 118), rgb(120, 108, 92)};
constexpr std::array kSkins = {rgb(240, 204, 178), rgb(222, 178, 144), rgb(190, 138, 104),
                               rgb(146, 100, 74),  rgb(106, 72, 54),   rgb(232, 190, 160)};
constexpr std::array kHairs = {rgb(46, 36, 30), rgb(92, 64, 42),    rgb(160, 124, 78),
                               rgb(30, 28, 30), rgb(150, 148, 146), rgb(120, 62, 40)};
constexpr std::array kRobots = {rgb(232, 122, 44), rgb(52, 120, 178), rgb(92, 152, 84),
                                rgb(206, 74, 72),  rgb(226, 186, 60), rgb(132, 98, 168)};
constexpr Colour kShoes = rgb(44, 42, 42);
constexpr Colour kTyre = rgb(40, 40, 42);
constexpr Colour kDark = rgb(34, 36, 40);

std::int16_t nth_id(std::size_t n) { return static_cast<std::int16_t>(static_cast<std::size_t>(kFirstObjectId) + n); }

// Adds prisms that are given in the frame of a body.
class Builder {
 public:
  Builder(const Pose2D& scene_from_body, std::int16_t id, std::vector<VisibleSolid>& out)
      : scene_from_body_(scene_from_body), id_(id), out_(out) {}

  struct Heights {
    double low;
    double high;
  };
  void box(Vec2 at, double length, double width, Heights z, Material material, Colour colour) {
    const Vec2 middle = scene_from_body_ * at;
    add(scene::make_box({middle.x, middle.y, scene_from_body_.theta}, length, width), z, material, colour);
  }
  void disc(Vec2 at, double radius, Heights z, Material material, Colour colour) {
    add(scene::make_disc(scene_from_body_ * at, radius), z, material, colour);
  }

 private:
  void add(scene::Solid solid, Heights z, Material material, Colour colour) {
    solid.z_min = z.low;
    solid.z_max = z.high;
    out_.push_back({solid, material, id_, colour});
  }
  Pose2D scene_from_body_;
  std::int16_t id_;
  std::vector<VisibleSolid>& out_;
};

struct Clothes {
  Colour shirt;
  Colour trousers;
  Colour skin;
  Colour hair;
};

Clothes draw_clothes(std::uint64_t seed, std::uint32_t episode, std::size_t person) {
  const RngKey key{.seed = seed, .episode = episode, .sensor = 1, .stream = Stream::scene};
  const auto bits = random_bits(key, person);
  return {kShirts[bits[0] % kShirts.size()], kTrousers[bits[1] % kTrousers.size()], kSkins[bits[2] % kSkins.size()],
          kHairs[bits[3] % kHairs.size()]};
}

// Heights are those of a person 1.75 m tall, widths of one who keeps within 0.25 m. Legs and arms swing with the
// way that was walked.
void add_person(const PersonPlace& place, double swing, const Clothes& clothes, Builder body) {
  const double size = place.circle.radius / 0.25;
  for (const double side : {-1.0, 1.0}) {
    const double leg = side * swing;
    const double arm = -0.7 * leg;
    const auto at = [&](double x, double y) { return size * Vec2{x, side * y}; };
    body.box(at(leg + 0.02, 0.09), size * 0.2, size * 0.09, {0.0, 0.07}, Material::rubber, kShoes);
    body.disc(at(leg, kLegAside), size * kLegRadius, {0.07, kKneeHeight}, Material::fabric, clothes.trousers);
    body.disc(at(0.5 * leg, 0.085), size * 0.08, {kKneeHeight, 0.88}, Material::fabric, clothes.trousers);
    body.disc(at(arm, 0.195), size * 0.036, {0.74, 0.84}, Material::skin, clothes.skin);
    body.disc(at(0.7 * arm, 0.195), size * 0.046, {0.84, 1.12}, Material::fabric, clothes.shirt);
    body.disc(at(0.3 * arm, 0.19), size * 0.052, {1.12, 1.42}, Material::fabric, clothes.shirt);
  }
  body.box({}, size * 0.2, size * 0.3, {0.84, 1.08}, Material::fabric, clothes.shirt);
  body.box({}, size * 0.22, size * 0.36, {1.08, 1.44}, Material::fabric, clothes.shirt);
  body.disc({}, size * 0.055, {1.44, 1.5}, Material::skin, clothes.skin);
  body.disc({size * 0.01, 0.0}, size * 0.088, {1.5, 1.69}, Material::skin, clothes.skin);
  body.box({size * 0.1, 0.0}, size * 0.03, size * 0.025, {1.57, 1.61}, Material::skin, clothes.skin);
  body.disc({size * -0.022, 0.0}, size * 0.094, {1.58, 1.69}, Material::fabric, clothes.hair);
  body.disc({size * -0.006, 0.0}, size * 0.092, {1.69, kPersonHeight}, Material::fabric, clothes.hair);
}

void add_robot(const Body& spec, const std::optional<CameraSpec>& camera, Colour colour, Builder body) {
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  for (const Vec2 corner : spec.footprint.corners()) {
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
  }
  const Vec2 middle = 0.5 * (low + high);
  const double length = high.x - low.x;
  const double width = high.y - low.y;

  // wheels beside a narrow belly
  const WheelGeometry& wheels = spec.wheels;
  const double tyre = 2.0 * std::max(0.01, 0.5 * width - wheels.half_width);
  for (const double x : {-wheels.half_length, wheels.half_length}) {
    for (const double y : {-wheels.half_width, wheels.half_width}) {
      body.box({x, y}, 2.0 * wheels.radius, tyre, {0.0, 2.0 * wheels.radius}, Material::rubber, kTyre);
      if (wheels.half_length == 0.0 && y > 0.0) break;
    }
  }
  const double top = spec.height;
  const double belly = std::min(2.0 * wheels.radius, 0.6 * top);
  body.box(middle, 0.94 * length, 2.0 * wheels.half_width - tyre - 0.01, {0.4 * wheels.radius, belly},
           Material::plastic, kDark);

  // the shell fills the footprint; a dark band runs around it, where the sensors look out
  const double band = belly + 0.6 * (top - belly);
  body.box(middle, length, width, {belly, band}, Material::plastic, colour);
  body.box(middle, length, width, {band, top - 0.012}, Material::plastic, kDark);
  body.box(middle, length, width, {top - 0.012, top}, Material::plastic, colour);
  if (camera) {
    const Vec2 front{high.x - 0.004, camera->base_from_camera.y};
    const double z = std::min(camera->mount_height, top - 0.01);
    body.box(front, 0.01, 0.05, {z - 0.012, z + 0.01}, Material::glass, rgb(150, 176, 186));
  }
}

}  // namespace

std::int16_t person_id(const scene::Scene& scene, std::size_t person) { return nth_id(scene.objects.size() + person); }

std::int16_t robot_id(const scene::Scene& scene, std::size_t robot) {
  return nth_id(scene.objects.size() + scene.people.size() + robot);
}

std::vector<std::string> id_names(const Model& model) {
  std::vector<std::string> names(scene::kSurfaceNames.begin(), scene::kSurfaceNames.end());
  const scene::Scene& scene = *model.scene;
  for (const scene::Object& object : scene.objects) names.push_back(object.name);
  for (const scene::Person& person : scene.people) names.push_back(person.name);
  for (std::size_t i = 0; i < model.robots.size(); ++i) names.push_back(fmt::format("robot_{}", i));
  constexpr std::size_t kMost = std::numeric_limits<std::int16_t>::max();
  if (names.size() > kMost + 1) {
    throw ConfigError(
        fmt::format("there are {} objects, people and robots; at most {} can be distinguished in a picture",
                    names.size() - kFirstObjectId, kMost + 1 - kFirstObjectId));
  }
  return names;
}

void find_actors(const Model& model, std::span<const Pose2D> robots, std::size_t looking,
                 std::span<const PersonState> people, std::uint64_t seed, std::uint32_t episode,
                 std::vector<VisibleSolid>& figures) {
  figures.clear();
  const scene::Scene& scene = *model.scene;
  for (std::size_t i = 0; i < people.size(); ++i) {
    const PersonPlace place = place_on(scene.people[i], people[i]);
    const Vec2 at = place.circle.center;
    const Pose2D pose{at.x, at.y, exact::atan2(place.direction.y, place.direction.x)};
    add_person(place, swing_of(people[i]), draw_clothes(seed, episode, i), {pose, person_id(scene, i), figures});
  }
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (i == looking) continue;
    const RobotProfile& profile = model.robots[i].profile;
    add_robot(profile.body, profile.camera, kRobots[i % kRobots.size()], {robots[i], robot_id(scene, i), figures});
  }
}

}  // namespace threewe::sim
