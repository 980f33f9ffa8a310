// Keyframe pose graph of where the robot has been and what it saw, in which loops are closed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/loop_closer.hpp"
#include "slam/packed_scan.hpp"
#include "slam/params.hpp"
#include "slam/pose_filter.hpp"
#include "slam/pose_graph.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// What the front-end makes of one scan.
struct FrontEndScan {
  Time stamp{};
  Pose2D local_from_base;                ///< in a frame that drifts slowly
  Matrix3 covariance = Matrix3::Zero();  ///< of it [m^2, rad^2]; what counts is by how much it grows
  std::vector<map::Beam> beams;          ///< in the base frame
  double range_bias = 0.0;               ///< [m]
  double range_noise = 0.0;              ///< [m] deviation of a range
  bool lost = false;                     ///< nothing relates it to the point before: another component begins
};

/// A metre of the way, which is taken for rigid; a node of the graph. It lies where its first scan was taken.
struct Keyframe {
  struct Scan {
    Pose2D keyframe_from_base;
    PackedScan beams;
    friend bool operator==(const Scan&, const Scan&) = default;
  };
  Time stamp{};
  double driven = 0.0;      ///< [m] until here; turning counts a little
  std::vector<Scan> scans;  ///< those that are kept
  friend bool operator==(const Keyframe&, const Keyframe&) = default;
};

/// Some metres of the way, of which a map is made when the robot comes by again.
struct Submap {
  int first = 0;  ///< keyframe
  int last = 0;
  /// Where the keyframes are in the frame of the first, as its map has them; empty until it is needed.
  std::vector<Pose2D> submap_from_keyframe;
  double range_bias = 0.0;  ///< [m] that its map was made with
  double tried_at = -1e9;   ///< [m] driven when the robot was last searched for in it
  friend bool operator==(const Submap&, const Submap&) = default;
};

/// Where the robot was at a scan.
struct TrajectoryStep {
  Time stamp{};
  int keyframe = 0;
  Pose2D keyframe_from_base;
  friend bool operator==(const TrajectoryStep&, const TrajectoryStep&) = default;
};

/// Whether a constraint relates two keyframes: one that merely says where a lost robot was last believed to be does
/// not.
bool joins(const Constraint& constraint);

/// All that is known of the way. What is needed besides follows from it.
struct KeyframeGraphData {
  std::vector<Keyframe> keyframes;
  std::vector<Submap> submaps;
  std::vector<TrajectoryStep> steps;
  PoseGraph graph;  ///< node i is keyframe i

  const Pose2D& pose_of(int keyframe) const { return graph.poses()[static_cast<std::size_t>(keyframe)]; }
  Pose2D pose_of(const TrajectoryStep& step) const { return pose_of(step.keyframe) * step.keyframe_from_base; }
  double driven_at(int keyframe) const { return keyframes[static_cast<std::size_t>(keyframe)].driven; }
  /// Of each keyframe the connected component of the graph that it belongs to, by the first keyframe in it; the
  /// component of keyframe 0 is the map's.
  std::vector<int> components() const;
  int newest() const { return static_cast<int>(keyframes.size()) - 1; }
  /// Puts the newest keyframe into the newest submap or, when that is `length` [m] long, into the next one; then
  /// returns true.
  bool extend_submaps(double length);
  /// Drops a submap along whose way enough others lead, if there is one: its scans, its keyframes and its closures. The
  /// steps stay where they are.
  bool prune(const Params::Graph& params);
};

/// The way, point by point. Its first keyframe is where the frame `map` begins, unless another is given. A copy
/// goes on with the same bits.
class KeyframeGraph {
 public:
  /// Without `keeps_steps` it forgets where the robot was at each scan, and is bounded in a bounded place.
  explicit KeyframeGraph(bool keeps_steps = true, SharedParams params = reference_params())
      : params_(std::move(params)), keeps_steps_(keeps_steps) {}
  /// Goes on with a way that was kept. The next point is taken at `map_from_base`, wherever `local` has it; half a
  /// metre and ten degrees off do no harm.
  KeyframeGraph(KeyframeGraphData data, const Pose2D& map_from_base, SharedParams params = reference_params());

  /// Takes a point and closes what loops it closes, unless all is to stay where it is. Returns map_from_base.
  Pose2D add(const FrontEndScan& point, bool closes_loops = true);
  /// The next point is taken at `map_from_base`: the first one, or one that nothing measured relates to the last, as
  /// above.
  void go_on_at(const Pose2D& map_from_base) { goes_on_at_ = map_from_base; }

  const KeyframeGraphData& data() const { return data_; }
  /// Counts how often closures have moved the way.
  int solutions() const { return solutions_; }
  /// Counts how often two components became one.
  int joined() const { return joined_; }
  /// Of each keyframe, see KeyframeGraphData.
  const std::vector<int>& components() const { return components_; }
  /// The newest point may lie at `map_from_base` in another component than its own: looks for it there. When it is
  /// found, and found again some metres on, the two become one.
  void join_at(int component, const Pose2D& map_from_base, double range_bias);

 private:
  struct Nearby {
    int submap = 0;
    int keyframe = 0;   // of it, the nearest
    double away = 0.0;  // [m]
  };

  void begin_keyframe(const FrontEndScan& point);
  void keep_scan(const FrontEndScan& point);
  void close_loop(double range_bias);
  void confirm_loop(double range_bias);
  std::vector<Nearby> nearby(int component, Vec2 place, double within, double again) const;
  std::optional<Constraint> search(const Nearby& near, const PoseBelief& belief, double range_bias);
  Matrix3 between(int keyframe);
  const LoopCloser& closer_of(Submap& submap, double range_bias);
  std::vector<map::Beam> view(int* scans) const;
  void take(const Constraint& closure);
  void align(const Constraint& closure);
  void solve();
  int component_of(int keyframe) const { return components_[static_cast<std::size_t>(keyframe)]; }
  void forget();
  double driven() const { return data_.driven_at(data_.newest()); }

  SharedParams params_;
  KeyframeGraphData data_;
  bool keeps_steps_ = true;
  int solutions_ = 0;
  int joined_ = 0;
  std::optional<Pose2D> goes_on_at_;  // map_from_base of the next point, which nothing measured relates to the last
  Pose2D local_from_keyframe_;        // of the newest
  Matrix3 covariance_at_keyframe_ = Matrix3::Zero();
  Pose2D scan_kept_at_;                    // local_from_base
  std::optional<Constraint> unconfirmed_;  // a closure that the next one may confirm
  double solved_at_ = 0.0;                 // [m] driven

  // what follows from the rest
  std::vector<int> components_;
  std::shared_ptr<const GraphCovariance> graph_covariance_;
  std::vector<Matrix3> uncovered_;  // covariances of the steps to the newest keyframes, which that one lacks
  struct Cached {
    int first = 0;  // keyframe of its submap
    std::shared_ptr<const LoopCloser> closer;
  };
  std::vector<Cached> closers_;  // the latest used last
};

}  // namespace threewe::slam
