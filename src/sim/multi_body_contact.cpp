#include "sim/multi_body_contact.hpp"
#include "core/exact.hpp"
#include "core/outline.hpp"

#include <algorithm>
#include <utility>

namespace threewe::sim {
namespace {

constexpr double kSkin = 5e-4;  // [m] kept between two bodies

// Velocity in axes that do not turn: of the base, and about the vertical.
struct Twist {
  Vec2 linear;
  double angular = 0.0;
};

// A corner of one body and the nearest point of another.
struct Contact {
  std::size_t a = 0;
  std::size_t b = 0;
  Vec2 normal;  // from b to a
  Vec2 arm_a;   // from each base to the point
  Vec2 arm_b;
  double slowest = 0.0;  // [m/s] at which the points must part; negative while there is room
  double impulse = 0.0;  // [N s]

  double speed_of_a(std::span<const Twist> t) const {
    return dot(normal, t[a].linear) + cross(arm_a, normal) * t[a].angular;
  }
  double speed_of_b(std::span<const Twist> t) const {
    return dot(normal, t[b].linear) + cross(arm_b, normal) * t[b].angular;
  }
  double parting(std::span<const Twist> t) const { return speed_of_a(t) - speed_of_b(t); }
};

std::vector<Vec2> corners_at(const RigidBody& body, const Pose2D& pose) {
  std::vector<Vec2> corners;
  for (const Vec2 corner : body.footprint.corners()) corners.push_back(pose * corner);
  return corners;
}

double reach(const Mover& mover, double seconds) {
  const double radius = mover.body->footprint.circumscribed_radius();
  const double speed = exact::hypot(mover.velocity.vx, mover.velocity.vy) + std::fabs(mover.velocity.omega) * radius;
  return radius + speed * seconds + kSkin;
}

// The pairs of points that could meet in this step.
std::vector<Contact> find_contacts(std::span<const Mover> movers, double seconds) {
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < movers.size(); ++i) {
    for (std::size_t j = i + 1; j < movers.size(); ++j) {
      const double reach_together = reach(movers[i], seconds) + reach(movers[j], seconds);
      if (distance(movers[i].pose.position(), movers[j].pose.position()) > reach_together) continue;
      for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)}) {
        const std::vector<Vec2> outline = corners_at(*movers[b].body, movers[b].pose);
        for (const Vec2 corner : corners_at(*movers[a].body, movers[a].pose)) {
          const Vec2 point = closest_on_outline(corner, outline);
          const double gap = distance(corner, point);
          if (gap < 1e-9) continue;
          contacts.push_back({a, b, (1.0 / gap) * (corner - point), corner - movers[a].pose.position(),
                              point - movers[b].pose.position(), (kSkin - gap) / seconds, 0.0});
        }
      }
    }
  }
  return contacts;
}

double mass_of(const Mover& mover) { return mover.mass * mover.body->mass; }
double inertia_of(const Mover& mover) { return mover.mass * mover.body->inertia; }

void push(const Mover& mover, Vec2 arm, Vec2 impulse, Twist& twist) {
  twist.linear = twist.linear + (1.0 / mass_of(mover)) * impulse;
  twist.angular += cross(arm, impulse) / inertia_of(mover);
}

// The inverse of the mass that a contact moves.
double mobility(const Mover& mover, Vec2 arm, Vec2 normal) {
  const double lever = cross(arm, normal);
  return 1.0 / mass_of(mover) + lever * lever / inertia_of(mover);
}

// Projected Jacobi: every contact looks at the same velocities, so that their order does not matter; each changes a
// share of what it would alone, so that together they do not overshoot.
void resolve(std::span<const Mover> movers, std::vector<Contact>& contacts, std::vector<Twist>& twists) {
  constexpr int kMaxSweeps = 400;
  constexpr double kConverged = 1e-7;  // [m/s]
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    const auto wanted = [&](const Contact& c) {
      const double inertia =
          1.0 / (mobility(movers[c.a], c.arm_a, c.normal) + mobility(movers[c.b], c.arm_b, c.normal));
      return std::max(c.impulse + inertia * (std::min(c.slowest, 0.0) - c.parting(twists)), 0.0) - c.impulse;
    };
    double largest = 0.0;
    std::vector<int> active(movers.size(), 0);  // contacts of each body
    std::vector<double> changes;
    for (const Contact& c : contacts) {
      changes.push_back(wanted(c));
      if (changes.back() != 0.0 || c.impulse > 0.0) ++active[c.a], ++active[c.b];
      largest = std::max(largest, std::fabs(changes.back()) / std::min(mass_of(movers[c.a]), mass_of(movers[c.b])));
    }
    if (largest < kConverged) return;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Contact& c = contacts[i];
      if (changes[i] == 0.0) continue;
      const double change = changes[i] / std::max(active[c.a], active[c.b]);
      c.impulse += change;
      push(movers[c.a], c.arm_a, change * c.normal, twists[c.a]);
      push(movers[c.b], c.arm_b, -change * c.normal, twists[c.b]);
    }
  }
}

// A body that turns as it goes is led along the chord of its arc.
Twist twist_of(const Velocity& velocity, const Pose2D& pose, double seconds) {
  return {rotate({velocity.vx, velocity.vy}, pose.theta + 0.5 * seconds * velocity.omega), velocity.omega};
}
Velocity velocity_of(const Twist& twist, const Pose2D& pose, double seconds) {
  const Vec2 linear = rotate(twist.linear, -(pose.theta + 0.5 * seconds * twist.angular));
  return {linear.x, linear.y, twist.angular};
}

// Of the speed at which two bodies approach, a body answers for what its own motion adds, and no more than all of it.
void note_approach(const Contact& contact, std::span<const Twist> carried, std::span<Mover> movers) {
  const double closing = -contact.parting(carried);
  if (contact.impulse <= 0.0 || closing <= 0.0) return;
  const auto note = [&](Mover& mover, double own) {
    mover.approach_speed = std::max(mover.approach_speed, std::clamp(own, 0.0, closing));
  };
  note(movers[contact.a], -contact.speed_of_a(carried));
  note(movers[contact.b], contact.speed_of_b(carried));
}

// Whether an edge of `a` has all of `b` on its outer side.
bool edge_separates(std::span<const Vec2> a, std::span<const Vec2> b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 edge = a[i + 1 == a.size() ? 0 : i + 1] - a[i];
    if (std::ranges::all_of(b, [&](Vec2 point) { return cross(edge, point - a[i]) <= 0.0; })) return true;
  }
  return false;
}

bool overlap(const Mover& a, const Pose2D& pose_a, const Mover& b, const Pose2D& pose_b) {
  const double reach = a.body->footprint.circumscribed_radius() + b.body->footprint.circumscribed_radius();
  if (distance(pose_a.position(), pose_b.position()) > reach) return false;
  const std::vector<Vec2> corners_a = corners_at(*a.body, pose_a);
  const std::vector<Vec2> corners_b = corners_at(*b.body, pose_b);
  return !edge_separates(corners_a, corners_b) && !edge_separates(corners_b, corners_a);
}

}  // namespace

void exchange_momentum(std::span<Mover> movers, double seconds) {
  std::vector<Contact> contacts = find_contacts(movers, seconds);
  if (contacts.empty()) return;

  std::vector<Twist> twists;
  std::vector<Twist> carried;
  for (const Mover& mover : movers) {
    twists.push_back(twist_of(mover.velocity, mover.pose, seconds));
    carried.push_back(twist_of(mover.carried, mover.pose, seconds));
  }
  resolve(movers, contacts, twists);

  for (const Contact& contact : contacts) {
    note_approach(contact, carried, movers);
    if (contact.impulse <= 0.0) continue;
    for (const std::size_t i : {contact.a, contact.b}) {
      movers[i].velocity = velocity_of(twists[i], movers[i].pose, seconds);
    }
  }
}

std::vector<bool> must_stay(std::span<const Mover> movers, std::span<const Pose2D> moved) {
  std::vector<bool> stays(movers.size(), false);
  const auto now = [&](std::size_t i) -> const Pose2D& { return stays[i] ? movers[i].pose : moved[i]; };
  for (bool found = true; found;) {
    found = false;
    std::vector<bool> next = stays;
    for (std::size_t i = 0; i < movers.size(); ++i) {
      for (std::size_t j = i + 1; j < movers.size(); ++j) {
        if (stays[i] && stays[j]) continue;
        if (!overlap(movers[i], now(i), movers[j], now(j))) continue;
        next[i] = next[j] = found = true;
      }
    }
    stays = next;
  }
  return stays;
}

}  // namespace threewe::sim
