#include "agent/skills.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "language/route.hpp"
#include "semantics/probable_place.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::agent {
namespace {

using language::Skill;
using language::Step;

constexpr double kPlaceTolerance = 0.5;  // [m] of a place's middle

std::string sentence(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text + ".";
}

Outcome outcome_of(const MoveResult& moved) {
  return {moved.success ? "done" : std::string(to_string(moved.reason)), moved.detail};
}

// A motion, and nothing else.
class Moving : public SkillRun {
 public:
  Moving(Body& body, const nav::Goal& goal) { drive_.begin(body, goal); }
  std::optional<Outcome> update(Body&) override {
    const auto moved = drive_.take();
    return moved ? std::optional(outcome_of(*moved)) : std::nullopt;
  }
  void cancel() override { drive_.cancel(); }

 private:
  Drive drive_;
};

// To the middle of a place or, where something stands there, to the floor nearest to it.
class ToPlace : public SkillRun {
 public:
  ToPlace(Body& body, const std::string& name) {
    if (name == language::kStart) {
      middle_ = body.start;
    } else {
      const semantics::Place& place = body.map.place(name);
      middle_ = semantics::SemanticMap::center(place);
      if (place.origin == semantics::kSeen)
        answer_ = fmt::format("This is probably the {}, by what stands here.", name);
    }
    drive_.begin(body, nav::MoveTo{middle_, {}, kPlaceTolerance, 0.1});
  }
  std::optional<Outcome> update(Body& body) override {
    const auto moved = drive_.take();
    if (!moved) return {};
    if (moved->success || beside_) {
      Outcome outcome = outcome_of(*moved);
      if (moved->success) outcome.answer = answer_;
      return outcome;
    }
    if (moved->reason != nav::Reason::no_path && moved->reason != nav::Reason::blocked) return outcome_of(*moved);
    beside_ = true;
    const auto floor = body.reachable().best([&](Vec2 point) { return norm(point - middle_); });
    if (!floor) return outcome_of(*moved);
    drive_.begin(body, nav::MoveTo{*floor, {}, kPlaceTolerance, 0.1});
    return {};
  }
  void cancel() override { drive_.cancel(); }

 private:
  Vec2 middle_;
  std::string answer_;
  Drive drive_;
  bool beside_ = false;
};

// Whether the way straight on leads into a zone to keep out of: MoveForward follows no plan that avoids it.
bool leads_into_zone(const Body& body, double distance) {
  constexpr double kStep = 0.05;  // [m]
  const Pose2D at = body.robot.pose().map_from_base();
  const double radius = body.robot.profile().body.footprint.circumscribed_radius();
  const int steps = std::max(1, static_cast<int>(std::ceil(std::fabs(distance) / kStep)));
  return std::ranges::any_of(body.robot.zones(), [&](const map::Zone& zone) {
    if (zone.speed_limit) return false;
    for (int i = 1; i <= steps; ++i) {
      if (zone.distance_to((at * Pose2D{distance * i / steps, 0.0, 0.0}).position()) < radius) return true;
    }
    return false;
  });
}

class Waiting : public SkillRun {
 public:
  Waiting(const Body& body, double duration) : until_(body.robot.world().now() + from_seconds(duration)) {}
  std::optional<Outcome> update(Body& body) override {
    return body.robot.world().now() >= until_ ? std::optional(Outcome{"done"}) : std::nullopt;
  }

 private:
  Time until_;
};

// What needs no time.
class Saying : public SkillRun {
 public:
  explicit Saying(Outcome outcome) : outcome_(std::move(outcome)) {}
  std::optional<Outcome> update(Body&) override { return outcome_; }

 private:
  Outcome outcome_;
};

Outcome name_here(Body& body, const std::string& name) {
  body.map.name_place({.name = name, .polygon = {body.position()}});
  return {"done", {}, fmt::format("This is the {} now.", name)};
}

Outcome list_things(const Body& body, const std::string& place) {
  std::map<std::string, int> counts;
  for (const auto& thing : body.map.find({.kind = {}, .color = {}, .place = place})) {
    if (thing.kinds[thing.kind()] >= 0.5) ++counts[body.map.labels()[thing.kind()]];
  }
  std::vector<std::string> parts;
  for (const auto& [kind, count] : counts) parts.push_back(fmt::format("{} {}", count, kind));
  const std::string where = place.empty() ? "" : fmt::format(" in the {}", place);
  if (parts.empty()) return {"done", {}, fmt::format("I know of nothing{}.", where)};
  return {"done", {}, fmt::format("I know of {}{}.", fmt::join(parts, ", "), where), 0, true};
}

Outcome list_places(const Body& body) {
  std::vector<std::string> names{std::string(language::kStart)};
  for (const auto& place : body.map.places()) names.push_back(place.name);
  return {"done", {}, fmt::format("I know these places: {}.", fmt::join(names, ", "))};
}

Outcome answer(const Body& body, const Step& step) {
  if (step.about == "position") {
    const Vec2 at = body.position();
    std::string in;
    for (const auto& place : body.map.places()) {
      if (semantics::SemanticMap::contains(place, at)) in = fmt::format(", in the {}", place.name);
    }
    return {"done", {}, fmt::format("I am at ({:.1f}, {:.1f}){}.", at.x, at.y, in)};
  }
  const auto found = things_meant(body, step.thing);
  const std::string meant = in_words(step.thing);
  if (step.about == "count")
    return {"done", {}, fmt::format("I know of {}: {}.", found.size(), meant), 0, !found.empty()};
  if (found.empty()) {
    if (step.about == "where") return {"not_found", fmt::format("it has seen no {}", meant)};
    return {"done", {}, sentence(fmt::format("no {} was seen", meant))};
  }
  const std::string seen = in_words(body, found.front());
  return {"done", {}, sentence(step.about == "where" ? "the " + seen : "yes, a " + seen), found.front().id, true};
}

// Where a place is meant that users have not given, one that is probably so by what stands there is taken for it.
void look_up_place(Body& body, const std::string& name) {
  const auto known = std::ranges::find(body.map.places(), name, &semantics::Place::name);
  if (name.empty() || name == language::kStart) return;
  if (known != body.map.places().end() && known->origin != semantics::kSeen) return;
  if (auto probable = semantics::probable_place(body.map, name)) body.map.name_place(std::move(*probable));
}

}  // namespace

bool needs_camera(const Body& body, const Step& step) {
  switch (step.skill) {
    case Skill::approach:
    case Skill::search:
    case Skill::look:
    case Skill::list_things: return true;
    case Skill::answer: return step.about != "position";
    case Skill::follow: return names_things(body, step.route);
    default: return false;
  }
}

std::unique_ptr<SkillRun> begin_skill(Body& body, const Step& step) {
  look_up_place(body, step.place);
  look_up_place(body, step.thing.place);
  const auto saying = [](Outcome outcome) { return std::make_unique<Saying>(std::move(outcome)); };
  switch (step.skill) {
    case Skill::move_to_place: return std::make_unique<ToPlace>(body, step.place);
    case Skill::approach:
    case Skill::search: {
      (void)things_meant(body, step.thing);  // that its words are known
      return begin_search(step.thing);
    }
    case Skill::move_to:
      return std::make_unique<Moving>(body, nav::MoveTo{{step.x.value(), step.y.value()}, step.theta, 0.25, 0.1});
    case Skill::move_forward:
      if (leads_into_zone(body, step.distance.value()))
        return saying({"refused", "the way straight on leads into a zone to keep out of"});
      return std::make_unique<Moving>(body, nav::MoveForward{step.distance.value(), 0.05});
    case Skill::rotate: return std::make_unique<Moving>(body, nav::Rotate{step.angle.value(), 0.1});
    case Skill::explore:
      if (!step.place.empty()) return std::make_unique<ToPlace>(body, step.place);
      return std::make_unique<Moving>(body, nav::Explore{});
    case Skill::look: return std::make_unique<Moving>(body, nav::Rotate{2.0 * std::numbers::pi, 0.2});
    case Skill::list_things: return saying(list_things(body, step.place));
    case Skill::list_places: return saying(list_places(body));
    case Skill::name_place: return saying(name_here(body, step.name));
    case Skill::answer: return saying(answer(body, step));
    case Skill::wait: return std::make_unique<Waiting>(body, step.duration.value());
    case Skill::done: return saying({"done"});
    case Skill::follow: break;
  }
  try {
    return begin_route(body, step.route);
  } catch (const language::UnknownRoom& error) {
    return saying({"not_found", error.what()});
  } catch (const ConfigError& error) {
    return saying({"not_understood", error.what()});
  }
}

}  // namespace threewe::agent
