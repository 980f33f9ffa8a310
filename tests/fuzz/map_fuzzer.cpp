// ROS maps: the YAML file, a line "---8<---", and the picture.
#include "fuzz.hpp"
#include "map/costmap.hpp"
#include "map/log_odds_map.hpp"
#include "threewe/map/ros_map.hpp"

THREEWE_FUZZER(map)(std::string_view text) {
  using namespace threewe;
  constexpr std::string_view kCut = "---8<---\n";
  static const auto yaml = fuzz::folder() / "map.yaml";
  const std::size_t cut = text.find(kCut);
  fuzz::write(yaml, text.substr(0, cut));
  fuzz::write(fuzz::folder() / "map.pgm", cut == std::string_view::npos ? "" : text.substr(cut + kCut.size()));
  fuzz::read(text, [&] {
    const map::OccupancyGrid grid = map::load_ros_map(yaml);
    if (grid.data.size() > 10'000) return;
    map::Costmap().update(grid, {}, {});
    auto seen = map::LogOddsMap::going_on_from(grid);
    seen.insert(std::vector{map::Beam{grid.origin, {0.6, 0.8}, 3.0, true, false}});
  });
}
