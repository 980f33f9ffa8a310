#include "object_library.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "threewe/core/assets.hpp"
#include "threewe/core/names.hpp"

namespace threewe::scene {
namespace {

const std::vector<std::string> kMaterials = {"wood",    "metal", "plastic", "fabric", "leaf",
                                             "ceramic", "glass", "stone",   "paper"};

constexpr double kSmallest = 0.005;  // [m], of any prism in any direction
constexpr double kLargest = 10.0;    // [m]

double size(const ConfigNode& node, double smallest) {
  const double value = node.number();
  if (value < smallest || value > kLargest)
    node.fail(fmt::format("{} m is outside [{}, {}]", value, smallest, kLargest));
  return value;
}

// {box: [length, width] or cylinder: radius, at: [x, y, theta], z: [from, to], material: name}
Prism read_prism(ConfigNode node) {
  Prism prism;
  if (node.has("box") == node.has("cylinder")) node.fail("expected either 'box' or 'cylinder'");
  if (node.has("box")) {
    const auto sides = node.at("box").items();
    if (sides.size() != 2) node.at("box").fail("expected [length, width]");
    prism.shape = Prism::Shape::box;
    prism.length = size(sides[0], kSmallest);
    prism.width = size(sides[1], kSmallest);
  } else {
    prism.shape = Prism::Shape::cylinder;
    prism.radius = size(node.at("cylinder"), 0.5 * kSmallest);
  }
  prism.pose = node.has("at") ? node.at("at").pose() : Pose2D{};

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
  ConfigNode list = root.at("shapes");
  for (const auto& [shape, parts] : list.fields()) {
    auto& prisms = shapes[shape];
    for (const ConfigNode& part : parts.items()) prisms.push_back(read_prism(part));
    if (prisms.empty()) parts.fail("a shape needs at least one prism");
  }
  root.finish();
  return shapes;
}

void refuse_unknown(const ConfigNode& node, std::string_view kind, const std::vector<std::string>& known) {
  const std::string name = node.text();
  if (std::ranges::find(known, name) == known.end()) node.fail(unknown_name(kind, name, known));
}

}  // namespace

const std::vector<Prism>& ObjectLibrary::prisms(const ConfigNode& category, const ConfigNode& shape) {
  auto found = categories_.find(category.text());
  if (found == categories_.end()) {
    refuse_unknown(category, "category", asset_names("objects"));
    found = categories_.emplace(category.text(), read_category(category.text())).first;
  }
  const Shapes& shapes = found->second;
  const auto prisms = shapes.find(shape.text());
  if (prisms == shapes.end()) {
    std::vector<std::string> known;
    for (const auto& entry : shapes) known.push_back(entry.first);
    refuse_unknown(shape, "shape", known);
  }
  return prisms->second;
}

}  // namespace threewe::scene
