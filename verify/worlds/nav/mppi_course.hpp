// Courses for a controller alone: walls, people, a robot whose motors lag and whose commands arrive late, and a lidar
// of exact points. No localiser, no planner and no gate are involved, so that what is touched is the controller's
// fault.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "nav/mppi.hpp"
#include "nav/polyline.hpp"
#include "slam/tiny_world.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::nav::testing {

using threewe::testing::add_box;
using threewe::testing::tiny_range;
using threewe::testing::TinyWall;

/// What is to be driven.
struct Course {
  std::vector<TinyWall> walls;
  std::vector<MovingDisc> people;  // they walk on as they do, and give way to nobody
  Pose2D start;
  std::vector<Vec2> path;
  double seconds = 60.0;  // to be done in
};

struct Outcome {
  bool arrived = false;
  double seconds = 0.0;
  double clearance = 1e9;      // [m] the least between outline and walls or people
  double contact_speed = 0.0;  // [m/s] the fastest of the robot's own motion while it touches something
};

class Draw {
 public:
  Draw(std::uint64_t seed, std::uint16_t course) : key_{.seed = seed, .robot = course, .stream = Stream::sampler} {}
  double between(double low, double high) { return uniform(key_, count_++, 0, low, high); }

 private:
  RngKey key_;
  std::uint64_t count_ = 0;
};

/// Drives with the simplest motors: a command is obeyed after the profile's latency, with its motors' lag.
class CourseWorld {
 public:
  CourseWorld(const RobotProfile& profile, const Course& course) : profile_(profile), course_(course) {
    pose_ = course.start;
    pending_.assign(static_cast<std::size_t>(profile.command_latency / kControlPeriod), {});
  }

  const Pose2D& pose() const { return pose_; }
  const Velocity& velocity() const { return velocity_; }
  const std::vector<MovingDisc>& people() const { return course_.people; }

  void tick(const Velocity& command) {
    pending_.push_back(command);
    const Velocity obeyed = pending_.front();
    pending_.erase(pending_.begin());
    constexpr int kParts = 10;
    const double dt = to_seconds(kControlPeriod) / kParts;
    const double gain = dt / to_seconds(profile_.body.motor_lag);
    for (int i = 0; i < kParts; ++i) {
      velocity_.vx += gain * (obeyed.vx - velocity_.vx);
      velocity_.vy += gain * (obeyed.vy - velocity_.vy);
      velocity_.omega += gain * (obeyed.omega - velocity_.omega);
      pose_ = integrate(pose_, velocity_, dt);
      for (MovingDisc& person : course_.people) person.position = person.position + dt * person.velocity;
    }
  }

  /// 360 exact points around the robot.
  std::vector<Vec2> scan() const {
    std::vector<Vec2> points;
    for (int i = 0; i < 360; ++i) {
      const double angle = pose_.theta + i * exact::kPi / 180.0;
      const auto [s, c] = exact::sincos(angle);
      double range = tiny_range(course_.walls, pose_.position(), angle, 8.0);
      for (const MovingDisc& person : course_.people) {
        const Vec2 to = person.position - pose_.position();
        const double along = c * to.x + s * to.y;
        const double room = person.radius * person.radius - (dot(to, to) - along * along);
        if (along > 0.0 && room > 0.0) range = std::min(range, along - exact::sqrt(room));
      }
      if (range < 8.0) points.push_back(pose_.position() + range * Vec2{c, s});
    }
    return points;
  }

  double clearance() const {
    const Footprint& footprint = profile_.body.footprint;
    double least = 1e9;
    for (const TinyWall& w : course_.walls) {
      // from the wall's ends and the points between them, and from the corners of the outline
      const double length = distance(w.a, w.b);
      const int parts = static_cast<int>(length / 0.01) + 1;
      for (int i = 0; i <= parts; ++i) {
        const Vec2 p = w.a + (static_cast<double>(i) / parts) * (w.b - w.a);
        if (distance(p, pose_.position()) < 0.6) least = std::min(least, footprint.signed_distance(inverse(pose_) * p));
      }
    }
    for (const MovingDisc& person : course_.people) {
      const Vec2 p = inverse(pose_) * person.position;
      least = std::min(least, footprint.signed_distance(p) - person.radius);
    }
    return least;
  }

 private:
  const RobotProfile& profile_;
  Course course_;
  Pose2D pose_;
  Velocity velocity_;
  std::vector<Velocity> pending_;
};

/// Drives a course; `step(seen, path)` is the controller under test: the command for what is seen, along the rest of
/// the path.
template <class Step>
Outcome drive(const RobotProfile& profile, const Course& course, Step step) {
  CourseWorld world(profile, course);
  Outcome outcome;
  Velocity command;
  std::vector<Vec2> points;
  std::vector<Vec2> path = course.path;
  for (int tick = 0; to_seconds(tick * kControlPeriod) < course.seconds; ++tick) {
    if (tick % 5 == 0) points = world.scan();
    const PathPoint here = nearest_on_path(path, world.pose().position());
    path.erase(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(here.piece));
    path.front() = here.point;
    command = step(MppiObservation{tick * kControlPeriod, world.pose(), command, points, world.people()}, path);
    world.tick(command);
    outcome.seconds = to_seconds((tick + 1) * kControlPeriod);
    const double speed = exact::hypot(world.velocity().vx, world.velocity().vy);
    const double clearance = tick % 2 == 0 ? world.clearance() : 1e9;
    outcome.clearance = std::min(outcome.clearance, clearance);
    if (clearance < 0.0) outcome.contact_speed = std::max(outcome.contact_speed, speed);
    outcome.arrived = distance(world.pose().position(), course.path.back()) < 0.06 && speed < 0.1;
    if (outcome.arrived) break;
  }
  return outcome;
}

/// The width of a robot that drives ahead [m].
inline double width_of(const RobotProfile& profile) {
  double half = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) half = std::max(half, std::fabs(c.y));
  return 2.0 * half;
}

/// A door somewhat wider than the robot [m], in a wall 10 cm thick, met from anywhere before it.
inline Course door(const RobotProfile& profile, std::uint64_t seed, double spare) {
  Draw draw(seed, 1);
  Course course;
  add_box(course.walls, {-1.5, -1.5}, {3.0, 1.5});
  const double half = 0.5 * (width_of(profile) + spare);
  add_box(course.walls, {1.0, half}, {1.1, 1.5});
  add_box(course.walls, {1.0, -1.5}, {1.1, -half});
  course.start = {draw.between(-0.8, 0.3), draw.between(-0.9, 0.9), draw.between(-1.5, 1.5)};
  course.path = {course.start.position(), {0.75, 0.0}, {1.35, 0.0}, {draw.between(1.7, 2.4), draw.between(-0.9, 0.9)}};
  return course;
}

/// Boxes on alternate sides of the way.
inline Course slalom(const RobotProfile& profile, std::uint64_t seed) {
  Draw draw(seed, 2);
  Course course;
  add_box(course.walls, {-0.5, -1.0}, {5.5, 1.0});
  const double pass = 0.5 * width_of(profile) + 0.15;  // from the middle of the way to the box
  course.path = {{0.0, 0.0}};
  for (int i = 0; i < 4; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double x = 0.9 + 1.0 * i + draw.between(-0.1, 0.1);
    const double edge = side * draw.between(-0.2, 0.0);
    add_box(course.walls, {x - 0.1, std::min(edge, side)}, {x + 0.1, std::max(edge, side)});
    course.path.push_back({x, edge - side * pass});
  }
  course.path.push_back({4.9, 0.0});
  course.start = {0.0, 0.0, draw.between(-3.1, 3.1)};
  return course;
}

/// People who cross a hall, none of whom walks into a robot that stands still.
inline Course people(const RobotProfile&, std::uint64_t seed) {
  Draw draw(seed, 3);
  Course course;
  add_box(course.walls, {-1.0, -4.0}, {6.0, 4.0});
  for (int i = 0; i < 3; ++i) {
    const double side = draw.between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
    const double speed = draw.between(0.3, 0.9);
    course.people.push_back({{1.2 + 1.3 * i + draw.between(-0.3, 0.3), side * draw.between(1.2, 3.5)},
                             {draw.between(-0.1, 0.1), -side * speed}});
  }
  course.start = {0.0, draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)};
  course.path = {course.start.position(), {5.0, draw.between(-0.5, 0.5)}};
  return course;
}

/// Out of a pocket, 15 cm larger than the robot's turning circle, that it has driven into nose first.
inline Course dead_end(const RobotProfile& profile, std::uint64_t seed) {
  Draw draw(seed, 4);
  Course course;
  const double half = profile.body.footprint.circumscribed_radius() + 0.075;
  add_box(course.walls, {-2.5, -1.5}, {1.0, 1.5});
  course.walls.push_back({{-1.0, half}, {half, half}});
  course.walls.push_back({{-1.0, -half}, {half, -half}});
  course.walls.push_back({{half, -half}, {half, half}});
  course.start = {draw.between(-0.1, 0.02), draw.between(-0.02, 0.02), draw.between(-0.2, 0.2)};
  course.path = {course.start.position(), {-1.3, 0.0}, {draw.between(-2.0, -1.6), draw.between(-1.0, 1.0)}};
  return course;
}

inline Course narrow_door(const RobotProfile& profile, std::uint64_t seed) { return door(profile, seed, 0.05); }
inline Course wide_door(const RobotProfile& profile, std::uint64_t seed) { return door(profile, seed, 0.2); }

struct NamedCourse {
  const char* name;
  Course (*make)(const RobotProfile&, std::uint64_t);
};
inline constexpr std::array<NamedCourse, 5> kCourses = {{{"a door 5 cm wider than the robot", narrow_door},
                                                         {"a door 20 cm wider than the robot", wide_door},
                                                         {"a slalom", slalom},
                                                         {"people who cross", people},
                                                         {"a dead end", dead_end}}};

}  // namespace threewe::nav::testing
