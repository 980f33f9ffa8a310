// Places of the simulator as a robot has mapped them, and scans taken there.
#pragma once

#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "map/log_odds_map.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::slam::testing {

/// A scene and the map of it that true poses have left.
struct Place {
  scene::Slice slice;
  map::LogOddsMap map;
  std::vector<Pose2D> poses;  ///< from which it was mapped

  /// 360 beams around the base, their ranges off by 1 cm or so.
  std::vector<map::Beam> look(Draw& draw, const Pose2D& pose, double range_max = 12.0) const {
    std::vector<map::Beam> beams;
    for (int i = 0; i < 360; ++i) {
      const double angle = i * exact::kPi / 180.0;
      const double range = scene::cast_ray(slice, pose.position(), pose.theta + angle, range_max);
      const bool hit = range < range_max;
      const auto [s, c] = exact::sincos(angle);
      beams.push_back({{}, {c, s}, hit ? range + 0.01 * normal_quantile(draw(1e-12, 1.0)) : 4.0, hit});
    }
    return beams;
  }
  /// A free pose near one from which the place was mapped.
  Pose2D random_pose(Draw& draw) const {
    for (;;) {
      const Pose2D& near = poses[static_cast<std::size_t>(draw.whole(0, static_cast<int>(poses.size()) - 1))];
      const Vec2 by = draw.point(-0.5, 0.5);
      const double angle = exact::atan2(by.y, by.x);
      if (scene::cast_ray(slice, near.position(), angle, 9.0) < norm(by) + 0.15) continue;
      return {near.x + by.x, near.y + by.y, wrap_angle(draw(-4.0, 4.0))};
    }
  }
};

/// Maps a scene by a walk of `scans` poses from its start.
inline Place place_of(const scene::Scene& scene, Draw& draw, int scans, double resolution = 0.05) {
  Place place;
  place.map = map::LogOddsMap({.resolution = resolution});
  place.slice = scene.at_height(0.135);
  place.poses.push_back({});
  for (int i = 0; i < scans; ++i) {
    const Pose2D pose = i == 0 ? Pose2D{} : place.random_pose(draw);
    std::vector<map::Beam> beams = place.look(draw, pose);
    for (map::Beam& b : beams) {
      b.origin = pose.position();
      b.direction = rotate(b.direction, pose.theta);
    }
    place.map.insert(beams);
    // on along a beam that sees far
    const map::Beam& way = beams[static_cast<std::size_t>(draw.whole(0, 359))];
    const Vec2 next = pose.position() + draw(0.3, 0.7) * (way.range - 0.2) * way.direction;
    place.poses.push_back({next.x, next.y, 0.0});
  }
  place.poses.pop_back();
  return place;
}

}  // namespace threewe::slam::testing
