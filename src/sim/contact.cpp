#include "threewe/sim/contact.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace threewe::sim {
namespace {

constexpr std::size_t kMaxCorners = 16;
constexpr std::size_t kMaxContacts = 64;
constexpr std::size_t kMaxShapes = 256;

// The distance that is kept from obstacles, so that the error of a linear step never reaches them [m].
constexpr double kSkin = 2e-4;

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
  bool hit;  // the body would run into it in this step
};

bool overlaps(const Outline& outline, Vec2 moved, const Shape& shape) {
  return shape.is_circle ? overlaps(outline, shape.a - moved, shape.radius)
                         : overlaps(outline, shape.a - moved, shape.b - moved);
}

bool overlaps_any(const Outline& outline, Vec2 moved, std::span<const Shape> shapes) {
  return std::ranges::any_of(shapes, [&](const Shape& shape) { return overlaps(outline, moved, shape); });
}

// The shapes that a body could meet in this step.
class Neighbourhood {
 public:
  Neighbourhood(const ShapeIndex& obstacles, std::span<const scene::Segment> others, Vec2 base, double reach) {
    const scene::Slice& slice = obstacles.slice();
    for (const std::uint16_t shape : obstacles.near(base)) {
      if (shape < slice.segments.size()) {
        add(slice.segments[shape], base, reach);
      } else {
        add(slice.circles[shape - slice.segments.size()], base, reach);
      }
    }
    for (const scene::Segment& segment : others) add(segment, base, reach);
  }

  std::span<Shape> shapes() { return std::span(shapes_).first(count_); }

 private:
  void add(const scene::Segment& segment, Vec2 base, double reach) {
    const Vec2 closest = closest_on_segment(base, segment.a, segment.b) - base;
    if (dot(closest, closest) < reach * reach) push({segment.a - base, segment.b - base, 0.0, false, false});
  }
  void add(const scene::Circle& circle, Vec2 base, double reach) {
    const Vec2 center = circle.center - base;
    const double far = reach + circle.radius;
    if (dot(center, center) < far * far) push({center, center, circle.radius, true, false});
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

// A point of the outline and a place of an obstacle near each other.
struct Contact {
  Vec2 normal;  // from the obstacle to the body
  Vec2 arm;     // from the base to the point
  double gap = 0.0;
  double impulse = 0.0;  // over mass
  double speed(const Twist& twist) const { return dot(normal, twist.linear) + cross(arm, normal) * twist.angular; }
};

// Visits every pair of near points of a body that has moved and a shape: visit(from shape to body, point of the body
// around its base, a direction out of the shape). The distance between two convex shapes grows at least as fast as any
// such pair of points tells, so that keeping all pairs apart to first order keeps the shapes apart.
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

// Whether a body that has moved overlaps a shape, or has come within half the skin of it.
bool hits(const Outline& outline, Vec2 moved, const Shape& shape) {
  if (overlaps(outline, moved, shape)) return true;
  const double least = shape.radius + 0.5 * kSkin;
  bool near = false;
  visit_pairs(outline, moved, shape,
              [&](Vec2 offset, Vec2, Vec2) { near = near || dot(offset, offset) < least * least; });
  return near;
}

struct Contacts {
  std::array<Contact, kMaxContacts> items;
  std::size_t count = 0;

  // The pairs of a shape that are no further apart than `within`.
  void add(const Outline& outline, Vec2 moved, const Shape& shape, double within) {
    visit_pairs(outline, moved, shape, [&](Vec2 offset, Vec2 arm, Vec2 outward) {
      const double length = norm(offset);
      if (length - shape.radius > within || count == kMaxContacts) return;
      const Vec2 normal = length > 1e-9 ? (1.0 / length) * offset : (1.0 / norm(outward)) * outward;
      items[count++] = {normal, arm, length - shape.radius};
    });
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

// The speed at which the body met what holds it now.
double approach_speed(const Contacts& contacts, const Twist& carried, const Twist& after, double seconds) {
  double fastest = 0.0;
  for (std::size_t i = 0; i < contacts.count; ++i) {
    const Contact& contact = contacts.items[i];
    const bool reached = contact.gap + contact.speed(after) * seconds <= 1.5 * kSkin;
    if (contact.impulse > 0.0 && reached) fastest = std::max(fastest, -contact.speed(carried));
  }
  return fastest;
}

// A small step away from everything that is nearer than half the skin.
Vec2 restore_skin(const Outline& outline, Vec2 moved, std::span<const Shape> shapes) {
  Contacts near;
  for (const Shape& shape : shapes) near.add(outline, moved, shape, 0.5 * kSkin);
  Vec2 out;
  for (std::size_t i = 0; i < near.count; ++i) {
    const Contact& contact = near.items[i];
    const double missing = kSkin - contact.gap - dot(contact.normal, out);
    if (missing > 0.0) out = out + missing * contact.normal;
  }
  return out;
}

}  // namespace

double contact_reach(const Footprint& footprint, double max_speed, double max_turn_rate, double seconds) {
  const double travel = (max_speed + max_turn_rate * footprint.circumscribed_radius()) * seconds;
  return footprint.circumscribed_radius() + 2.0 * (travel + kSkin);
}

Motion move(const RigidBody& body, const ShapeIndex& obstacles, std::span<const scene::Segment> others,
            const Pose2D& pose, const Velocity& velocity, const Velocity& carried, double seconds) {
  const Pose2D free_end = integrate(pose, velocity, seconds);
  if (obstacles.near(pose.position()).empty() && others.empty()) return {free_end, velocity};

  // only what lies within this step's travel can matter
  const double radius = body.footprint.circumscribed_radius();
  const double speed = exact::hypot(velocity.vx, velocity.vy) + std::fabs(velocity.omega) * radius;
  const double within = speed * seconds + 2.0 * kSkin;
  Neighbourhood neighbourhood(obstacles, others, pose.position(), radius + within);
  const std::span<Shape> shapes = neighbourhood.shapes();
  if (shapes.empty()) return {free_end, velocity};

  // from here on in axes that do not turn; the arc is followed along its chord
  const auto outline_after = [&](const Twist& twist) {
    return turn_outline(body.footprint, pose.theta + seconds * twist.angular);
  };
  const Twist free{(1.0 / seconds) * (free_end.position() - pose.position()), velocity.omega};
  Twist twist = free;

  // whatever the motion would run into holds it back, and then perhaps something else that comes into its way
  Contacts contacts;
  for (bool found = true; found;) {
    const Outline there = outline_after(twist);
    found = false;
    for (Shape& shape : shapes) {
      if (shape.hit || !hits(there, seconds * twist.linear, shape)) continue;
      shape.hit = found = true;
    }
    if (!found) break;
    contacts.count = 0;
    const Outline outline = turn_outline(body.footprint, pose.theta);
    for (const Shape& shape : shapes) {
      if (shape.hit) contacts.add(outline, {}, shape, within);
    }
    twist = resolve(body, contacts, free, seconds);
  }
  if (contacts.count == 0) return {free_end, velocity};

  // turning bends the paths of the corners: where that would overlap after all, a shorter step does not
  constexpr int kHalvings = 5;
  for (int i = 0; i <= kHalvings && overlaps_any(outline_after(twist), seconds * twist.linear, shapes); ++i) {
    const double share = i < kHalvings ? 0.5 : 0.0;
    twist = {share * twist.linear, share * twist.angular};
  }

  Motion motion;
  const Vec2 met = rotate({carried.vx, carried.vy}, pose.theta);
  motion.approach_speed = approach_speed(contacts, {met, carried.omega}, twist, seconds);
  motion.touching = true;
  const Vec2 linear = rotate(twist.linear, -(pose.theta + 0.5 * seconds * twist.angular));
  motion.velocity = {linear.x, linear.y, twist.angular};

  const Outline there = outline_after(twist);
  Vec2 moved = seconds * twist.linear;
  const Vec2 out = restore_skin(there, moved, shapes);
  if (!overlaps_any(there, moved + out, shapes)) moved = moved + out;
  motion.pose = {pose.x + moved.x, pose.y + moved.y, wrap_angle(pose.theta + seconds * twist.angular)};
  return motion;
}

}  // namespace threewe::sim
