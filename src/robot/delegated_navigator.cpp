#include "robot/delegated_navigator.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "nav/planner.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

using Driver = backend::ExternalNavigator;

nav::Reason reason_of(Driver::Outcome outcome) {
  switch (outcome) {
    case Driver::Outcome::running: return nav::Reason::running;
    case Driver::Outcome::reached: return nav::Reason::reached;
    case Driver::Outcome::no_path: return nav::Reason::no_path;
    case Driver::Outcome::blocked: return nav::Reason::blocked;
    case Driver::Outcome::timeout: return nav::Reason::timeout;
    case Driver::Outcome::cancelled: return nav::Reason::cancelled;
    case Driver::Outcome::lost: return nav::Reason::lost;
    case Driver::Outcome::fault: return nav::Reason::fault;
  }
  return nav::Reason::fault;
}

double heading(Vec2 from, Vec2 to) { return exact::atan2(to.y - from.y, to.x - from.x); }

class DelegatedNavigator final : public nav::Navigator {
 public:
  DelegatedNavigator(std::string program, Driver& driver, std::unique_ptr<nav::Navigator> own)
      : program_(std::move(program)), driver_(&driver), own_(std::move(own)) {}
  DelegatedNavigator(const DelegatedNavigator& other)
      : program_(other.program_),
        driver_(other.driver_),
        own_(other.own_->clone()),
        delegates_(other.delegates_),
        progress_(other.progress_),
        way_(other.way_),
        waypoints_(other.waypoints_),
        before_(other.before_) {}
  DelegatedNavigator& operator=(const DelegatedNavigator&) = delete;

  void start(const nav::Goal& goal, const nav::Observation& observation) override {
    const Pose2D here = observation.pose.map_from_base();
    way_ = {here.position()};
    Driver::Goal wanted;
    if (const auto* move = std::get_if<nav::MoveTo>(&goal)) {
      way_.push_back(move->goal);
      // it wants a heading in any case: that in which it comes straight from here
      const double theta = move->theta.value_or(heading(here.position(), move->goal));
      wanted.path = {{move->goal.x, move->goal.y, theta}};
    } else if (const auto* follow = std::get_if<nav::FollowPath>(&goal)) {
      way_.insert(way_.end(), follow->path.begin(), follow->path.end());
      wanted.way = Driver::Way::along_path;
      for (std::size_t i = 0; i < way_.size(); ++i) {
        const std::size_t from = std::min(i, way_.size() - 2);
        wanted.path.push_back({way_[i].x, way_[i].y, heading(way_[from], way_[from + 1])});
      }
    } else if (const auto* visit = std::get_if<nav::FollowWaypoints>(&goal)) {
      wanted.way = Driver::Way::to_waypoints;
      for (const nav::MoveTo& place : visit->waypoints) {
        const double theta = place.theta.value_or(heading(way_.back(), place.goal));
        wanted.path.push_back({place.goal.x, place.goal.y, theta});
        way_.push_back(place.goal);
      }
    } else {
      delegates_ = false;
      return own_->start(goal, observation);
    }
    delegates_ = true;
    waypoints_.clear();
    if (wanted.way == Driver::Way::to_waypoints) waypoints_.assign(way_.begin() + 1, way_.end());
    progress_ = {.distance_left = nav::path_length(way_), .pose = here};
    before_ = observation.pose.odom_from_base.position();
    driver_->start(wanted);
  }

  nav::Decision step(const nav::Observation& observation) override {
    if (!delegates_) return own_->step(observation);
    const Vec2 here = observation.pose.odom_from_base.position();
    progress_.pose = observation.pose.map_from_base();
    progress_.distance_driven += distance(std::exchange(before_, here), here);
    const Driver::Report report = driver_->report();
    // none before its first plan
    if (report.distance_left > 0.0) progress_.distance_left = report.distance_left;
    progress_.time_left = report.time_left;
    if (report.waypoint < waypoints_.size()) progress_.distance_left = left_from(report.waypoint);
    if (report.plan && !report.plan->empty()) way_ = *report.plan;
    return {.velocity = {}, .reason = reason_of(report.outcome), .detail = report.detail};
  }

  void end() override {
    if (std::exchange(delegates_, false)) driver_->cancel();
    way_.clear();
  }
  bool drives_past_the_gate() const override { return delegates_; }

  nav::Progress progress() const override { return delegates_ ? progress_ : own_->progress(); }
  std::span<const Vec2> path() const override { return delegates_ ? std::span<const Vec2>(way_) : own_->path(); }
  std::optional<nav::SampledPlan> plan() const override { return delegates_ ? std::nullopt : own_->plan(); }
  std::unique_ptr<Navigator> clone() const override { return std::make_unique<DelegatedNavigator>(*this); }
  void set_zones(const std::vector<map::Zone>& zones) override {
    if (!zones.empty()) {
      throw ContractError(
          fmt::format("zones: '{}' plans by its own costmaps; set keep-out zones and speed limits there", program_));
    }
    own_->set_zones(zones);
  }

  perception::SensorHealth health() const {
    perception::SensorHealth health;
    health.name = program_;
    health.detail = driver_->trouble();
    if (!health.detail.empty()) health.fault = perception::SensorFault::silent;
    return health;
  }

 private:
  /// [m] in straight lines, as the program says no more than which waypoint it drives to.
  double left_from(std::size_t waypoint) const {
    const std::span<const Vec2> ahead = std::span(waypoints_).subspan(waypoint);
    return distance(progress_.pose.position(), ahead.front()) + nav::path_length(ahead);
  }

  std::string program_;
  Driver* driver_;
  std::unique_ptr<nav::Navigator> own_;
  bool delegates_ = false;
  nav::Progress progress_;
  std::vector<Vec2> way_;        // in `map`: the newest plan, or what was asked for
  std::vector<Vec2> waypoints_;  // in `map`; empty for another goal
  Vec2 before_;                  // in `odom`, a period ago
};

}  // namespace

std::unique_ptr<nav::Navigator> make_delegated_navigator(std::string program, Driver& driver,
                                                         std::unique_ptr<nav::Navigator> own) {
  return std::make_unique<DelegatedNavigator>(std::move(program), driver, std::move(own));
}

std::optional<perception::SensorHealth> program_health(const nav::Navigator& navigator) {
  const auto* delegated = dynamic_cast<const DelegatedNavigator*>(&navigator);
  return delegated == nullptr ? std::nullopt : std::optional(delegated->health());
}

}  // namespace threewe
