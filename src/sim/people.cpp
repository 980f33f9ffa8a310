#include "sim/people.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

constexpr double kSeconds = to_seconds(kStep);
constexpr double kCourtesy = 1.0;    // [m] ahead that must be free of robots
constexpr double kElbowRoom = 0.01;  // [m] that is left to a robot beside

double route_length(const scene::Person& person) {
  double length = 0.0;
  for (std::size_t i = 0; i < person.route.size(); ++i) {
    length += distance(person.route[i], person.route[(i + 1) % person.route.size()]);
  }
  return length;
}

bool touches(const scene::Circle& circle, const Footprint& footprint, const Pose2D& pose) {
  return footprint.signed_distance(inverse(pose) * circle.center) < circle.radius + kElbowRoom;
}

bool touches_any(const scene::Circle& circle, const Model& model, std::span<const RobotState> robots) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (touches(circle, model.robots[i].body.footprint, robots[i].pose)) return true;
  }
  return false;
}

bool is_blocked(const PersonPlace& place, const Model& model, std::span<const RobotState> robots) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const Vec2 offset = robots[i].pose.position() - place.circle.center;
    const double ahead = dot(offset, place.direction);
    const double room = place.circle.radius + model.robots[i].body.footprint.circumscribed_radius();
    if (ahead > 0.0 && ahead < kCourtesy && std::fabs(cross(offset, place.direction)) < room) return true;
  }
  return false;
}

}  // namespace

PersonPlace place_on(const scene::Person& person, const PersonState& state) {
  const std::vector<Vec2>& route = person.route;
  double left = state.along;
  for (std::size_t i = 0;; i = (i + 1) % route.size()) {
    const Vec2 leg = route[(i + 1) % route.size()] - route[i];
    const double length = norm(leg);
    // rounding may leave a trifle beyond the last leg: the walk goes on along the first
    if (left > length) {
      left -= length;
      continue;
    }
    if (length == 0.0) continue;
    const Vec2 direction = (1.0 / length) * leg;
    return {{route[i] + left * direction, person.radius, -1}, direction};
  }
}

std::vector<scene::Circle> circles_of(const Model& model, std::span<const PersonState> people) {
  std::vector<scene::Circle> circles;
  circles.reserve(people.size());
  for (std::size_t i = 0; i < people.size(); ++i) {
    circles.push_back(place_on(model.scene->people[i], people[i]).circle);
  }
  return circles;
}

double swing_of(const PersonState& state) {
  constexpr double kStride = 1.4;  // [m], two steps
  return 0.085 * exact::sin(2.0 * exact::kPi * state.along / kStride);
}

std::array<scene::Circle, 2> legs_of(const scene::Person& person, const PersonState& state) {
  const PersonPlace place = place_on(person, state);
  const double size = place.circle.radius / 0.25;
  const Vec2 aside{-place.direction.y, place.direction.x};  // to the left
  const Vec2 leg = size * (swing_of(state) * place.direction + kLegAside * aside);
  return {{{place.circle.center + leg, size * kLegRadius, -1}, {place.circle.center - leg, size * kLegRadius, -1}}};
}

std::vector<scene::Circle> legs_of(const Model& model, std::span<const PersonState> people) {
  std::vector<scene::Circle> legs;
  legs.reserve(2 * people.size());
  for (std::size_t i = 0; i < people.size(); ++i) {
    for (const scene::Circle& leg : legs_of(model.scene->people[i], people[i])) legs.push_back(leg);
  }
  return legs;
}

std::vector<PersonState> begin_people(const Model& model, std::span<const RobotState> robots, std::uint64_t seed,
                                      std::uint32_t episode) {
  constexpr double kStride = 0.1;  // [m]
  std::vector<PersonState> people;
  for (const scene::Person& person : model.scene->people) {
    const RngKey key{.seed = seed,
                     .episode = episode,
                     .sensor = static_cast<std::uint16_t>(people.size()),
                     .stream = Stream::people};
    const double length = route_length(person);
    PersonState state{uniform(key, 0, 0, 0.0, length)};
    for (double tried = 0.0; touches_any(place_on(person, state).circle, model, robots); tried += kStride) {
      if (tried > length) throw ConfigError(fmt::format("a robot leaves no room on the route of '{}'", person.name));
      state.along += kStride;
      if (state.along >= length) state.along -= length;
    }
    people.push_back(state);
  }
  return people;
}

void walk(const Model& model, std::span<const RobotState> robots, std::span<PersonState> people) {
  for (std::size_t i = 0; i < people.size(); ++i) {
    const scene::Person& person = model.scene->people[i];
    if (is_blocked(place_on(person, people[i]), model, robots)) continue;
    PersonState next{people[i].along + kSeconds * person.speed};
    const double length = route_length(person);
    if (next.along >= length) next.along -= length;
    if (!touches_any(place_on(person, next).circle, model, robots)) people[i] = next;
  }
}

}  // namespace threewe::sim
