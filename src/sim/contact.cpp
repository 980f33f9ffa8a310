#include "threewe/sim/contact.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace threewe::sim {
namespace {

constexpr std::size_t kMaxCorners = 16;
constexpr std::size_t kMaxContacts = 64;
constexpr std::size_t kMaxShapes = 256;

// The distance that is kept from obstacles [m]; it is met at half of it.
constexpr double kSkin = 2e-4;
// What is touched is no farther than this [m].
constexpr double kTouch = 2.0 * kSkin;
// How far a body near a shape goes before it looks again [m]: it cuts no corner deeper than half of this.
constexpr double kStride = 1e-3;
// A step is taken in so many parts at most; time that is left then is lost.
constexpr int kMaxParts = 16;

constexpr Vec2 left_of(Vec2 v) { return {-v.y, v.x}; }

// The footprint's corners around the base, turned by a heading.
struct Outline {
  std::array<Vec2, kMaxCorners> corners;
  std::size_t count = 0;
  Vec2 edge_end(std::size_t i) const { return corners[i + 1 == count ? 0 : i + 1]; }
};

Outline turn_outline(const Footprint& footprint, double heading) {
  const auto [s, c] = exact::sincos(heading);
  Outline outline;
  for (const Vec2 corner : footprint.corners()) {
    outline.corners[outline.count++] = {c * corner.x - s * corner.y, s * corner.x + c * corner.y};
  }
  return outline;
}

// Separating axes: two convex shapes are apart exactly when an edge's normal of one of them tells so.
bool overlaps(const Outline& outline, Vec2 a, Vec2 b) {
  for (std::size_t i = 0; i < outline.count; ++i) {
    const Vec2 edge = outline.edge_end(i) - outline.corners[i];
    if (std::max(cross(edge, a - outline.corners[i]), cross(edge, b - outline.corners[i])) <= 0.0) return false;
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t i = 0; i < outline.count; ++i) {
    const double side = cross(b - a, outline.corners[i] - a);
    low = std::min(low, side);
    high = std::max(high, side);
  }
  return low < 0.0 && high > 0.0;
}

bool overlaps(const Outline& outline, Vec2 center, double radius) {
  bool inside = true;
  for (std::size_t i = 0; i < outline.count; ++i) {
    const Vec2 a = outline.corners[i];
    const Vec2 b = outline.edge_end(i);
    if (distance(center, closest_on_segment(center, a, b)) < radius) return true;
    inside = inside && cross(b - a, center - a) > 0.0;
  }
  return inside;
}

// A segment, or a disc around `a`; seen from the base's old position.
struct Shape {
  Vec2 a;
  Vec2 b;
  double radius;
  bool is_circle;
};

bool overlaps(const Outline& outline, Vec2 moved, const Shape& shape) {
  return shape.is_circle ? overlaps(outline, shape.a - moved, shape.radius)
                         : overlaps(outline, shape.a - moved, shape.b - moved);
}

// The shapes that a body could meet in this step.
class Neighbourhood {
 public:
  Neighbourhood(const ShapeIndex& obstacles, const MovingShapes& others, Vec2 base, double reach) {
    const scene::Slice& slice = obstacles.slice();
    for (const std::uint16_t shape : obstacles.near(base)) {
      if (shape < slice.segments.size()) {
        add(slice.segments[shape], base, reach);
      } else {
        add(slice.circles[shape - slice.segments.size()], base, reach);
      }
    }
    for (const scene::Segment& segment : others.segments) add(segment, base, reach);
    for (const scene::Circle& circle : others.circles) add(circle, base, reach);
  }

  std::span<const Shape> shapes() const { return std::span(shapes_).first(count_); }

 private:
  void add(const scene::Segment& segment, Vec2 base, double reach) {
    const Vec2 closest = closest_on_segment(base, segment.a, segment.b) - base;
    if (dot(closest, closest) < reach * reach) push({segment.a - base, segment.b - base, 0.0, false});
  }
  void add(const scene::Circle& circle, Vec2 base, double reach) {
    const Vec2 center = circle.center - base;
    const double far = reach + circle.radius;
    if (dot(center, center) < far * far) push({center, center, circle.radius, true});
  }
  void push(const Shape& shape) {
    if (count_ < kMaxShapes) shapes_[count_++] = shape;
  }

  std::array<Shape, kMaxShapes> shapes_;
  std::size_t count_ = 0;
};

// Velocity of the body in axes that do not turn: of the base, and about the vertical.
struct Twist {
  Vec2 linear;
  double angular = 0.0;
};

// A point of the outline and a place of an obstacle that touch, or nearly so.
struct Contact {
  Vec2 normal;  // from the obstacle to the body
  Vec2 arm;     // from the base to the point
  double gap = 0.0;
  double impulse = 0.0;  // over mass, as `resolve` found it
  double speed(const Twist& twist) const { return dot(normal, twist.linear) + cross(arm, normal) * twist.angular; }
};

// Visits every pair of near points of a body that has moved and a shape: visit(from shape to body, point of the body
// around its base, a direction out of the shape). The nearest pair is as far apart as the shapes are; and the distance
// between two convex shapes grows at least as fast as any such pair of points tells.
template <typename Visit>
void visit_pairs(const Outline& outline, Vec2 moved, const Shape& shape, const Visit& visit) {
  const Vec2 a = shape.a - moved;
  const Vec2 b = shape.b - moved;
  const Vec2 normal = left_of(b - a);
  const Vec2 towards_base = dot(normal, a) < 0.0 ? normal : -1.0 * normal;
  for (std::size_t i = 0; i < outline.count; ++i) {
    const Vec2 corner = outline.corners[i];
    visit(corner - (shape.is_circle ? a : closest_on_segment(corner, a, b)), corner, towards_base);

    const Vec2 edge = outline.edge_end(i) - corner;
    for (const Vec2 end : {a, b}) {
      const double t = dot(end - corner, edge) / dot(edge, edge);
      if (t > 0.0 && t < 1.0 && cross(edge, end - corner) <= 0.0) {
        const Vec2 on_edge = corner + t * edge;
        visit(on_edge - end, on_edge, left_of(edge));
      }
      if (shape.is_circle) break;
    }
  }
}

// How far a body that has moved is from a shape; 0 where they overlap.
double clearance(const Outline& outline, Vec2 moved, const Shape& shape) {
  if (overlaps(outline, moved, shape)) return 0.0;
  double least = std::numeric_limits<double>::infinity();
  visit_pairs(outline, moved, shape, [&](Vec2 offset, Vec2, Vec2) { least = std::min(least, dot(offset, offset)); });
  return std::max(exact::sqrt(least) - shape.radius, 0.0);
}

// Where the body is in the course of a step: how far its base has come, and its heading.
struct Place {
  Vec2 moved;
  double heading = 0.0;
};

Place advance(const Place& from, const Twist& twist, double seconds) {
  return {from.moved + seconds * twist.linear, from.heading + seconds * twist.angular};
}

// How long a body can go on until it meets a shape; `seconds` if it does not. No part of it is faster than `speed`, so
// it looks again only where it could be there.
double clear_time(const Footprint& footprint, const Place& from, const Twist& twist, double seconds,
                  const Shape& shape) {
  const auto gap_after = [&](double time) {
    const Place place = advance(from, twist, time);
    return clearance(turn_outline(footprint, place.heading), place.moved, shape);
  };
  const double speed = norm(twist.linear) + std::fabs(twist.angular) * footprint.circumscribed_radius();
  double gap = gap_after(0.0);
  if (speed == 0.0 || gap > speed * seconds + kSkin) return seconds;
  const double met = std::min(0.5 * kSkin, 0.9 * gap);
  for (double clear = 0.0; clear < seconds;) {
    double time = std::min(clear + std::max(gap - met, kStride) / speed, seconds);
    gap = gap_after(time);
    if (gap <= met) {
      for (int halving = 0; halving < 4; ++halving) {
        const double middle = 0.5 * (clear + time);
        (gap_after(middle) > met ? clear : time) = middle;
      }
      return clear;
    }
    clear = time;
  }
  return seconds;
}

// The same for all shapes.
double clear_time(const Footprint& footprint, const Place& from, const Twist& twist, double seconds,
                  std::span<const Shape> shapes) {
  double clear = seconds;
  for (double before = 0.0; before != clear;) {  // where one shape ends it, it must be clear of the others too
    before = clear;
    for (const Shape& shape : shapes) clear = clear_time(footprint, from, twist, clear, shape);
  }
  return clear;
}

struct Contacts {
  std::array<Contact, kMaxContacts> items;
  std::size_t count = 0;

  // The pairs that touch.
  Contacts(const Outline& outline, Vec2 moved, std::span<const Shape> shapes) {
    for (const Shape& shape : shapes) {
      visit_pairs(outline, moved, shape, [&](Vec2 offset, Vec2 arm, Vec2 outward) {
        const double length = norm(offset);
        if (length - shape.radius > kTouch || count == kMaxContacts) return;
        const Vec2 normal = length > 1e-9 ? (1.0 / length) * offset : (1.0 / norm(outward)) * outward;
        items[count++] = {normal, arm, length - shape.radius};
      });
    }
  }
};

double energy(const RigidBody& body, const Twist& twist) {
  return body.mass * dot(twist.linear, twist.linear) + body.inertia * twist.angular * twist.angular;
}

// The velocity nearest to `twist`, measured by energy, that brings no pair closer than the skin: projected Gauss-Seidel
// on the impulses.
Twist resolve(const RigidBody& body, Contacts& contacts, Twist twist, double seconds) {
  constexpr int kMaxSweeps = 50;
  const double before = energy(body, twist);
  const double mass_over_inertia = body.mass / body.inertia;
  for (std::size_t i = 0; i < contacts.count; ++i) contacts.items[i].impulse = 0.0;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double largest = 0.0;
    for (std::size_t i = 0; i < contacts.count; ++i) {
      Contact& contact = contacts.items[i];
      const double lever = cross(contact.arm, contact.normal);
      const double slowest = -std::max(contact.gap - kSkin, 0.0) / seconds;
      const double wanted = (slowest - contact.speed(twist)) / (1.0 + lever * lever * mass_over_inertia);
      const double change = std::max(contact.impulse + wanted, 0.0) - contact.impulse;
      contact.impulse += change;
      twist.linear = twist.linear + change * contact.normal;
      twist.angular += change * lever * mass_over_inertia;
      largest = std::max(largest, std::fabs(change));
    }
    if (largest < 1e-9) break;
  }

  // what the sweeps left over: standing still is always allowed, so scaling down ends every violation
  double share = 1.0;
  for (std::size_t i = 0; i < contacts.count; ++i) {
    const double closing = -contacts.items[i].speed(twist) * seconds;
    if (closing * share > contacts.items[i].gap) share = std::max(contacts.items[i].gap, 0.0) / closing;
  }
  const double after = energy(body, twist);
  if (after > before) share = std::min(share, exact::sqrt(before / after));
  return {share * twist.linear, share * twist.angular};
}

// The speed at which the body meets what has just held it back.
double approach_speed(const Contacts& contacts, const Twist& carried) {
  double fastest = 0.0;
  for (std::size_t i = 0; i < contacts.count; ++i) {
    const Contact& contact = contacts.items[i];
    if (contact.impulse > 0.0) fastest = std::max(fastest, -contact.speed(carried));
  }
  return fastest;
}

// A small step away from all that is nearer than the skin, where there is room.
Place restore_skin(const Contacts& contacts, const Outline& outline, const Place& place,
                   std::span<const Shape> shapes) {
  Vec2 out;
  for (std::size_t i = 0; i < contacts.count; ++i) {
    const Contact& contact = contacts.items[i];
    const double missing = kSkin - contact.gap - dot(contact.normal, out);
    if (missing > 0.0) out = out + missing * contact.normal;
  }
  const Vec2 moved = place.moved + out;
  const bool room = std::ranges::none_of(shapes, [&](const Shape& shape) { return overlaps(outline, moved, shape); });
  return {room ? moved : place.moved, place.heading};
}

}  // namespace

double contact_reach(const Footprint& footprint, double max_speed, double max_turn_rate, double seconds) {
  const double travel = (max_speed + max_turn_rate * footprint.circumscribed_radius()) * seconds;
  return footprint.circumscribed_radius() + 2.0 * (travel + kSkin);
}

Motion move(const RigidBody& body, const ShapeIndex& obstacles, const MovingShapes& others, const Pose2D& pose,
            const Velocity& velocity, const Velocity& carried, double seconds) {
  const Pose2D free_end = integrate(pose, velocity, seconds);
  const bool alone = others.segments.empty() && others.circles.empty();
  if (obstacles.near(pose.position()).empty() && alone) return {free_end, velocity};

  // only what lies within this step's travel can matter
  const double radius = body.footprint.circumscribed_radius();
  const double speed = exact::hypot(velocity.vx, velocity.vy) + std::fabs(velocity.omega) * radius;
  const Neighbourhood neighbourhood(obstacles, others, pose.position(), radius + 2.0 * speed * seconds + kTouch);
  const std::span<const Shape> shapes = neighbourhood.shapes();

  // from here on in axes that do not turn; the arc is followed along its chord
  Place place{{}, pose.theta};
  Twist twist{(1.0 / seconds) * (free_end.position() - pose.position()), velocity.omega};
  Twist met_with{rotate({carried.vx, carried.vy}, pose.theta), carried.omega};

  // freely until something is met, which holds it back; and so on, until the time is over
  Motion motion;
  double left = seconds;
  for (int part = 0; part < kMaxParts; ++part) {
    const double clear = clear_time(body.footprint, place, twist, left, shapes);
    place = advance(place, twist, clear);
    left -= clear;
    if (left == 0.0) break;

    const Outline outline = turn_outline(body.footprint, place.heading);
    Contacts contacts(outline, place.moved, shapes);
    twist = resolve(body, contacts, twist, left);
    motion.approach_speed = std::max(motion.approach_speed, approach_speed(contacts, met_with));
    met_with = resolve(body, contacts, met_with, left);
    place = restore_skin(contacts, outline, place, shapes);
    motion.touching = true;
  }
  if (!motion.touching) return {free_end, velocity};
  if (left == seconds) twist = {};  // it is stuck

  const Vec2 linear = rotate(twist.linear, -(place.heading - 0.5 * seconds * twist.angular));
  motion.velocity = {linear.x, linear.y, twist.angular};
  motion.pose = {pose.x + place.moved.x, pose.y + place.moved.y, wrap_angle(place.heading)};
  return motion;
}

}  // namespace threewe::sim
