// How much of a velocity a robot may drive, against a look at every point from every pose.
#include "nav/path_follower.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "hardware/parameters.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

// By the book: contact is where some point is too near to the outline in one of the poses along the motion.
class SlowTwin {
 public:
  SlowTwin(const RobotProfile& profile, std::vector<Vec2> points, double spare)
      : profile_(profile),
        params_(params_for<Params>(profile, "nav")),
        outline_(profile.body.footprint),
        points_(std::move(points)),
        spare_(spare) {}

  double allowed_fraction(const Velocity& v) const {
    const double seconds = until_contact(v);
    if (seconds < 0.0) return 1.0;
    const Limits& limits = profile_.operating_limits;
    const double speed = exact::hypot(v.vx, v.vy);
    const Params::Follower& p = params_.follower;
    const double braking = std::max(0.5 * speed / (p.braking * limits.linear_braking),
                                    0.5 * std::fabs(v.omega) / (p.braking * limits.angular_acceleration));
    const double root = exact::sqrt(p.reaction * p.reaction + 4.0 * braking * seconds);
    const double f = braking > 1e-9 ? (root - p.reaction) / (2.0 * braking) : 1.0;
    return f < p.least_speed ? 0.0 : std::min(f, 1.0);
  }

 private:
  // [s]; negative where nothing is met
  double until_contact(const Velocity& v) const {
    const double rate = std::max(exact::hypot(v.vx, v.vy) / params_.follower.step, std::fabs(v.omega) / 0.1);
    if (rate <= 0.0) return -1.0;
    const double dt = 1.0 / rate;
    const Pose2D step = integrate({}, v, dt);
    Pose2D pose;
    for (int n = 0; n < static_cast<int>(params_.follower.horizon / dt); ++n) {
      pose = pose * step;
      const auto [s, c] = exact::sincos(pose.theta);
      for (const Vec2 p : points_) {
        const Vec2 d = p - pose.position();
        if (outline_.clearance({c * d.x + s * d.y, c * d.y - s * d.x}) < least(p)) return n * dt;
      }
    }
    return -1.0;
  }
  double least(Vec2 p) const {
    const double now = outline_.clearance(p);
    return std::min(safety::margin_of(profile_) + spare_,
                    now > 0.0 ? std::max(now - params_.creep.encroachment, 0.0) : now);
  }

  const RobotProfile& profile_;
  Params params_;
  Outline outline_;
  std::vector<Vec2> points_;
  double spare_;
};

TEST_CASE("a velocity is slowed down as far as a look at every point from every pose says, to the bit") {
  int slowed = 0;
  int free = 0;
  for (const std::string hardware : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(hardware);
    PathFollower follower(profile, params_for<Params>(profile, "nav"));
    for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
      CAPTURE(seed);
      Draw draw(seed);
      std::vector<Vec2> points;
      const double nearest = draw(0.0, 0.5);
      for (int i = draw.whole(0, 60); i > 0; --i) {
        points.push_back(rotate({draw(nearest, 1.5), 0.0}, draw(-exact::kPi, exact::kPi)));
      }
      const double spare = draw.whole(0, 1) * 0.01;
      const Limits& limits = profile.operating_limits;
      const double still = draw.whole(0, 4) == 0 ? 0.0 : 1.0;
      const double turning = draw.whole(0, 4) == 0 ? 0.0 : 1.0;
      const Vec2 along = rotate({still * draw(0.0, limits.linear), 0.0}, draw(-exact::kPi, exact::kPi));
      const Velocity wanted{along.x, along.y, turning * draw(-limits.angular, limits.angular)};

      follower.update(points, spare);
      const double f = SlowTwin(profile, points, spare).allowed_fraction(wanted);
      REQUIRE(follower.safe(wanted) == Velocity{f * wanted.vx, f * wanted.vy, f * wanted.omega});
      ++(f < 1.0 ? slowed : free);
    }
  }
  CHECK(slowed > static_cast<int>(cases(1000)));
  CHECK(free > static_cast<int>(cases(1000)));
}

}  // namespace
}  // namespace threewe::nav
