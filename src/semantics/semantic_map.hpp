// Semantic map: the things that a robot has seen, with kind, color and position of each, and the places that have
// names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/camera.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/semantics/things.hpp"
#include "vision/detector.hpp"

namespace threewe::semantics {

/// Which things are meant. What is empty fits all.
struct ThingQuery {
  std::string kind;                ///< a label of the detector
  std::string color;               ///< a color term
  std::string place;               ///< a known place that it must be in
  double least_probability = 0.5;  ///< of the kind
  double least_color = 0.3;        ///< share of the color
};

/// What one camera saw, and from where.
struct View {
  Time now{};                                 ///< when the picture was taken
  Pose2D map_from_camera;                     ///< where the camera was
  std::span<const vision::Detection> things;  ///< what it shows
  const CameraIntrinsics& camera;             ///< of the picture
  std::span<const float> depth{};             ///< (H, W) [m] along its axis, invalid = 0; empty without a depth camera
  double depth_sigma = 0.0;                   ///< [m] at 1 m, growing with the square of the depth
};

/// Things and places of one robot. Plain data; bounded.
class SemanticMap {
 public:
  /// Of a detector with these labels, and the radius [m] that things of each usually have; 0 where it is not known.
  explicit SemanticMap(std::vector<std::string> labels, std::vector<double> radii = {});

  /// Takes over what a picture shows. How far away a thing is follows from how it looks and, where that agrees, from
  /// where its surface is by the depth image or else by `grid`, which the lidar has drawn. What should be in view and
  /// is not is forgotten after some looks; `grid` says what stands in between.
  void update(const View& view, const map::OccupancyGrid& grid);
  /// A correction of `map`, as by a closed loop: a robot that was at `from` in it is at `to` now. Things move along by
  /// how lately they were seen: the error has grown evenly since the correction before.
  void move(const Pose2D& from, const Pose2D& to, Time now);

  /// All that was seen from two poses or more, in the order in which it was first seen.
  std::vector<MappedThing> things() const;
  /// The one with an id, if it is among them.
  std::optional<MappedThing> thing(std::uint64_t id) const;
  /// Those that a query means, the most probable first. Throws ContractError for an unknown kind, color or place,
  /// naming the nearest known ones.
  std::vector<MappedThing> find(const ThingQuery& query) const;
  /// What the numbers of kinds mean.
  const std::vector<std::string>& labels() const { return labels_; }

  /// Gives a place a name, in place of one that had it. Throws ContractError for a name that is none
  /// (`is_name`) or `start`, and a polygon of two points or one that is not finite.
  void name_place(Place place);
  /// All places, in the order in which they were named.
  const std::vector<Place>& places() const { return places_; }
  /// The place of that name. Throws ContractError naming the nearest known ones.
  const Place& place(std::string_view name) const;
  /// Where a robot drives to that goes to a place [m].
  static Vec2 center(const Place& place);
  /// Whether a point is in a place, or within 2.5 m of one that is a point.
  static bool contains(const Place& place, Vec2 point);

 private:
  // Where a detection is, and its covariance.
  struct Located {
    Vec2 position;  // [m]
    std::array<double, 3> covariance{};
    double range = 0.0;  // [m] from the camera
  };
  Located locate(const vision::Detection& detection, const View& view, const map::OccupancyGrid& grid) const;
  std::size_t match(Vec2 position, const std::array<double, 3>& covariance, const vision::Detection& detection) const;
  void add_new(Vec2 position, const std::array<double, 3>& covariance, double range);
  void add_view(std::size_t index, Vec2 position, const std::array<double, 3>& covariance, const View& view,
                const vision::Detection& detection);
  void count_misses(const View& view, const map::OccupancyGrid& grid);
  void merge_doubles();

  // From where a thing was looked at: as seen from it.
  struct Viewpoint {
    double bearing = 0.0;    // [rad]
    double log_range = 0.0;  // of [m]
  };
  // What all views of a thing say of its kind: each counts by how new its viewpoint is.
  struct Evidence {
    Pose2D last;                     // the camera's pose of the newest view that counted
    std::vector<double> log_scores;  // (labels,) sums of the logarithms of their scores
    double weight = 0.0;
    std::vector<Viewpoint> from;

    void add(Viewpoint viewpoint, const std::vector<float>& scores);
    void add(const Evidence& other);
    // The probability of each label, 0 of the background.
    void weigh(std::vector<double>& kinds) const;
  };

  std::vector<std::string> labels_;
  std::vector<double> radii_;
  std::vector<MappedThing> things_;
  std::vector<Evidence> evidence_;  // of things_
  std::vector<Place> places_;
  std::uint64_t next_id_ = 1;
  std::optional<Time> moved_;  // when `map` was corrected last
};

}  // namespace threewe::semantics
