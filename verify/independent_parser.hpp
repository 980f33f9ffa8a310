// Independent parser of instructions, with rules of its own: none of the library's reading of texts, of rooms and
// doors, or of places is used, so that an instruction is clear to more than those who made it.
//
// Where a text leaves a choice the parser takes the nearest; what is passed on the way is not looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "language/vocabulary.hpp"
#include "scene/scene_tables.hpp"

namespace threewe {

class IndependentParser {
 public:
  IndependentParser(const scene::SceneTables& tables, const language::Language& language)
      : tables_(tables), scene_(tables.scene()), language_(language) {}

  /// Where a text leads from a start; nothing where the parser is lost.
  std::optional<Vec2> follow(const std::string& text, const Pose2D& start) {
    at_ = start.position();
    facing_ = rotate({1.0, 0.0}, start.theta);
    room_ = scene_.room_at(at_);
    came_by_.reset();
    for (const Words& clause : clauses(text)) {
      if (room_ == nullptr) return std::nullopt;
      if (clause[0] == "stop" || clause[0] == "wait") return stop(clause);
      if (!walk(clause)) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  using Words = std::vector<std::string>;

  // A clause is a verb and what follows it.
  static std::vector<Words> clauses(const std::string& text) {
    static const Words kVerbs = {"turn", "go",    "walk",  "continue", "head", "pass",
                                 "take", "enter", "leave", "exit",     "stop", "wait"};
    std::vector<Words> all;
    for (const std::string& word : language::words_of(text)) {
      if (std::ranges::find(kVerbs, word) != kVerbs.end()) all.emplace_back();
      if (!all.empty() && word != "and" && word != "then") all.back().push_back(word);
    }
    return all;
  }

  static bool says(const Words& clause, const std::string& phrase) { return place_of(clause, phrase).has_value(); }

  // The index after a phrase in a clause.
  static std::optional<std::size_t> place_of(const Words& clause, const std::string& phrase, std::size_t from = 0) {
    const Words wanted = language::words_of(phrase);
    const auto found =
        std::search(clause.begin() + static_cast<std::ptrdiff_t>(from), clause.end(), wanted.begin(), wanted.end());
    if (found == clause.end()) return std::nullopt;
    return static_cast<std::size_t>(found - clause.begin()) + wanted.size();
  }

  bool walk(const Words& clause) {
    if (clause[0] == "turn") {
      if (says(clause, "left")) facing_ = {-facing_.y, facing_.x};
      if (says(clause, "right")) facing_ = {facing_.y, -facing_.x};
      if (says(clause, "around")) facing_ = -1.0 * facing_;
      return true;
    }
    if (clause[0] == "pass" || says(clause, "past")) return true;
    if (says(clause, "door") || says(clause, "doorway")) return walk_through(clause);
    if (says(clause, "straight ahead")) return true;
    if (clause[0] == "enter" || says(clause, "into")) return walk_into(room_named(clause));
    const scene::Object* thing = thing_named(clause);
    if (thing == nullptr) return false;
    facing_ = (1.0 / std::max(distance(at_, thing->pose.position()), 1e-9)) * (thing->pose.position() - at_);
    at_ = thing->pose.position();
    return true;
  }

  // The longest name of a room that is said after "into", or else after "enter".
  const scene::Room* room_named(const Words& clause) const {
    const auto after = place_of(clause, "into");
    if (!after && (clause[0] == "leave" || clause[0] == "exit")) return nullptr;
    const scene::Room* longest = nullptr;
    for (const scene::Room& room : scene_.rooms) {
      const bool said = place_of(clause, language_.room(room.name), after.value_or(0)).has_value();
      if (said && (longest == nullptr || room.name.size() > longest->name.size())) longest = &room;
    }
    return longest;
  }

  // The axis that the parser looks along, more or less.
  Vec2 axis() const {
    if (std::fabs(facing_.x) > std::fabs(facing_.y)) return {facing_.x > 0.0 ? 1.0 : -1.0, 0.0};
    return {0.0, facing_.y > 0.0 ? 1.0 : -1.0};
  }

  // The direction in which a door leads out of the room, if it is one of its doors.
  std::optional<Vec2> out_by(const scene::Door& door) const {
    for (const Vec2 way : {Vec2{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}) {
      const bool inside = scene_.room_at(door.center - 0.4 * way) == room_;
      const scene::Room* beyond = scene_.room_at(door.center + 0.4 * way);
      if (inside && beyond != nullptr && beyond != room_) return way;
    }
    return std::nullopt;
  }

  bool walk_through(const Words& clause) {
    const scene::Room* into = room_named(clause);
    struct Choice {
      double ahead;
      double far;
      const scene::Door* door;
      Vec2 out;
    };
    std::vector<Choice> choices;
    for (const scene::Door& door : scene_.doors) {
      const auto out = out_by(door);
      if (!out || came_by_ == &door) continue;
      const double left = cross(axis(), *out);
      if (says(clause, "on your left") && left < 0.5) continue;
      if (says(clause, "on your right") && left > -0.5) continue;
      if ((says(clause, "straight ahead") || says(clause, "ahead of you")) && dot(axis(), *out) < 0.5) continue;
      if (says(clause, "behind you") && dot(axis(), *out) > -0.5) continue;
      choices.push_back({dot(axis(), door.center - at_), distance(door.center, at_), &door, *out});
    }
    const auto nth = number(clause);
    if (nth) {
      std::erase_if(choices, [](const Choice& c) { return c.ahead < 0.0; });
      std::ranges::sort(choices, {}, &Choice::ahead);
      if (choices.size() <= *nth) return false;
      choices = {choices[*nth]};
    }
    if (into != nullptr) {
      std::erase_if(choices, [&](const Choice& c) { return scene_.room_at(c.door->center + 0.4 * c.out) != into; });
    }
    if (choices.empty()) return false;
    const Choice chosen = *std::ranges::min_element(choices, {}, &Choice::far);
    at_ = chosen.door->center;
    facing_ = chosen.out;
    room_ = scene_.room_at(at_ + 0.4 * chosen.out);
    came_by_ = chosen.door;
    return true;
  }

  // By the nearest door that leads there; where there is none, straight over the border.
  bool walk_into(const scene::Room* into) {
    if (into == nullptr) return false;
    const scene::Door* nearest = nullptr;
    for (const scene::Door& door : scene_.doors) {
      const auto out = out_by(door);
      if (!out || scene_.room_at(door.center + 0.4 * *out) != into) continue;
      if (nearest == nullptr || distance(door.center, at_) < distance(nearest->center, at_)) nearest = &door;
    }
    if (nearest != nullptr) {
      facing_ = *out_by(*nearest);
      at_ = nearest->center;
    } else {
      const Vec2 border{std::clamp(at_.x, into->min.x, into->max.x), std::clamp(at_.y, into->min.y, into->max.y)};
      const Vec2 over = border - at_;
      facing_ = std::fabs(over.x) > std::fabs(over.y) ? Vec2{over.x > 0.0 ? 1.0 : -1.0, 0.0}
                                                      : Vec2{0.0, over.y > 0.0 ? 1.0 : -1.0};
      at_ = border;
    }
    came_by_ = nearest;
    room_ = into;
    return true;
  }

  static std::optional<std::size_t> number(const Words& clause) {
    const Words ordinals = {"first", "second", "third", "fourth"};
    for (std::size_t i = 0; i < ordinals.size(); ++i) {
      if (says(clause, ordinals[i])) return i;
    }
    return std::nullopt;
  }

  bool is_called(const scene::Object& object, const Words& clause, std::size_t from, std::size_t& length) const {
    for (const std::string& name : {language_.thing(object.category, object.shape), language_.thing(object.category)}) {
      if (!place_of(clause, name, from) || name.size() < length) continue;
      length = name.size();
      return true;
    }
    return false;
  }

  // The thing in the room that a clause names.
  const scene::Object* thing_named(const Words& clause) const {
    // what comes after "next to the" is another thing, unless one stops there
    const std::size_t begin = clause[0] == "stop" || clause[0] == "wait" ? place_of(clause, "the").value_or(0) : 0;
    const auto neighbour = place_of(clause, "next to the", begin);
    Words own = clause;
    if (neighbour) own.resize(*neighbour - 3);
    std::size_t longest = 0;
    std::vector<const scene::Object*> named = all_called(own, 0, longest);
    if (neighbour) {
      std::size_t other = 0;
      const auto others = all_called(clause, *neighbour, other);
      const auto to_other = [&](const scene::Object* o) {
        double least = std::numeric_limits<double>::infinity();
        for (const scene::Object* n : others) {
          if (n != o) least = std::min(least, distance(n->pose.position(), o->pose.position()));
        }
        return least;
      };
      if (!named.empty() && !others.empty()) return *std::ranges::min_element(named, {}, to_other);
    }
    const auto left = [&](const scene::Object* o) { return cross(axis(), o->pose.position() - at_); };
    const auto ahead = [&](const scene::Object* o) { return dot(axis(), o->pose.position() - at_); };
    const auto far = [&](const scene::Object* o) { return distance(o->pose.position(), at_); };
    if (says(own, "on your left")) std::erase_if(named, [&](const auto* o) { return left(o) <= 0.0; });
    if (says(own, "on your right")) std::erase_if(named, [&](const auto* o) { return left(o) >= 0.0; });
    if (const auto nth = number(own)) {
      std::erase_if(named, [&](const auto* o) { return ahead(o) < 0.0; });
      std::ranges::sort(named, {}, ahead);
      return named.size() > *nth ? named[*nth] : nullptr;
    }
    if (named.empty()) return nullptr;
    return says(own, "farthest") ? *std::ranges::max_element(named, {}, far)
                                 : *std::ranges::min_element(named, {}, far);
  }

  // Those in the room with the longest of the names that are said.
  std::vector<const scene::Object*> all_called(const Words& clause, std::size_t from, std::size_t& longest) const {
    std::vector<const scene::Object*> found;
    for (const scene::Object& object : scene_.objects) {
      if (scene_.room_at(object.pose.position()) != room_ || object.category == "door") continue;
      const std::size_t before = longest;
      if (!is_called(object, clause, from, longest)) continue;
      if (longest > before) found.clear();
      found.push_back(&object);
    }
    return found;
  }

  std::optional<Vec2> stop(const Words& clause) const {
    if (says(clause, "in the middle of")) return standing_near(0.5 * (room_->min + room_->max));
    if (says(clause, "just inside")) return standing_near(at_ + 0.7 * facing_);
    const scene::Object* thing = thing_named(clause);
    if (thing == nullptr) return std::nullopt;
    // up to it from here, until it is half a metre away
    const auto near = [&](Vec2 p) {
      return std::ranges::any_of(thing->prisms, [&](const scene::Prism& prism) {
        return distance_to(solid_of(prism, thing->pose, 0), p) <= 0.5;
      });
    };
    std::optional<Vec2> best;
    for (const std::size_t cell : tables_.roomy()) {
      const Vec2 middle = tables_.passable().frame.center(tables_.passable().frame.cell(cell));
      if (distance(middle, thing->pose.position()) > 2.5 || !near(middle) || scene_.room_at(middle) != room_) continue;
      if (!best || distance(middle, at_) < distance(*best, at_)) best = middle;
    }
    return best;
  }

  std::optional<Vec2> standing_near(Vec2 point) const {
    const auto& frame = tables_.passable().frame;
    std::optional<Vec2> best;
    for (const std::size_t cell : tables_.roomy()) {
      const Vec2 middle = frame.center(frame.cell(cell));
      if (scene_.room_at(middle) == room_ && (!best || distance(middle, point) < distance(*best, point))) best = middle;
    }
    return best;
  }

  const scene::SceneTables& tables_;
  const scene::Scene& scene_;
  const language::Language& language_;
  Vec2 at_;
  Vec2 facing_;
  const scene::Room* room_ = nullptr;
  std::optional<const scene::Door*> came_by_;
};

}  // namespace threewe
