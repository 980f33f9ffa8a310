// Object library: the shapes of furniture, read from assets/objects.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// Shapes by category and name. Each category's file is read once, when it is first asked for.
class ObjectLibrary {
 public:
  /// The prisms of a shape, in the object's frame: origin on the floor, facing along x. `category` and `shape` are the
  /// nodes that name them, so that an unknown name is reported where it was written.
  const std::vector<Prism>& prisms(const ConfigNode& category, const ConfigNode& shape);
  /// The same by name. Throws ConfigError naming the nearest right one.
  const std::vector<Prism>& prisms(const std::string& category, const std::string& shape);

 private:
  using Shapes = std::map<std::string, std::vector<Prism>>;
  const Shapes& shapes(const std::string& category);
  std::map<std::string, Shapes> categories_;
};

}  // namespace threewe::scene
