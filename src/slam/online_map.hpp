// Online map: the log-odds map that a robot builds, and rebuilds after a loop closure.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/keyframe_graph.hpp"
#include "slam/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// Scans go into the map as they come, and into a trail. When a closed loop bends that, all its scans are drawn again,
/// a few at a time, and the new map takes the place of the old one at once. Plain data: a copy goes on with the same
/// bits.
class OnlineMap {
 public:
  /// The robot's own map, which begins where the robot does.
  explicit OnlineMap(const SharedParams& params = reference_params());
  /// A map that was given: what is seen is drawn into it, and no loops are closed.
  OnlineMap(map::LogOddsMap given, const SharedParams& params)
      : params_(params->online_map), settings_(settings_of(*params)), map_(std::move(given)) {}

  const map::LogOddsMap& map() const { return map_; }

  /// One scan; `local_from_base` of it is where the robot is in the map.
  void insert(const FrontEndScan& scan);
  /// The robot was somewhere else than it thought, and may have been carried there.
  void break_off() { broken_off_ = true; }
  /// In place of what was drawn into a given map, that map again.
  void begin_again(const map::LogOddsMap& given) { map_.replace(given); }
  /// Goes on with drawing the map anew, if need be: to be called once a scan. When that is done, `new_from_old`: what
  /// was there in the old map is here in the new one, around the robot.
  std::optional<Pose2D> redraw();

 private:
  /// A keyframe as the map has it.
  struct Drawn {
    Time stamp{};
    Pose2D map_from_base;
  };
  /// A map in the making.
  struct Drawing {
    explicit Drawing(const map::LogOddsMap::Settings& settings) : map(settings) {}
    map::LogOddsMap map;
    Time until = Time::min();  // the last keyframe that is drawn
  };

  static map::LogOddsMap::Settings settings_of(const Params& params);
  void forget_dropped();
  bool lies_elsewhere() const;
  void draw_some();
  Pose2D put_in_place();

  Params::OnlineMap params_;
  map::LogOddsMap::Settings settings_;
  map::LogOddsMap map_;
  std::optional<KeyframeGraph> keyframe_graph_;  // none in a given map
  Pose2D map_from_local_;                        // `local` is the trail's; what moves the map moves this
  double range_bias_ = 0.0;                      // [m]
  double range_noise_ = 0.0;                     // [m]
  bool broken_off_ = true;                       // so is the first scan from what was before
  int solutions_ = 0;                            // of the trail, that were looked at
  std::vector<Drawn> drawn_;                     // by time
  std::optional<Drawing> drawing_;
};

}  // namespace threewe::slam
