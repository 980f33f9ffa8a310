#include "semantics/places.hpp"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "core/config.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::semantics {
namespace {

constexpr const char* kGiven = "given";

Vec2 point_of(const ConfigNode& node, const map::OccupancyGrid* within) {
  const Vec2 point = node.vec2();
  if (within != nullptr && !within->contains(within->cell(point))) {
    const Vec2 end = within->origin +
                     within->resolution * Vec2{static_cast<double>(within->width), static_cast<double>(within->height)};
    node.fail(fmt::format("({:g}, {:g}) is outside of the map, which goes from ({:g}, {:g}) to ({:g}, {:g})", point.x,
                          point.y, within->origin.x, within->origin.y, end.x, end.y));
  }
  return point;
}

Place place_of(ConfigNode& node, const map::OccupancyGrid* within) {
  Place place{.name = node.name("name"), .polygon = {}};
  if (place.name == "start") node.at("name").fail("'start' is where the robot began: a place needs another name");
  if (node.has("origin")) place.origin = node.choice("origin", {kGiven, std::string(kSeen)});
  if (node.has("point") == node.has("polygon")) node.fail("expected either a point or a polygon");
  if (node.has("point")) {
    place.polygon.push_back(point_of(node.at("point"), within));
  } else {
    const ConfigNode polygon = node.at("polygon");
    for (const ConfigNode& corner : polygon.items()) place.polygon.push_back(point_of(corner, within));
    if (place.polygon.size() < 3)
      polygon.fail(fmt::format("expected three points or more, got {}", place.polygon.size()));
  }
  node.finish();
  return place;
}

// In YAML's single quotes, where nothing but these has a meaning.
std::string quoted(const std::string& name) {
  std::string text = "'";
  for (const char c : name) text += c == '\'' ? "''" : std::string(1, c);
  return text + "'";
}

}  // namespace

std::vector<Place> parse_places(const std::string& text, const std::string& name, const map::OccupancyGrid* within) {
  ConfigNode root = ConfigNode::parse(text, name);
  (void)root.integer_in("version", kPlacesVersion, kPlacesVersion);
  std::vector<Place> places;
  for (ConfigNode& node : root.at("places").items()) {
    Place place = place_of(node, within);
    if (std::ranges::find(places, place.name, &Place::name) != places.end())
      node.at("name").fail(fmt::format("place '{}' is there already", place.name));
    places.push_back(std::move(place));
  }
  root.finish();
  return places;
}

std::vector<Place> load_places(const std::filesystem::path& file, const map::OccupancyGrid* within) {
  return parse_places(ConfigNode::read(file), file.string(), within);
}

std::string to_yaml(std::span<const Place> places) {
  const auto shown = [](Vec2 point) { return fmt::format("[{:.3f}, {:.3f}]", point.x, point.y); };
  std::string text = fmt::format("version: {}\nplaces:{}\n", kPlacesVersion, places.empty() ? " []" : "");
  for (const Place& place : places) {
    std::string corners;
    for (const Vec2 corner : place.polygon) corners += (corners.empty() ? "" : ", ") + shown(corner);
    const bool is_point = place.polygon.size() == 1;
    text += fmt::format("  - {{name: {}, {}: {}{}}}\n", quoted(place.name), is_point ? "point" : "polygon",
                        is_point ? corners : "[" + corners + "]",
                        place.origin == kGiven ? "" : fmt::format(", origin: {}", place.origin));
  }
  return text;
}

void save_places(std::span<const Place> places, const std::filesystem::path& file) {
  if (file.extension() != ".yaml" || file.stem().empty())
    throw ConfigError(fmt::format("{}: the name of a places file ends in .yaml", file.string()));
  std::ofstream stream(file, std::ios::binary);
  if (!(stream << to_yaml(places)).flush()) throw ConfigError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace threewe::semantics
