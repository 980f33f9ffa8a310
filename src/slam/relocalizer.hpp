// Relocalizer: finds a robot whose track was lost in the parts of its map that it is no longer related to.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/global_localizer.hpp"
#include "slam/keyframe_graph.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// The scans of one component of a trail's graph, drawn where the graph has them; `components` as KeyframeGraphData has
/// them.
map::LogOddsMap drawn_component(const KeyframeGraphData& keyframe_graph, const std::vector<int>& components,
                                int component, double resolution, double range_bias, const Params& params);

/// Searches the maps of all components but the one that the robot is in, with what it sees there. While there is one
/// component alone it does nothing.
class Relocalizer {
 public:
  explicit Relocalizer(SharedParams params = reference_params()) : params_(std::move(params)) {}

  /// Where the robot seems to be: in which component, and where that lies in the map.
  struct Found {
    int component = 0;
    Pose2D map_from_base;
  };

  /// One scan, its beams in the base frame, in order of time; it is the newest of the trail. A search of large maps
  /// takes some scans.
  std::optional<Found> look(const KeyframeGraph& keyframe_graph, Time stamp, const Pose2D& local_from_base,
                            std::span<const map::Beam> beams, double range_bias);

 private:
  struct Search {
    Time component{};
    GlobalLocalizer finder;
  };
  void begin(const KeyframeGraph& keyframe_graph, double range_bias);

  // components are named by the stamps of their first keyframes here, as indices change when a trail is pruned
  Time component_{};       // that the robot is in
  std::size_t count_ = 1;  // components
  bool begun_ = false;     // the searches are of these
  std::vector<Search> searches_;
  SharedParams params_;
};

}  // namespace threewe::slam
