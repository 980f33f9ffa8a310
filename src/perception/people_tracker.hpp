// People tracker: Kalman-filter tracks of what moves in the scans of a lidar.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/perception/percepts.hpp"

namespace threewe::perception {

/// Follows people by the scans of one planar lidar near the floor, in which they are two legs. Plain data.
///
/// A hit where earlier scans looked through has moved there; so neither a map is needed nor does it matter what the
/// robot has not seen before. Such hits, grouped to legs and pairs of legs, begin tracks; tracks are Kalman filters of
/// constant velocity, to which groups are assigned within gates, the nearest first (Bar-Shalom, Li & Kirubarajan 2001,
/// chapters 6 and 7). Who has walked some way is a person; who has stood for some seconds is an obstacle like others.
class PeopleTracker {
 public:
  explicit PeopleTracker(const Params::People& params = {}) : params_(params) {}
  /// One scan, whose turn began and ended with the lidar at these poses in `odom`, at these times; beams were measured
  /// evenly in between, the last one first where `scan.time_increment` is negative.
  void update(const LaserScan& scan, Time began, Time ended, const Pose2D& odom_from_lidar_then,
              const Pose2D& odom_from_lidar);
  /// Where people are at a time at or after the newest scan, by the order of their ids.
  std::vector<TrackedPerson> people(Time now) const;

 private:
  static constexpr std::size_t kBins = 360;
  static constexpr std::size_t kRemembered = 11;  // scans

  /// How far a scan looked from a point: in each direction and those beside it the least range, 0 where it did not
  /// look.
  struct View {
    Time stamp{};
    Vec2 from;
    std::array<float, kBins> open{};
  };
  /// A beam that hit something.
  struct Hit {
    Vec2 at;
    std::size_t beam = 0;
    double range = 0.0;  // [m]
    bool moved = false;  // nothing was there before
  };
  /// What may be a leg, a pair of legs, or anything else that is small and stands free.
  struct Group {
    Vec2 center;
    Vec2 low, high;     // of what was hit
    double late = 0.0;  // [s] seen after the middle of the turn
    int hits = 0;
    int moved = 0;
    int blobs = 1;
  };
  /// A constant-velocity filter: both axes have the same covariance, since measurements are as good in any direction.
  struct Track {
    std::uint32_t id = 0;  // 0 until it is a person
    Vec2 position, velocity;
    double pp = 0.0, pv = 0.0, vv = 0.0;  // covariance of position and velocity along one axis
    Vec2 began_at;
    Time seen{};        // when something was last assigned ...
    Time moved{};       // ... that had moved
    int sightings = 0;  // in all
    int misses = 0;     // in a row
  };

  void find_ends(const LaserScan& scan, const Pose2D& then, const Pose2D& now);
  void find_hits(const LaserScan& scan);
  void choose_views();
  bool was_free(Vec2 point, double margin);
  void remember(const LaserScan& scan, Time stamp, Vec2 from);
  void group_hits(const LaserScan& scan, Vec2 lidar);
  Group group_of(std::size_t first, std::size_t last, const LaserScan& scan, Vec2 lidar) const;
  static Vec2 offset(const Track& track, const Group& group);
  Track later(Track track, double t) const;
  void merge_legs();
  void predict(Time stamp);
  void assign(Time stamp);
  void begin_tracks(Time stamp);
  void end_tracks(Time stamp);

  Params::People params_;
  std::vector<View> views_;  // a ring
  std::size_t next_view_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> old_views_;  // those long ago enough, and where each looked at last
  std::vector<Vec2> ends_;     // of the newest scan's beams; (0, 0) of those that are not valid
  std::vector<Hit> hits_;      // of the newest scan, by beam
  std::vector<Group> groups_;  // likewise
  std::vector<char> taken_;    // of the groups, those that belong to a track
  std::vector<Track> tracks_;  // in the order in which they began
  Time stamp_{};
  std::uint32_t known_ = 0;  // people so far
};

}  // namespace threewe::perception
