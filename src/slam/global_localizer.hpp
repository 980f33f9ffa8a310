// Global localizer: pose in a prior map without an initial guess, from several scans together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/params.hpp"
#include "slam/prior_map.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// Collects what a robot sees, where odometry has it, and looks for all of that together, so that a robot which drives
/// about tells places apart that look alike from one point. A place counts as found when it fits, no other fits nearly
/// as well, and the next scans fit there too. A search may take longer than there is time between two scans: it goes on
/// bit by bit, for the place where the robot was when it began. Plain data: a copy goes on the same.
class GlobalLocalizer {
 public:
  explicit GlobalLocalizer(std::shared_ptr<const PriorMap> map, SharedParams params = reference_params())
      : params_(std::move(params)), map_(std::move(map)) {}

  /// One scan, its beams in the base frame, taken where odometry has the robot; in order of time. Returns map_from_base
  /// when it is found.
  std::optional<Pose2D> look(Time stamp, const Pose2D& odom_from_base, std::span<const map::Beam> beams);
  /// Searches on, for about so much work as BranchAndBoundMatcher::Search counts it.
  void go_on(std::int64_t work);
  bool searching() const { return hunt_.has_value(); }
  /// Whether a search has found a pose that the next scans have not yet confirmed.
  bool has_candidate() const { return confirmed_ > 0; }
  /// Whether the last search of the whole map that came to its end found nothing better than about this pose.
  bool found_best(const Pose2D& map_from_base, const Pose2D& odom_from_base) const;

 private:
  struct Glimpse {
    Pose2D odom_from_base;
    std::vector<map::Beam> beams;  // in the base frame
    double driven = 0.0;           // [m] until then
  };
  // A search of the whole map.
  struct Hunt {
    Pose2D odom_from_base;         // where it began ...
    std::vector<map::Beam> beams;  // ... and what was seen there
    std::vector<map::Beam> seen;   // there and before
    double least;                  // score that is asked for
    BranchAndBoundMatcher::Search search;
  };

  bool is_same_view(const Pose2D& a_from_b) const;
  bool remember(const Pose2D& odom_from_base, std::span<const map::Beam> beams);
  std::vector<map::Beam> all_seen(const Pose2D& odom_from_base, std::span<const map::Beam> beams) const;
  void begin_hunt(const Pose2D& odom_from_base, std::span<const map::Beam> beams);
  void hunt_again(double least);
  void end_hunt(const std::optional<BranchAndBoundMatcher::Found>& found);
  void give_up();
  std::optional<Pose2D> search_near(const Pose2D& place, std::span<const map::Beam> beams) const;
  bool fits(const Pose2D& place, std::span<const map::Beam> beams) const;

  SharedParams params_;
  std::shared_ptr<const PriorMap> map_;
  std::vector<Glimpse> glimpses_;  // oldest first
  std::optional<Hunt> hunt_;       // in progress
  Time stamp_{};                   // of the last scan ...
  Pose2D last_;                    // ... and odom_from_base
  double driven_ = 0.0;            // [m]
  Time due_{};                     // of the next search
  Duration pause_{};               // until the one after, where nothing new is seen
  Pose2D map_from_odom_;           // the place that may be it
  int confirmed_ = 0;              // scans in a row that fit there
  std::optional<Pose2D> best_;     // map_from_odom, of the last search that ended
};

}  // namespace threewe::slam
