// Directions in a cone are given by their slope: (1, t) in the sensor's frame. All bounds of what is seen of a shape,
// or sends an echo, are lines through the sensor, hence linear in t; so what a shape has to do with the cone is an
// interval.
#include "sim/sonar_return.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace threewe::sim {
namespace {

constexpr double kInFront = 1e-9;  // [m] by which one surface must be nearer than another to hide it
constexpr double kSliver = 1e-9;   // slope; what is seen through a narrower gap is not heard

struct Interval {
  double low = -kInfinity;
  double high = kInfinity;

  bool empty() const { return !(low <= high); }
  // Leaves those t for which alpha * t >= beta.
  void keep(double alpha, double beta) {
    if (alpha > 0.0) low = std::max(low, beta / alpha);
    if (alpha < 0.0) high = std::min(high, beta / alpha);
    if (alpha == 0.0 && beta > 0.0) high = -kInfinity;
  }
  // Leaves the directions from `right` counter-clockwise to `left`, less than half a turn apart.
  void keep_between(Vec2 right, Vec2 left) {
    keep(right.x, right.y);
    keep(-left.x, -left.y);
  }
};

bool overlap(const Interval& a, const Interval& b) { return std::max(a.low, b.low) <= std::min(a.high, b.high); }

// A turn by an angle: its sine and cosine.
using Turn = exact::SinCos;
Vec2 left_by(const Turn& turn, Vec2 v) { return {turn.cos * v.x - turn.sin * v.y, turn.sin * v.x + turn.cos * v.y}; }
Vec2 right_by(const Turn& turn, Vec2 v) { return {turn.cos * v.x + turn.sin * v.y, turn.cos * v.y - turn.sin * v.x}; }

// A shape that the cone meets, in the sensor's frame.
struct Target {
  bool is_circle = false;
  Vec2 place;           // a segment's first end, or a circle's middle
  Vec2 along;           // from a segment's first end to the other
  double height = 0.0;  // of the sensor above a segment, times its length
  double radius = 0.0;
  Interval covers;       // where a ray would meet the shape if it were alone, inside of the cone and beside it
  Interval echoes;       // where, inside, it would send the sound back
  double nearest = 0.0;  // the slope of its nearest point, were it as long as one likes

  // [m] along the direction (1, slope), which it covers.
  double range(double slope) const {
    const double length = exact::sqrt(1.0 + slope * slope);
    if (!is_circle) return height / (along.x * slope - along.y) * length;
    const double ahead = (place.x + slope * place.y) / length;
    const double aside = (place.y - slope * place.x) / length;
    return ahead - exact::sqrt(std::max(radius * radius - aside * aside, 0.0));
  }
};

double slope_of(Vec2 direction) { return direction.x > 0.0 ? direction.y / direction.x : kInfinity; }

// Both, without a jump in between.
int both(bool a, bool b) { return static_cast<int>(a) & static_cast<int>(b); }

// A cone with its trigonometry done.
struct Ear {
  Vec2 origin;
  Turn heading;
  Interval slopes;
  // unit vectors along the axis and the edges, in the frame of the slice like `origin`
  Vec2 forward;
  Vec2 right;
  Vec2 left;
  Turn incidence;
  double range_max;

  explicit Ear(const SonarCone& cone)
      : origin(cone.sensor.position()),
        heading(exact::sincos(cone.sensor.theta)),
        incidence(exact::sincos(cone.max_incidence)),
        range_max(cone.range_max) {
    const auto [sin, cos] = exact::sincos(0.5 * cone.field_of_view);
    slopes = {-sin / cos, sin / cos};
    forward = {heading.cos, heading.sin};
    right = right_by({sin, cos}, forward);
    left = left_by({sin, cos}, forward);
  }

  // Whether all between two points, or all of a disc, is surely out of the cone. Most of a scene is, so that this comes
  // first; and without jumps, which no model could predict.
  bool misses(Vec2 a, Vec2 b) const {
    const int right_of_it = both(cross(right, a) < 0.0, cross(right, b) < 0.0);
    const int left_of_it = both(cross(a, left) < 0.0, cross(b, left) < 0.0);
    const int beyond_it = both(dot(forward, a) > range_max, dot(forward, b) > range_max);
    return (right_of_it | left_of_it | beyond_it) != 0;
  }
  bool misses(Vec2 center, double radius) const {
    const int right_of_it = cross(right, center) < -radius ? 1 : 0;
    const int left_of_it = cross(center, left) < -radius ? 1 : 0;
    const int beyond_it = dot(forward, center) > range_max + radius ? 1 : 0;
    return (right_of_it | left_of_it | beyond_it) != 0;
  }
};

using Targets = std::vector<Target>;

void add(const Ear& ear, const scene::Segment& segment, Targets& targets) {
  const Vec2 a = segment.a - ear.origin;
  const Vec2 b = segment.b - ear.origin;
  if (ear.misses(a, b)) return;
  const double height = cross(b - a, a);
  if (height <= 0.0) return;  // seen from behind

  Target target;
  target.place = right_by(ear.heading, a);
  target.along = right_by(ear.heading, b - a);
  target.height = height;
  target.covers.keep_between(target.place + target.along, target.place);
  if (!overlap(target.covers, ear.slopes)) return;

  const Vec2 inwards{-target.along.y, target.along.x};
  target.nearest = slope_of(inwards);
  target.echoes = ear.slopes;
  target.echoes.keep_between(target.place + target.along, target.place);
  target.echoes.keep_between(right_by(ear.incidence, inwards), left_by(ear.incidence, inwards));
  targets.push_back(target);
}

void add(const Ear& ear, const scene::Circle& circle, Targets& targets) {
  const Vec2 offset = circle.center - ear.origin;
  if (ear.misses(offset, circle.radius)) return;
  const double far_squared = dot(offset, offset);
  if (far_squared <= circle.radius * circle.radius) return;  // from inside
  const Vec2 center = right_by(ear.heading, offset);

  // the half angles that it is seen within, and that it sends echoes within
  const double sine = circle.radius / exact::sqrt(far_squared);
  const auto half_angle = [](double sin) { return Turn{sin, exact::sqrt(1.0 - sin * sin)}; };
  const Turn half = half_angle(sine);
  const Turn echoing = half_angle(sine * ear.incidence.sin);

  Target target;
  target.is_circle = true;
  target.place = center;
  target.radius = circle.radius;
  target.nearest = slope_of(center);
  target.covers.keep_between(right_by(half, center), left_by(half, center));
  target.echoes = ear.slopes;
  target.echoes.keep_between(right_by(echoing, center), left_by(echoing, center));
  if (overlap(target.covers, ear.slopes)) targets.push_back(target);
}

// The slopes at which two outlines cross, where one may stop hiding the other; infinite ones stand for none.
using Crossings = std::array<double, 2>;

Crossings line_and_circle(Vec2 a, Vec2 along, Vec2 center, double radius) {
  const double length_squared = dot(along, along);
  const double middle = dot(center - a, along) / length_squared;
  const Vec2 foot = a + middle * along;
  const double half_squared = (radius * radius - dot(center - foot, center - foot)) / length_squared;
  if (half_squared < 0.0) return {kInfinity, kInfinity};
  const double half = exact::sqrt(half_squared);
  return {slope_of(a + (middle - half) * along), slope_of(a + (middle + half) * along)};
}

Crossings crossings(const Target& a, const Target& b) {
  if (!a.is_circle && !b.is_circle) {
    const double turn = cross(a.along, b.along);
    if (turn == 0.0) return {kInfinity, kInfinity};
    return {slope_of(a.place + cross(b.place - a.place, b.along) / turn * a.along), kInfinity};
  }
  if (!a.is_circle) return line_and_circle(a.place, a.along, b.place, b.radius);
  if (!b.is_circle) return line_and_circle(b.place, b.along, a.place, a.radius);
  // two circles cross on the line of equal power
  const Vec2 apart = b.place - a.place;
  const double apart_squared = dot(apart, apart);
  if (apart_squared == 0.0) return {kInfinity, kInfinity};
  const double share = 0.5 + 0.5 * (a.radius * a.radius - b.radius * b.radius) / apart_squared;
  return line_and_circle(a.place + share * apart, {-apart.y, apart.x}, a.place, a.radius);
}

// A part of a target from which an echo may come, and the nearest point there.
struct Candidate {
  std::size_t target = 0;
  Interval part;
  SonarReturn nearest;
};

class Listening {
 public:
  Listening(const Targets& targets, double range_max) : targets_(targets), range_max_(range_max) {
    for (std::size_t i = 0; i < targets.size(); ++i) consider(i, targets[i].echoes);
  }

  // The nearest candidate that nothing hides. One that is hidden gives way to what shows on both sides of what hides
  // it.
  SonarReturn nearest() {
    while (!candidates_.empty()) {
      std::ranges::pop_heap(candidates_, farther);
      const Candidate candidate = candidates_.back();
      candidates_.pop_back();
      const Target* in_front = what_hides(candidate);
      if (in_front == nullptr) return candidate.nearest;

      const Interval hidden = hidden_part(candidate, *in_front);
      consider(candidate.target, {candidate.part.low, hidden.low - kSliver});
      consider(candidate.target, {hidden.high + kSliver, candidate.part.high});
    }
    return {range_max_, 0.0};
  }

 private:
  static bool farther(const Candidate& a, const Candidate& b) { return a.nearest.range > b.nearest.range; }

  void consider(std::size_t index, const Interval& part) {
    if (part.empty()) return;
    const Target& target = targets_[index];
    SonarReturn nearest{target.range(part.low), part.low};
    const auto compare = [&](double slope) {
      const double range = target.range(slope);
      if (range < nearest.range) nearest = {range, slope};
    };
    compare(part.high);
    if (target.nearest > part.low && target.nearest < part.high) compare(target.nearest);
    if (nearest.range >= range_max_) return;
    candidates_.push_back({index, part, nearest});
    std::ranges::push_heap(candidates_, farther);
  }

  const Target* what_hides(const Candidate& candidate) const {
    const auto [range, slope] = candidate.nearest;
    const Target* nearest = nullptr;
    double least = range - kInFront;
    for (const Target& other : targets_) {
      if (slope <= other.covers.low || slope >= other.covers.high) continue;
      const double other_range = other.range(slope);
      if (other_range >= least) continue;
      least = other_range;
      nearest = &other;
    }
    return nearest;
  }

  // The directions around the candidate's nearest point in which it is hidden.
  Interval hidden_part(const Candidate& candidate, const Target& in_front) const {
    const double slope = candidate.nearest.bearing;
    Interval hidden = in_front.covers;
    for (const double crossing : crossings(targets_[candidate.target], in_front)) {
      if (crossing <= slope) hidden.low = std::max(hidden.low, crossing);
      if (crossing >= slope) hidden.high = std::min(hidden.high, crossing);
    }
    return hidden;
  }

  const Targets& targets_;
  double range_max_;
  std::vector<Candidate> candidates_;  // a heap, the nearest on top
};

}  // namespace

SonarReturn nearest_sonar_return(const SonarCone& cone, const ShapeIndex& standing, const MovingShapes& moving) {
  const Ear ear(cone);
  const auto& [segments, circles] = standing.slice();
  Targets targets;
  for (const std::uint16_t shape : standing.near(ear.origin)) {
    if (shape < segments.size()) {
      add(ear, segments[shape], targets);
    } else {
      add(ear, circles[shape - segments.size()], targets);
    }
  }
  for (const scene::Segment& segment : moving.segments) add(ear, segment, targets);
  for (const scene::Circle& circle : moving.circles) add(ear, circle, targets);
  return Listening(targets, cone.range_max).nearest();
}

}  // namespace threewe::sim
