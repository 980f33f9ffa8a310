// Places file: the places of a map by name. YAML:
//
//   version: 1
//   places:
//     - {name: kitchen, polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]}   # [m] in `map`
//     - {name: dock, point: [1.5, 0.2]}
//
// What a robot has named by what stands there also has `origin: seen`.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "semantics/semantic_map.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::semantics {

inline constexpr int kPlacesVersion = 1;  ///< of the file

/// Reads a places file. Throws ConfigError with file:line for a name that is none or is there twice, a polygon of fewer
/// than three points, a number that is not finite, and a point that is not on `within`, where that is given.
std::vector<Place> load_places(const std::filesystem::path& file, const map::OccupancyGrid* within = nullptr);
/// The same of the text of such a file; `name` stands for the file in messages.
std::vector<Place> parse_places(const std::string& text, const std::string& name,
                                const map::OccupancyGrid* within = nullptr);

/// The text of a places file. What `parse_places` reads back is the same, to a millimetre.
std::string to_yaml(std::span<const Place> places);
/// Writes it to a file, whose name ends in .yaml. Throws ConfigError where it cannot be written.
void save_places(std::span<const Place> places, const std::filesystem::path& file);

}  // namespace threewe::semantics
