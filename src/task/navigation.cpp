#include "threewe/task/tasks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "task/contact_count.hpp"
#include "task/draws.hpp"
#include "task/goal_pool.hpp"
#include "task/stop_metrics.hpp"
#include "task/stop_task.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

static_assert(NavigationOptions{}.detours == scene::kDetourShare, "as of scene::sample_episode");

constexpr double kStepCost = 0.01;
constexpr double kContactCost = 10.0;        // of one that ends the episode
constexpr double kCountedContactCost = 0.1;  // of one that does not
constexpr std::uint64_t kPoolSeed = 0x3e;    // the pools are part of the task
constexpr double kFarthestGoal = 1000.0;     // [m] a goal can be believed to lie

// `inverse(a_from_b) * point_in_a`: both turn by the same angle, but where that is half a turn.
Vec2 as_seen_from(const Pose2D& a_from_b, Vec2 point_in_a) {
  const double turn = -a_from_b.theta;
  if (wrap_angle(turn) != turn) return inverse(a_from_b) * point_in_a;
  const auto [s, c] = exact::sincos(turn);
  const auto rotated = [s, c](Vec2 v) { return Vec2{c * v.x - s * v.y, s * v.x + c * v.y}; };
  return rotated({-a_from_b.x, -a_from_b.y}) + rotated(point_in_a);
}

// One robot's episode.
struct Trip {
  std::shared_ptr<const DistanceField> field;
  Vec2 goal_in_map;
  double shortest = 0.0;  // [m], from the start
  double left = 0.0;      // [m] of the shortest path, now
  double driven = 0.0;    // [m]
  double contact = 0.0;   // [m/s], the fastest
  bool success = false;
  bool over = false;
  std::size_t scene = 0;
  StopState stop;
  ContactCount contacts;
};

class Navigation final : public Task {
 public:
  Navigation(const TaskContext& context, const NavigationOptions& options)
      : options_(options),
        scenes_(context.scenes),
        robots_(context.robots),
        period_(context.period),
        trips_(context.worlds * robots_) {
    for (const auto& scene : scenes_) pools_.emplace_back(scene, options.goals, kPoolSeed);
  }

  std::vector<Field> fields() const override {
    return {{"goal", Field::Type::float32, {2}, -kFarthestGoal, kFarthestGoal}};
  }
  bool reads_scan() const override { return false; }
  std::vector<std::string> metrics() const override {
    std::vector<std::string> names = {"success",       "spl",         "distance_to_goal",
                                      "shortest_path", "path_length", "collision_speed"};
    if (options_.stop) names.emplace_back("stopped");
    if (!options_.contact_ends) names.emplace_back("contacts");
    return names;
  }

  void begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
             std::span<Pose2D> starts) override;
  void step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) override;
  void observe(std::size_t world, std::size_t robot, const Belief& belief,
               std::span<const std::span<std::byte>> fields) override;
  void measure(std::size_t world, std::span<double> metrics) const override;
  DebugOverlay debug_overlay(std::size_t world) const override;

 private:
  std::shared_ptr<const DistanceField> choose_trip(const EpisodeKey& key, const EpisodeRequest& request,
                                                   std::span<Pose2D> starts, std::size_t robot, Draws& draws) const;
  bool choose_start(const scene::SceneTables& tables, const DistanceField& field, bool detour, std::span<Pose2D> starts,
                    std::size_t robot, Draws& draws) const;
  Outcome judge(Trip& trip, const TaskState& now, double before) const;
  bool count_contacts(Trip& trip, const Pose2D& pose) const;

  NavigationOptions options_;
  Scenes scenes_;
  std::size_t robots_;
  Duration period_;
  std::vector<GoalPool> pools_;  // by scene
  std::vector<Trip> trips_;      // by world and robot
};

void Navigation::begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
                       std::span<Pose2D> starts) {
  for (std::size_t robot = 0; robot < robots_; ++robot) {
    Draws draws(key, robot);
    const std::shared_ptr<const DistanceField> field = choose_trip(key, request, starts, robot, draws);
    const double shortest = field->length_from(starts[robot].position());
    trips_[world * robots_ + robot] = {
        .field = field,
        .goal_in_map = inverse(starts[0]) * field->target(),
        .shortest = shortest,
        .left = shortest,
        .scene = key.scene,
        .stop = {},
        .contacts = {},
    };
  }
}

// Fills in the start, returns the way to the goal.
std::shared_ptr<const DistanceField> Navigation::choose_trip(const EpisodeKey& key, const EpisodeRequest& request,
                                                             std::span<Pose2D> starts, std::size_t robot,
                                                             Draws& draws) const {
  constexpr int kGoalTries = 64;  // a goal may have no start at the right distance
  const bool detour = draws.uniform() < options_.detours;
  const bool first = robot == 0;
  for (int i = 0; i < (first && request.goal ? 1 : kGoalTries); ++i) {
    auto field = first && request.goal ? pools_[key.scene].field_to(*request.goal)
                                       : pools_[key.scene].field(draws.index(options_.goals));
    if (first && request.start) {
      starts[0] = *request.start;
      if (std::isfinite(field->length_from(starts[0].position()))) return field;
    } else if (choose_start(*scenes_[key.scene], *field, detour, starts, robot, draws)) {
      return field;
    }
  }
  throw ConfigError(fmt::format("scene '{}' has no such episode: a path of {} to {} m{}{}",
                                scenes_[key.scene]->scene().name, options_.shortest, options_.longest,
                                request.start ? fmt::format(" from ({}, {})", request.start->x, request.start->y) : "",
                                request.goal ? fmt::format(" to ({}, {})", request.goal->x, request.goal->y) : ""));
}

bool Navigation::choose_start(const scene::SceneTables& tables, const DistanceField& field, bool detour,
                              std::span<Pose2D> starts, std::size_t robot, Draws& draws) const {
  constexpr int kTries = 100;  // with, and as many without, the wish for a detour
  const double apart = 2.0 * tables.footprint().circumscribed_radius() + 0.1;
  for (int i = 0; i < 2 * kTries; ++i) {
    const Pose2D start = draws.roomy_pose(tables);
    const double length = field.length_from(start.position());
    if (length < options_.shortest || length > options_.longest) continue;
    const bool is_detour = length > scene::kDetour * distance(start.position(), field.target());
    if (is_detour != detour && (i < kTries || options_.detours == 0.0)) continue;
    const auto near = [&](const Pose2D& other) { return distance(other.position(), start.position()) < apart; };
    if (std::ranges::any_of(starts.first(robot), near)) continue;
    starts[robot] = start;
    return true;
  }
  return false;
}

void Navigation::step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) {
  for (std::size_t robot = 0; robot < robots_; ++robot) {
    Trip& trip = trips_[world * robots_ + robot];
    outcomes[robot] = {};
    if (trip.over) continue;
    const TaskState& now = robots[robot];
    const double length = trip.field->length_from(now.pose.position());
    const double before = trip.left;
    if (std::isfinite(length)) trip.left = length;  // squeezed against something it is as far as it was
    trip.driven = now.distance_driven;
    trip.contact = now.max_collision_speed;
    outcomes[robot] = judge(trip, now, before);
  }
}

Outcome Navigation::judge(Trip& trip, const TaskState& now, double before) const {
  const bool failed = options_.contact_ends && trip.contact > options_.contact_speed;
  if (options_.stop) trip.stop = advance(trip.stop, asked(now), period_);
  const bool stopped = options_.stop && says_stop(trip.stop);
  trip.success = !failed && trip.left <= options_.success_distance && (stopped || !options_.stop);
  trip.over = trip.success || failed || stopped;

  Outcome outcome;
  outcome.reward =
      before - trip.left - kStepCost + (trip.success ? kSuccessReward : 0.0) - (failed ? kContactCost : 0.0);
  if (!options_.contact_ends && count_contacts(trip, now.pose)) outcome.reward -= kCountedContactCost;
  outcome.terminated = trip.over;
  return outcome;
}

// Whether there is one more.
bool Navigation::count_contacts(Trip& trip, const Pose2D& pose) const {
  const int before = trip.contacts.contacts;
  trip.contacts = advance(trip.contacts, scenes_[trip.scene]->clearance(pose));
  return trip.contacts.contacts > before;
}

void Navigation::observe(std::size_t world, std::size_t robot, const Belief& belief,
                         std::span<const std::span<std::byte>> fields) {
  if (fields[0].empty()) return;
  const Trip& trip = trips_[world * robots_ + robot];
  const Vec2 goal = options_.goal_in_map ? trip.goal_in_map : as_seen_from(belief.map_from_base, trip.goal_in_map);
  const std::array<float, 2> seen{static_cast<float>(goal.x), static_cast<float>(goal.y)};
  std::memcpy(fields[0].data(), seen.data(), sizeof(seen));
}

void Navigation::measure(std::size_t world, std::span<double> metrics) const {
  auto to = metrics.begin();
  for (const Trip& trip : std::span(trips_).subspan(world * robots_, robots_)) {
    const double spl = success_weighted_by_path_length(trip.success, trip.shortest, trip.driven);
    const std::array<double, 6> values{
        trip.success ? 1.0 : 0.0, spl, trip.left, trip.shortest, trip.driven, trip.contact};
    to = std::ranges::copy(values, to).out;
    if (options_.stop) *to++ = says_stop(trip.stop) ? 1.0 : 0.0;
    if (!options_.contact_ends) *to++ = trip.contacts.contacts;
  }
}

DebugOverlay Navigation::debug_overlay(std::size_t world) const {
  DebugOverlay debug_overlay;
  for (const Trip& trip : std::span(trips_).subspan(world * robots_, robots_)) {
    debug_overlay.goals.push_back(trip.field->target());
  }
  return debug_overlay;
}

}  // namespace

GoalPool::GoalPool(std::shared_ptr<const scene::SceneTables> tables, std::size_t goals, std::uint64_t seed)
    : tables_(std::move(tables)) {
  Draws draws({.seed = seed}, 0);
  for (std::size_t i = 0; i < goals; ++i) {
    goals_.push_back(std::make_unique<Goal>());
    goals_.back()->target = draws.roomy_pose(*tables_).position();
  }
}

std::shared_ptr<const DistanceField> GoalPool::field(std::size_t goal) const {
  Goal& chosen = *goals_[goal];
  std::call_once(chosen.found, [&] { chosen.field = std::make_shared<DistanceField>(*tables_, chosen.target); });
  return chosen.field;
}

std::shared_ptr<const DistanceField> GoalPool::field_to(Vec2 target) const {
  const auto known = std::ranges::find_if(goals_, [&](const auto& goal) { return goal->target == target; });
  if (known == goals_.end()) return std::make_shared<DistanceField>(*tables_, target);
  return field(static_cast<std::size_t>(known - goals_.begin()));
}

std::unique_ptr<Task> make_navigation(const TaskContext& context, const NavigationOptions& options) {
  return std::make_unique<Navigation>(context, options);
}

}  // namespace threewe::task
