// Scenes that are published do not change: results measured in them must stay comparable. A scene that should be
// different gets a new version in its name; so do shapes of objects that a scene uses.
#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "threewe/scene/scene.hpp"

using namespace threewe;
using namespace threewe::scene;

namespace {

// The scene as it was drawn, and the shapes of its objects.
std::string everything_in(const Scene& scene) {
  std::string text = to_yaml(scene);
  for (const Object& object : scene.objects) {
    for (const Prism& p : object.prisms) {
      text += fmt::format("{} {} {} {} {} {} {} {} {} {} {}\n", object.name, static_cast<int>(p.shape), p.pose.x,
                          p.pose.y, p.pose.theta, p.length, p.width, p.radius, p.z_min, p.z_max, p.material);
    }
  }
  return text;
}

// FNV-1a.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  return hash;
}

const std::map<std::string, std::uint64_t> kFrozen = {
    {"apartment_v1", 0x6D71293623C1B4EDULL}, {"cluttered_v1", 0x93F7FD705066F93EULL},
    {"corridor_v1", 0x38AED98494074CA5ULL},  {"dynamic_v1", 0x37FAA698BF22D31FULL},
    {"office_v2", 0x42E4523FF1E8DD5AULL},    {"outdoor_v1", 0x0BF67347F3292C45ULL},
    {"warehouse_v1", 0x1B7F4676422D5397ULL},
};

}  // namespace

TEST_CASE("the seven scenes are as they were when they were published") {
  for (const auto& [name, hash] : kFrozen) {
    CAPTURE(name);
    const std::string found = fmt::format("{:016x}", hash_of(everything_in(Scene::load(name))));
    CHECK(found == fmt::format("{:016x}", hash));
  }
}
