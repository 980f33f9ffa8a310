#include "object_library.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/names.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

const std::vector<std::string> kMaterials = {"wood",    "metal", "plastic", "fabric", "leaf",
                                             "ceramic", "glass", "stone",   "paper"};

constexpr double kSmallest = 0.005;  // [m], of any prism in any direction
constexpr double kLargest = 10.0;    // [m]
constexpr std::size_t kMostPrisms = 50;

// {box: [length, width] or cylinder: radius, at: [x, y, theta], z: [from, to], material: name}
Prism read_prism(ConfigNode node) {
  Prism prism;
  if (node.has("box") == node.has("cylinder")) node.fail("expected either 'box' or 'cylinder'");
  if (node.has("box")) {
    const auto sides = node.at("box").items();
    if (sides.size() != 2) node.at("box").fail("expected [length, width]");
    prism.shape = Prism::Shape::box;
    prism.length = sides[0].number_in(kSmallest, kLargest);
    prism.width = sides[1].number_in(kSmallest, kLargest);
  } else {
    prism.shape = Prism::Shape::cylinder;
    prism.radius = node.number_in("cylinder", 0.5 * kSmallest, kLargest);
  }
  prism.pose = node.has("at") ? node.at("at").pose(kLargest) : Pose2D{};

  ConfigNode z = node.at("z");
  const auto [low, high] = z.vec2();
  if (low < 0.0 || high > kLargest || high - low < kSmallest) {
    z.fail(fmt::format("expected 0 <= from < to <= {}", kLargest));
  }
  prism.z_min = low;
  prism.z_max = high;
  prism.material = node.choice("material", kMaterials);
  node.finish();
  return prism;
}

std::map<std::string, std::vector<Prism>> read_category(const std::string& name) {
  ConfigNode root = ConfigNode::load(find_asset("objects", name));
  if (root.text("category") != name) root.at("category").fail(fmt::format("expected '{}', the name of the file", name));
  std::map<std::string, std::vector<Prism>> shapes;
  for (const auto& [shape, parts] : root.at("shapes").fields()) {
    auto& prisms = shapes[shape];
    for (const ConfigNode& part : parts.items(kMostPrisms)) prisms.push_back(read_prism(part));
    if (prisms.empty()) parts.fail("a shape needs at least one prism");
  }
  root.finish();
  return shapes;
}

std::vector<std::string> names_of(const std::map<std::string, std::vector<Prism>>& shapes) {
  std::vector<std::string> names;
  names.reserve(shapes.size());
  for (const auto& entry : shapes) names.push_back(entry.first);
  return names;
}

}  // namespace

const std::vector<Prism>& ObjectLibrary::prisms(const ConfigNode& category, const ConfigNode& shape) {
  if (!categories_.contains(category.text())) {
    const auto known = asset_names("objects");
    if (std::ranges::find(known, category.text()) == known.end()) {
      category.fail(unknown_name("category", category.text(), known));
    }
  }
  const Shapes& all = shapes(category.text());
  const auto found = all.find(shape.text());
  if (found == all.end()) shape.fail(unknown_name("shape", shape.text(), names_of(all)));
  return found->second;
}

const std::vector<Prism>& ObjectLibrary::prisms(const std::string& category, const std::string& shape) {
  const Shapes& all = shapes(category);
  const auto found = all.find(shape);
  if (found == all.end()) throw ConfigError(unknown_name("shape", shape, names_of(all)));
  return found->second;
}

const ObjectLibrary::Shapes& ObjectLibrary::shapes(const std::string& category) {
  auto found = categories_.find(category);
  if (found == categories_.end()) found = categories_.emplace(category, read_category(category)).first;
  return found->second;
}

}  // namespace threewe::scene
