#include "agent/body.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/exact.hpp"

namespace threewe::agent {
namespace {

constexpr double kNextTo = 1.3;            // [m] between the centres of things that stand next to each other
constexpr double kRoom = 0.06;             // [m] that a place to stand has around the robot
constexpr double kOtherProbability = 0.4;  // of the kind of the thing that another is next to

}  // namespace

Reachable Body::reachable() const {
  return {robot.map(), position(), robot.profile().body.footprint.inscribed_radius() + kRoom};
}

double Body::heading_to(Vec2 point) const {
  const Vec2 d = point - position();
  return exact::atan2(d.y, d.x);
}

std::optional<MoveResult> Drive::take() {
  if (!motion_ || !motion_->done()) return {};
  return std::exchange(motion_, nullptr)->result();
}

void Drive::cancel() {
  if (motion_) motion_->cancel();
  motion_.reset();
}

std::vector<semantics::MappedThing> things_meant(const Body& body, const language::ThingPhrase& thing,
                                                 const std::vector<std::uint64_t>& tried, double least_probability) {
  auto found = body.map.find(
      {.kind = thing.kind, .color = thing.color, .place = thing.place, .least_probability = least_probability});
  std::erase_if(found, [&](const auto& one) { return std::ranges::find(tried, one.id) != tried.end(); });
  if (!thing.next_to.empty()) {
    const std::size_t space = thing.next_to.find(' ');
    semantics::ThingQuery other{.kind = thing.next_to.substr(space == std::string::npos ? 0 : space + 1),
                                .color = space == std::string::npos ? "" : thing.next_to.substr(0, space),
                                .place = {},
                                .least_probability = kOtherProbability};
    const auto others = body.map.find(other);
    std::erase_if(found, [&](const auto& one) {
      return std::ranges::none_of(others, [&](const auto& beside) {
        return beside.id != one.id && norm(beside.position - one.position) < kNextTo;
      });
    });
  }
  if (thing.which.empty()) return found;
  const Vec2 here = body.position();
  std::ranges::stable_sort(found, [&](const auto& a, const auto& b) {
    const bool nearer = norm(a.position - here) < norm(b.position - here);
    const bool farther = norm(a.position - here) > norm(b.position - here);
    return thing.which == "farthest" ? farther : nearer;
  });
  return found;
}

std::string in_words(const language::ThingPhrase& thing) {
  std::string text = thing.kind.empty() ? "thing" : thing.kind;
  if (!thing.color.empty()) text = thing.color + " " + text;
  if (!thing.which.empty()) text = thing.which + " " + text;
  if (!thing.next_to.empty()) text += " next to a " + thing.next_to;
  if (!thing.place.empty()) text += " in the " + thing.place;
  return text;
}

std::string in_words(const Body& body, const semantics::MappedThing& thing) {
  return fmt::format("{} {} at ({:.1f}, {:.1f})", vision::color_names()[thing.color()], body.map.labels()[thing.kind()],
                     thing.position.x, thing.position.y);
}

}  // namespace threewe::agent
