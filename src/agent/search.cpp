// Search: drive to the most probable of the things that are known; look around; map what is unknown; look where the
// camera has not looked. What turns out to be something else on arrival is not tried again.
#include <numbers>

#include <fmt/format.h>

#include "agent/skills.hpp"
#include "core/exact.hpp"

namespace threewe::agent {
namespace {

constexpr double kBesides = 0.15;    // [m] from a thing's centre at least, where the robot stands to look at it
constexpr double kNear = 0.75;       // [m] of the thing, from where it is looked at
constexpr double kSure = 0.85;       // probability of the kind after a look from near by
constexpr std::uint64_t kLooks = 2;  // pictures from there, before it is judged
constexpr double kArrived = 1.6;     // [m] from its centre, that it may be away at most: large things are wide
constexpr int kMostViewpoints = 60;  // of one search
constexpr double kTolerance = 0.4;   // [m] of a viewpoint

class Search : public SkillRun {
 public:
  explicit Search(language::ThingPhrase thing) : thing_(std::move(thing)) {}

  std::optional<Outcome> update(Body& body) override {
    if (phase_ == Phase::approaching || phase_ == Phase::judging) return judge(body);
    const auto known = things_meant(body, thing_, tried_);
    if (!known.empty()) {
      drive_.cancel();
      approach(body, known.front());
      return {};
    }
    if (drive_.active()) {
      if (!drive_.take()) return {};
    }
    return go_on(body);
  }
  void cancel() override { drive_.cancel(); }

 private:
  enum class Phase : std::uint8_t { begun, to_place, turning, exploring, viewing, approaching, judging };

  // What comes next where nothing fit is known.
  std::optional<Outcome> go_on(Body& body) {
    if (phase_ == Phase::begun && !thing_.place.empty()) {
      phase_ = Phase::to_place;
      const auto& place = body.map.place(thing_.place);
      drive_.begin(body, nav::MoveTo{semantics::SemanticMap::center(place), {}, kTolerance, 0.1});
    } else if (phase_ == Phase::begun || phase_ == Phase::to_place) {
      phase_ = Phase::turning;
      drive_.begin(body, nav::Rotate{2.0 * std::numbers::pi, 0.2});
    } else if (phase_ == Phase::turning && thing_.place.empty()) {
      phase_ = Phase::exploring;
      drive_.begin(body, nav::Explore{});
    } else {
      phase_ = Phase::viewing;
      return view_next(body);
    }
    return {};
  }

  std::optional<Outcome> view_next(Body& body) {
    std::function<bool(Vec2)> area;
    if (!thing_.place.empty()) {
      const semantics::Place place = body.map.place(thing_.place);
      area = [place](Vec2 point) { return semantics::SemanticMap::contains(place, point); };
    }
    const auto viewpoint = body.coverage.next(body.robot.map(), body.reachable(), area);
    if (!viewpoint || ++viewpoints_ > kMostViewpoints)
      return Outcome{"not_found", fmt::format("there is no {} where it has looked", in_words(thing_))};
    body.coverage.add(viewpoint->shows);  // seen from there, or hidden: not to be gone to again
    drive_.begin(body, nav::MoveTo{viewpoint->stand, viewpoint->heading, kTolerance, 0.2});
    return {};
  }

  void approach(Body& body, const semantics::MappedThing& thing) {
    phase_ = Phase::approaching;
    target_ = thing.id;
    const auto& grid = body.robot.map();
    const Vec2 here = body.position();
    const auto stand = body.reachable().best([&](Vec2 point) {
      const double range = norm(point - thing.position);
      const double hidden =
          in_sight(grid, point, point + (1.0 - 0.45 / std::max(range, 0.5)) * (thing.position - point)) ? 0.0 : 1.0;
      return std::fabs(range - kNear) + hidden + 0.02 * norm(point - here) + (range < kBesides ? 10.0 : 0.0);
    });
    const Vec2 to = stand.value_or(thing.position);
    const Vec2 look = thing.position - to;
    if (stand && norm(*stand - thing.position) < 2.5) {
      drive_.begin(body, nav::MoveTo{to, exact::atan2(look.y, look.x), 0.25, 0.1});
    } else {  // what lies between is not known yet: as near as it gets
      drive_.begin(body, nav::MoveTo{thing.position, {}, kNear, 0.1});
    }
  }

  std::optional<Outcome> judge(Body& body) {
    const auto found = body.map.thing(target_);
    if (drive_.active()) {
      if (!found && phase_ == Phase::approaching) {  // forgotten on the way
        drive_.cancel();
        return give_up();
      }
      const auto moved = drive_.take();
      if (!moved) return {};
      if (phase_ == Phase::approaching) {
        phase_ = Phase::judging;
        if (found) {
          const double turn = wrap_angle(body.heading_to(found->position) - body.robot.pose().map_from_base().theta);
          drive_.begin(body, nav::Rotate{turn, 0.05});
        }
        judged_at_ = body.looks + kLooks;
        return {};
      }
      judged_at_ = body.looks + kLooks;
    }
    if (body.looks < judged_at_) return {};
    if (!found || found->misses > 0 || norm(found->position - body.position()) > kArrived) return give_up();
    if (!thing_.kind.empty() && found->kinds[index_of_kind(body)] < kSure) return give_up();
    return Outcome{"done", {}, fmt::format("There is a {}.", in_words(body, *found)), found->id, true};
  }

  std::optional<Outcome> give_up() {
    tried_.push_back(target_);
    phase_ = Phase::to_place;  // looks around here, then goes on
    if (thing_.place.empty() && viewpoints_ > 0) phase_ = Phase::viewing;
    return {};
  }

  std::size_t index_of_kind(const Body& body) const {
    const auto& labels = body.map.labels();
    return static_cast<std::size_t>(std::ranges::find(labels, thing_.kind) - labels.begin());
  }

  language::ThingPhrase thing_;
  Phase phase_ = Phase::begun;
  Drive drive_;
  std::uint64_t target_ = 0;
  std::uint64_t judged_at_ = 0;
  std::vector<std::uint64_t> tried_;
  int viewpoints_ = 0;
};

}  // namespace

std::unique_ptr<SkillRun> begin_search(const language::ThingPhrase& thing) { return std::make_unique<Search>(thing); }

}  // namespace threewe::agent
