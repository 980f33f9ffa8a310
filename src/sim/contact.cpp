#include "sim/contact.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>

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

// A list that is cheap to make: room that nothing is in yet is not set.
template <class T, std::size_t kCapacity>
class FixedList {
 public:
  void push(const T& item) {
    if (count_ < kCapacity) std::construct_at(data() + count_++, item);
  }
  std::span<T> items() { return {data(), count_}; }
  std::span<const T> items() const { return {data(), count_}; }
  bool empty() const { return count_ == 0; }

 private:
  static_assert(std::is_trivially_copyable_v<T>);
  T* data() { return reinterpret_cast<T*>(storage_); }
  const T* data() const { return reinterpret_cast<const T*>(storage_); }
  alignas(T) std::byte storage_[kCapacity * sizeof(T)];
  std::size_t count_ = 0;
};

// A corner of the footprint, around the base, and what is known of the edge from it to the next.
struct Corner {
  Vec2 at;
  double per_square = 0.0;  // 1 over the edge's length squared [1/m^2]
};

class Outline {
 public:
  Outline() = default;
  explicit Outline(const Footprint& footprint) {
    const std::span<const Vec2> corners = footprint.corners();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 edge = corners[i + 1 == corners.size() ? 0 : i + 1] - corners[i];
      corners_.push({corners[i], 1.0 / dot(edge, edge)});
    }
  }

  Outline turned(double heading) const {
    const auto [s, c] = exact::sincos(heading);
    Outline result;
    for (const auto& [at, per_square] : corners()) {
      result.corners_.push({{c * at.x - s * at.y, s * at.x + c * at.y}, per_square});
    }
    return result;
  }

  std::span<const Corner> corners() const { return corners_.items(); }

  // Visits every edge: visit(corner, from it to the next, 1 over the square of that).
  template <typename Visit>
  void visit_edges(const Visit& visit) const {
    const std::span<const Corner> corners = this->corners();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 next = corners[i + 1 == corners.size() ? 0 : i + 1].at;
      visit(corners[i].at, next - corners[i].at, corners[i].per_square);
    }
  }

 private:
  FixedList<Corner, kMaxCorners> corners_;
};

// A segment, or a disc around `a`; seen from the base's old position.
struct Shape {
  Vec2 a;
  Vec2 along;               // from a to b
  double per_square = 0.0;  // 1 over its length squared [1/m^2]; 0 of a point
  double per_length = 0.0;  // [1/m]
  double radius = 0.0;
  bool is_circle = false;
};

constexpr double share_along(Vec2 from_start, Vec2 along, double per_square) {
  return std::min(std::max(dot(from_start, along) * per_square, 0.0), 1.0);
}

// How far a body that has moved is from a shape; 0 where they overlap.
double clearance(const Outline& outline, Vec2 moved, const Shape& shape) {
  const Vec2 a = shape.a - moved;

  // mostly a corner is before a wall: no nearer than to the wall's line, and all corners are on one side of that
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  Vec2 lowest;
  Vec2 highest;
  for (const Corner& corner : outline.corners()) {
    const Vec2 from_a = corner.at - a;
    const double height = cross(shape.along, from_a);
    if (height < low) low = height, lowest = from_a;
    if (height > high) high = height, highest = from_a;
  }
  const bool beside = low > 0.0 || high < 0.0;
  const double foot = dot(low > 0.0 ? lowest : highest, shape.along) * shape.per_square;
  if (beside && foot >= 0.0 && foot <= 1.0) return std::max(low, -high) * shape.per_length;

  // else the nearest points are a corner and one of the shape, or one of a side and an end of the shape; and two convex
  // shapes are apart exactly when a side of one of them has the other on its outer side
  double least = std::numeric_limits<double>::infinity();
  double inside = least;
  outline.visit_edges([&](Vec2 corner, Vec2 edge, double per_square) {
    const Vec2 from_a = corner - a;
    const Vec2 offset = from_a - share_along(from_a, shape.along, shape.per_square) * shape.along;
    const Vec2 to_a = a - corner;
    const Vec2 to_b = to_a + shape.along;
    const Vec2 offset_a = to_a - share_along(to_a, edge, per_square) * edge;
    const Vec2 offset_b = to_b - share_along(to_b, edge, per_square) * edge;
    inside = std::min(inside, std::max(cross(edge, to_a), cross(edge, to_b)));
    for (const Vec2 apart : {offset, offset_a, offset_b}) least = std::min(least, dot(apart, apart));
  });
  if (inside > 0.0 && (shape.is_circle || !beside)) return 0.0;
  return std::max(exact::sqrt(least) - shape.radius, 0.0);
}

// Whether a line along a side of either has more than `distance` between body and shape: seldom wrong, and only towards
// no.
bool surely_apart(const Outline& outline, const Shape& shape, double distance) {
  const double far = distance + shape.radius;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  bool apart = false;
  outline.visit_edges([&](Vec2 corner, Vec2 edge, double per_square) {
    const Vec2 to_a = shape.a - corner;
    const double inside = std::max(cross(edge, to_a), cross(edge, to_a + shape.along));
    apart = apart || (inside < 0.0 && inside * inside * per_square > far * far);
    const double side = cross(shape.along, corner - shape.a);
    low = std::min(low, side);
    high = std::max(high, side);
  });
  const double least = std::max(low, -high);
  return apart || (least > 0.0 && least * least * shape.per_square > far * far);
}

// The shapes that a body could meet in a step in which no part of it goes farther than `travel`.
using Neighbourhood = FixedList<Shape, kMaxShapes>;

Neighbourhood find_neighbourhood(const Footprint& footprint, const ShapeIndex& obstacles, const MovingShapes& others,
                                 const Pose2D& pose, double travel) {
  const Vec2 base = pose.position();
  const double reach = footprint.circumscribed_radius() + travel;
  Neighbourhood found;
  std::optional<Outline> outline;
  const auto add = [&](const Shape& shape) {
    if (!outline) outline.emplace(Outline(footprint).turned(pose.theta));
    if (!surely_apart(*outline, shape, travel)) found.push(shape);
  };
  const auto add_segment = [&](const scene::Segment& segment) {
    const Vec2 a = segment.a - base;
    const Vec2 along = segment.b - segment.a;
    const double square = dot(along, along);
    // nearest to the base is an end or a point between them
    const double ahead = -dot(a, along);
    const double side = cross(a, along);
    if (ahead > 0.0 && ahead < square ? side * side > reach * reach * square
                                      : std::min(dot(a, a), dot(a + along, a + along)) > reach * reach) {
      return;
    }
    const double per_square = square > 0.0 ? 1.0 / square : 0.0;
    add({a, along, per_square, exact::sqrt(per_square), 0.0, false});
  };
  const auto add_circle = [&](const scene::Circle& circle) {
    const Vec2 center = circle.center - base;
    const double far = reach + circle.radius;
    if (dot(center, center) < far * far) add({center, {}, 0.0, 0.0, circle.radius, true});
  };

  const scene::Slice& slice = obstacles.slice();
  for (const std::uint16_t shape : obstacles.near(base)) {
    if (shape < slice.segments.size()) {
      add_segment(slice.segments[shape]);
    } else {
      add_circle(slice.circles[shape - slice.segments.size()]);
    }
  }
  for (const scene::Segment& segment : others.segments) add_segment(segment);
  for (const scene::Circle& circle : others.circles) add_circle(circle);
  return found;
}

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
  const Vec2 normal = left_of(shape.along);
  const Vec2 towards_base = dot(normal, a) < 0.0 ? normal : -1.0 * normal;
  outline.visit_edges([&](Vec2 corner, Vec2 edge, double per_square) {
    const Vec2 from_a = corner - a;
    visit(from_a - share_along(from_a, shape.along, shape.per_square) * shape.along, corner, towards_base);

    for (const Vec2 end : {a, a + shape.along}) {
      const double t = dot(end - corner, edge) * per_square;
      if (t > 0.0 && t < 1.0 && cross(edge, end - corner) <= 0.0) {
        const Vec2 on_edge = corner + t * edge;
        visit(on_edge - end, on_edge, left_of(edge));
      }
      if (shape.is_circle) break;
    }
  });
}

// Where the body is in the course of a step: how far its base has come, and its heading.
struct Place {
  Vec2 moved;
  double heading = 0.0;
};

Place advance(const Place& from, const Twist& twist, double seconds) {
  return {from.moved + seconds * twist.linear, from.heading + seconds * twist.angular};
}

// A body on its way until it meets something. No part of it is faster than `speed` [m/s].
struct Way {
  const Outline& outline;  // at heading 0
  Place from;
  Twist twist;
  double speed = 0.0;

  double gap_after(double seconds, const Shape& shape) const {
    const Place place = advance(from, twist, seconds);
    return clearance(outline.turned(place.heading), place.moved, shape);
  }
};

// How long it can go on until it meets a shape that is `gap` away at first; `seconds` if it does not. It looks again
// only where it could be there.
double clear_time(const Way& way, double seconds, const Shape& shape, double gap) {
  if (way.speed == 0.0 || gap > way.speed * seconds + kSkin) return seconds;
  const double met = std::min(0.5 * kSkin, 0.9 * gap);
  for (double clear = 0.0; clear < seconds;) {
    double time = std::min(clear + std::max(gap - met, kStride) / way.speed, seconds);
    gap = way.gap_after(time, shape);
    if (gap <= met) {
      for (int halving = 0; halving < 4; ++halving) {
        const double middle = 0.5 * (clear + time);
        (way.gap_after(middle, shape) > met ? clear : time) = middle;
      }
      return clear;
    }
    clear = time;
  }
  return seconds;
}

// The same for all shapes, round and round: where one ends it, it must be clear of all others too.
double clear_time(const Way& way, double seconds, std::span<const Shape> shapes) {
  const Outline outline = way.outline.turned(way.from.heading);
  FixedList<double, kMaxShapes> gaps;
  for (const Shape& shape : shapes) gaps.push(clearance(outline, way.from.moved, shape));

  double clear = seconds;
  std::size_t found_clear = 0;
  for (std::size_t i = 0; found_clear < shapes.size(); i = i + 1 == shapes.size() ? 0 : i + 1) {
    const double time = clear_time(way, clear, shapes[i], gaps.items()[i]);
    found_clear = time < clear ? 1 : found_clear + 1;
    clear = time;
  }
  return clear;
}

// The pairs that touch.
using Contacts = FixedList<Contact, kMaxContacts>;

Contacts find_contacts(const Outline& outline, Vec2 moved, std::span<const Shape> shapes) {
  Contacts contacts;
  for (const Shape& shape : shapes) {
    const double radius = shape.radius;
    const double far = kTouch + radius;
    visit_pairs(outline, moved, shape, [&](Vec2 offset, Vec2 arm, Vec2 outward) {
      if (dot(offset, offset) > far * far) return;
      const double length = norm(offset);
      const Vec2 normal = length > 1e-9 ? (1.0 / length) * offset : (1.0 / norm(outward)) * outward;
      contacts.push({normal, arm, length - radius});
    });
  }
  return contacts;
}

double energy(const RigidBody& body, const Twist& twist) {
  return body.mass * dot(twist.linear, twist.linear) + body.inertia * twist.angular * twist.angular;
}

// The velocity nearest to `twist`, measured by energy, that brings no pair closer than the skin: projected Gauss-Seidel
// on the impulses.
Twist resolve(const RigidBody& body, Contacts& contacts, Twist twist, double seconds) {
  constexpr int kMaxSweeps = 50;
  const double before = energy(body, twist);
  const double mass_over_inertia = body.mass / body.inertia;
  for (Contact& contact : contacts.items()) contact.impulse = 0.0;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double largest = 0.0;
    for (Contact& contact : contacts.items()) {
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

  // what the sweeps left over: standing still is always allowed, so scaling down ends every approach that is too fast
  double share = 1.0;
  for (const Contact& contact : contacts.items()) {
    const double closing = -contact.speed(twist) * seconds;
    if (closing > 0.0 && closing * share > contact.gap) share = std::max(contact.gap, 0.0) / closing;
  }
  const double after = energy(body, twist);
  if (after > before) share = std::min(share, exact::sqrt(before / after));
  return {share * twist.linear, share * twist.angular};
}

// The speed at which the body meets what has just held it back.
double approach_speed(const Contacts& contacts, const Twist& carried) {
  double fastest = 0.0;
  for (const Contact& contact : contacts.items()) {
    if (contact.impulse > 0.0) fastest = std::max(fastest, -contact.speed(carried));
  }
  return fastest;
}

// A small step away from all that is nearer than the skin, where there is room.
Place restore_skin(const Contacts& contacts, const Outline& outline, const Place& place,
                   std::span<const Shape> shapes) {
  Vec2 out;
  for (const Contact& contact : contacts.items()) {
    const double missing = kSkin - contact.gap - dot(contact.normal, out);
    if (missing > 0.0) out = out + missing * contact.normal;
  }
  const Vec2 moved = place.moved + out;
  const auto is_entered = [&](const Shape& shape) { return clearance(outline, moved, shape) == 0.0; };
  return {std::ranges::none_of(shapes, is_entered) ? moved : place.moved, place.heading};
}

}  // namespace

double contact_reach(const Footprint& footprint, double max_speed, double max_turn_rate, double seconds) {
  const double travel = (max_speed + max_turn_rate * footprint.circumscribed_radius()) * seconds;
  return footprint.circumscribed_radius() + 2.0 * (travel + kSkin);
}

Motion move(const RigidBody& body, const ShapeIndex& obstacles, const MovingShapes& others, const Pose2D& pose,
            const Velocity& velocity, const Velocity& carried, double seconds) {
  return move(body, obstacles, others, pose, velocity, carried, seconds, integrate(pose, velocity, seconds));
}

Motion move(const RigidBody& body, const ShapeIndex& obstacles, const MovingShapes& others, const Pose2D& pose,
            const Velocity& velocity, const Velocity& carried, double seconds, const Pose2D& free_end) {
  const bool alone = others.segments.empty() && others.circles.empty();
  if (obstacles.near(pose.position()).empty() && alone) return {free_end, velocity};

  // only what lies within this step's travel can matter; contact never makes a part of the body twice as fast
  const Footprint& footprint = body.footprint;
  const double speed =
      exact::hypot(velocity.vx, velocity.vy) + std::fabs(velocity.omega) * footprint.circumscribed_radius();
  const Neighbourhood neighbourhood =
      find_neighbourhood(footprint, obstacles, others, pose, 2.0 * speed * seconds + kTouch);
  if (neighbourhood.empty()) return {free_end, velocity};
  const std::span<const Shape> shapes = neighbourhood.items();

  // from here on in axes that do not turn; the arc is followed along its chord
  Place place{{}, pose.theta};
  Twist twist{(1.0 / seconds) * (free_end.position() - pose.position()), velocity.omega};
  Twist met_with{rotate({carried.vx, carried.vy}, pose.theta), carried.omega};

  // freely until something is met, which holds it back; and so on, until the time is over
  const Outline straight(footprint);
  Motion motion;
  double left = seconds;
  for (int part = 0; part < kMaxParts; ++part) {
    const double fastest = norm(twist.linear) + std::fabs(twist.angular) * footprint.circumscribed_radius();
    const double clear = clear_time({straight, place, twist, fastest}, left, shapes);
    place = advance(place, twist, clear);
    left -= clear;
    if (left == 0.0) break;

    const Outline outline = straight.turned(place.heading);
    Contacts contacts = find_contacts(outline, place.moved, shapes);
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
