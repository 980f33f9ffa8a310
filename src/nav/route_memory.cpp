#include "nav/route_memory.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include "nav/polyline.hpp"

namespace threewe::nav {

RouteMemory::RouteMemory(const Params& params)
    : same_place_(params.recovery.same_place),
      driven_spacing_(params.route.driven_spacing),
      attempts_(params.route.attempts) {}

void RouteMemory::clear() {
  entries_.clear();
  movers_.clear();
}

void RouteMemory::note(Outcome outcome, Vec2 place) { entries_.push_back({place, outcome}); }

void RouteMemory::avoid(Outcome outcome, Vec2 place) { entries_.push_back({place, outcome, Avoided::yes}); }

void RouteMemory::note_tried(Vec2 place, Time until) {
  entries_.push_back({place, Outcome::tried, Avoided::no, until});
}

void RouteMemory::note_driven(Vec2 robot) {
  const auto last = std::ranges::find(std::views::reverse(entries_), Outcome::driven, &Entry::outcome);
  const bool is_new = last == entries_.rend() || distance(last->place, robot) > driven_spacing_;
  if (is_new) note(Outcome::driven, robot);
}

void RouteMemory::forget(Outcome outcome, Vec2 place) {
  const auto is_same = near(place, same_place_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.outcome == outcome && is_same(entry.place); });
}

std::vector<Vec2> RouteMemory::places(Outcome outcome) const {
  std::vector<Vec2> places;
  for (const Entry& entry : entries_) {
    if (entry.outcome == outcome) places.push_back(entry.place);
  }
  return places;
}

bool RouteMemory::has(Outcome outcome) const {
  return std::ranges::find(entries_, outcome, &Entry::outcome) != entries_.end();
}

bool RouteMemory::has(Outcome outcome, Vec2 place) const {
  return std::ranges::any_of(places(outcome), near(place, same_place_));
}

bool RouteMemory::failed_often(Vec2 place) const {
  return std::ranges::count_if(places(Outcome::failed), near(place, same_place_)) >= attempts_;
}

bool RouteMemory::has_driven(Vec2 place) const {
  return std::ranges::any_of(places(Outcome::driven), near(place, 2.0 * driven_spacing_));
}

std::optional<Time> RouteMemory::tried_until(Vec2 place) const {
  const auto is_same = near(place, same_place_);
  const auto found = std::ranges::find_if(
      entries_, [&](const Entry& entry) { return entry.outcome == Outcome::tried && is_same(entry.place); });
  return found == entries_.end() ? std::nullopt : std::optional(found->until);
}

std::vector<Vec2> RouteMemory::obstacles() const {
  std::vector<Vec2> places;
  for (const Entry& entry : entries_) {
    if (entry.avoided == Avoided::yes || entry.outcome == Outcome::barred) places.push_back(entry.place);
  }
  return places;
}

bool RouteMemory::avoids_any() const {
  return std::ranges::find(entries_, Avoided::yes, &Entry::avoided) != entries_.end();
}

void RouteMemory::stop_avoiding() {
  for (Entry& entry : entries_) entry.avoided = Avoided::no;
}

void RouteMemory::stop_avoiding(Vec2 place) {
  const auto is_same = near(place, same_place_);
  for (Entry& entry : entries_) {
    if (is_same(entry.place)) entry.avoided = Avoided::no;
  }
}

void RouteMemory::suspend_avoiding() {
  for (Entry& entry : entries_) {
    if (entry.avoided == Avoided::suspended) entry.avoided = Avoided::no;  // that was never resumed
    if (entry.avoided == Avoided::yes && !failed_often(entry.place)) entry.avoided = Avoided::suspended;
  }
}

void RouteMemory::resume_avoiding() {
  for (Entry& entry : entries_) {
    if (entry.avoided == Avoided::suspended) entry.avoided = Avoided::yes;
  }
}

// Where it has come by may still be marked in the map: a trail of places, the newest of which follows it.
void RouteMemory::note_mover(Mover mover) {
  constexpr std::size_t kMost = 256;
  const auto is_it = [&](const Mover& m) { return m.name == mover.name; };
  const auto newest = std::find_if(movers_.rbegin(), movers_.rend(), is_it);
  const auto before = newest == movers_.rend() ? newest : std::find_if(newest + 1, movers_.rend(), is_it);
  if (newest != movers_.rend()) remember_free(mover, newest->free_around);
  if (before != movers_.rend() && distance(newest->position, before->position) < 0.5 * mover.radius) {
    *newest = std::move(mover);
    return;
  }
  if (movers_.size() == kMost) movers_.erase(movers_.begin());
  movers_.push_back(std::move(mover));
}

}  // namespace threewe::nav
