#include "task/object_nav.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/exact.hpp"
#include "core/names.hpp"
#include "core/numbers.hpp"
#include "core/rng.hpp"
#include "task/sight.hpp"
#include "threewe/core/errors.hpp"
#include "view_bound.hpp"

namespace threewe::task {
namespace {

using scene::CellIndex;
using scene::GeodesicField;
using scene::GridFrame;
using scene::SceneTables;
using scene::Solid;

// Starts are drawn at random this often; then they are tried in turn, with headings a sixteenth of a turn apart.
constexpr std::uint64_t kStartTries = 256;
constexpr int kHeadings = 16;
constexpr std::uint64_t kSightTries = 1024;  // for one kind

// Places of success are looked for on every third cell both ways, through a camera of an eighth of the resolution, and
// twice the pixels and the share are asked for, and a shorter reach, which leaves room for what lies between.
constexpr int kLattice = 3;
constexpr int kCoarser = 8;
constexpr double kMargin = 2.0;
constexpr double kReachMargin = 0.1;  // [m]

std::vector<std::string> goal_names(std::span<const std::size_t> goals) {
  std::vector<std::string> names;
  for (const std::size_t goal : goals) names.emplace_back(kObjectGoals[goal]);
  return names;
}

Eye eye_of(const CameraSpec& camera, const Pose2D& base) {
  return {base * camera.base_from_camera, camera.mount_height};
}

// The same view with fewer pixels.
CameraIntrinsics coarse(const CameraIntrinsics& c) {
  constexpr double k = 1.0 / kCoarser;
  return {std::max(1, c.width / kCoarser), std::max(1, c.height / kCoarser), k * c.fx, k * c.fy, k * c.cx, k * c.cy};
}

// One thing of a goal's kind.
struct Instance {
  std::int16_t id = 0;  // in pictures
  std::vector<Solid> solids;
};

// Calls `visit(index)` for the cells, every `step`-th both ways, whose middle is at most `reach` from the instance.
template <typename Visit>
void cells_near(const GridFrame& frame, const Instance& instance, double reach, int step, Visit visit) {
  const auto [low, high] = bounds(instance.solids);
  const CellIndex first = frame.cell(low - Vec2{reach, reach});
  const CellIndex last = frame.cell(high + Vec2{reach, reach});
  for (int y = std::max(0, first.y / step * step); y <= std::min(last.y, frame.height - 1); y += step) {
    for (int x = std::max(0, first.x / step * step); x <= std::min(last.x, frame.width - 1); x += step) {
      if (distance_to(instance.solids, frame.center({x, y})) <= reach) visit(frame.index({x, y}));
    }
  }
}

// The reachable cell that is nearest to an instance; none where there is none within a generous distance.
std::optional<std::size_t> nearest_reachable(const SceneTables& tables, const Instance& instance) {
  const GridFrame& frame = tables.passable().frame;
  for (const double reach : {0.5, 1.0, 2.0, 4.0}) {
    std::optional<std::size_t> nearest;
    double best = kInfinity;
    cells_near(frame, instance, reach, 1, [&](std::size_t cell) {
      if (tables.reachable().cells[cell] == 0) return;
      const double d = distance_to(instance.solids, frame.center(frame.cell(cell)));
      if (d < best) {
        best = d;
        nearest = cell;
      }
    });
    if (nearest) return nearest;
  }
  return std::nullopt;
}

// The scene as ObjectNav sees it while it is worked out.
struct Place {
  const SceneTables& tables;
  const CameraSpec& camera;
  std::span<const Solid> solids;     // all of the scene's
  std::vector<unsigned char> roomy;  // by cell

  Place(const SceneTables& t, const CameraSpec& c, std::span<const Solid> s)
      : tables(t), camera(c), solids(s), roomy(t.passable().frame.size(), 0) {
    for (const std::size_t cell : tables.roomy()) roomy[cell] = 1;
  }

  Instance instance(int index) const {
    Instance made;
    made.id = static_cast<std::int16_t>(kFirstObjectId + index);
    std::ranges::copy_if(solids, std::back_inserter(made.solids), [&](const Solid& s) { return s.object == index; });
    return made;
  }

  // Whether the camera can show enough of an instance from a place, when the robot turns towards it, or somewhat
  // beside.
  bool may_succeed(const Instance& instance, std::span<const Solid> others, Vec2 base) const {
    constexpr double kAside = 0.6;  // [rad]
    const CameraIntrinsics small = coarse(camera.intrinsics());
    const Vec2 to = instance.solids.front().center - base;
    const double towards = exact::atan2(to.y, to.x);
    for (const double turn : {0.0, kAside, -kAside}) {
      const Eye eye = eye_of(camera, {base.x, base.y, wrap_angle(towards + turn)});
      const double seen = kCoarser * kCoarser * visible_pixels(small, eye, instance.solids, others);
      if (seen < kMargin * kGoalPixels) continue;
      const double silhouette = kCoarser * kCoarser * visible_pixels(small, eye, instance.solids, {});
      if (seen >= kMargin * kGoalShare * silhouette) return true;
    }
    return false;
  }

  // The passable cells within reach of any of the instances: no success is anywhere else.
  std::vector<std::size_t> in_reach(std::span<const Instance> instances) const {
    const GridFrame& frame = tables.passable().frame;
    std::vector<std::size_t> cells;
    for (const Instance& instance : instances) {
      cells_near(frame, instance, kGoalReach + frame.resolution, 1, [&](std::size_t cell) {
        if (tables.passable().cells[cell]) cells.push_back(cell);
      });
    }
    return cells;
  }

  void add_successes(const Instance& instance, std::vector<std::size_t>& cells) const {
    const GridFrame& frame = tables.passable().frame;
    std::vector<Solid> around;
    for (const Solid& solid : solids) {
      const bool own = solid.object == instance.id - kFirstObjectId;
      if (!own && distance_to(instance.solids, solid.center) <= kGoalReach + solid.radius) around.push_back(solid);
    }
    cells_near(frame, instance, kGoalReach - kReachMargin, kLattice, [&](std::size_t cell) {
      if (roomy[cell] && may_succeed(instance, around, frame.center(frame.cell(cell)))) cells.push_back(cell);
    });
  }
};

}  // namespace

std::size_t object_goal(std::string_view category) {
  const auto* const found = std::ranges::find(kObjectGoals, category);
  if (found != kObjectGoals.end()) return static_cast<std::size_t>(found - kObjectGoals.begin());
  const std::vector<std::string> known(kObjectGoals.begin(), kObjectGoals.end());
  throw ConfigError(unknown_name("object goal", category, known));
}

std::array<float, kObjectGoals.size()> one_hot(std::size_t goal) {
  std::array<float, kObjectGoals.size()> hot{};
  hot.at(goal) = 1.0F;
  return hot;
}

// One kind of thing in the scene.
struct ObjectNav::Goal {
  std::vector<Instance> instances;
  ViewBound bound;
  GeodesicField to_success;
  std::vector<std::size_t> starts;  // cells that are far enough from all instances

  static std::unique_ptr<const Goal> make(const Place& place, std::string_view category);

  bool in_view(const CameraSpec& camera, const CameraIntrinsics& intrinsics, const Pose2D& base) const {
    return bound.may_see(intrinsics, eye_of(camera, base), kGoalPixels);
  }

  // The distance [m] to the nearest point of any.
  double distance(Vec2 base) const {
    double nearest = kInfinity;
    for (const Instance& instance : instances) nearest = std::min(nearest, distance_to(instance.solids, base));
    return nearest;
  }

  // The first start at or after a cell, heading by heading, from which nothing is in view.
  std::optional<Pose2D> search(const CameraSpec& camera, const GridFrame& frame, std::size_t from) const {
    const CameraIntrinsics intrinsics = camera.intrinsics();
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const Vec2 middle = frame.center(frame.cell(starts[(from + i) % starts.size()]));
      for (int k = 0; k < kHeadings; ++k) {
        const Pose2D pose{middle.x, middle.y, wrap_angle(2.0 * exact::kPi * k / kHeadings)};
        if (!in_view(camera, intrinsics, pose)) return pose;
      }
    }
    return std::nullopt;
  }
};

// Null where there is no such thing, no success with it, or nowhere to start.
std::unique_ptr<const ObjectNav::Goal> ObjectNav::Goal::make(const Place& place, std::string_view category) {
  std::vector<int> indices;
  std::vector<Instance> instances;
  const auto& objects = place.tables.scene().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].category == category) indices.push_back(static_cast<int>(i));
  }
  for (const int index : indices) instances.push_back(place.instance(index));

  // where success is possible, and how far that is
  std::vector<std::size_t> successes;
  std::vector<std::size_t> nearest;
  for (const Instance& instance : instances) {
    place.add_successes(instance, successes);
    if (const auto cell = nearest_reachable(place.tables, instance)) nearest.push_back(*cell);
  }
  if (successes.empty()) return nullptr;
  ViewBound bound(place.tables.scene(), place.solids, indices, place.camera.mount_height);
  auto goal =
      std::make_unique<Goal>(Goal{std::move(instances), std::move(bound),
                                  GeodesicField(place.tables.passable(), successes), std::vector<std::size_t>{}});

  // where an episode may start: long things are near at one end and in reach at the other, so both are asked
  const GridFrame& frame = place.tables.passable().frame;
  const GeodesicField to_nearest(place.tables.passable(), nearest, kGoalDistance + 0.5);
  const GeodesicField to_reach(place.tables.passable(), place.in_reach(goal->instances), kShortestSearch + 0.5);
  for (const std::size_t cell : place.tables.roomy()) {
    const Vec2 middle = frame.center(frame.cell(cell));
    if (to_nearest.length_from(middle) >= kGoalDistance && to_reach.length_from(middle) >= kShortestSearch &&
        goal->to_success.length_from(middle) < kInfinity) {
      goal->starts.push_back(cell);
    }
  }
  if (!goal->search(place.camera, frame, 0)) return nullptr;
  return goal;
}

ObjectNav::ObjectNav(std::shared_ptr<const SceneTables> tables, const RobotProfile& robot)
    : tables_(std::move(tables)), solids_(tables_->scene().solids()) {
  if (!robot.camera) throw HardwareError(fmt::format("ObjectNav needs a camera, and '{}' has none", robot.name));
  camera_ = *robot.camera;
  const Place place(*tables_, camera_, solids_);
  for (std::size_t i = 0; i < kObjectGoals.size(); ++i) {
    goals_[i] = Goal::make(place, kObjectGoals[i]);
    if (goals_[i]) offered_.push_back(i);
  }
  if (offered_.empty()) {
    throw ConfigError(
        fmt::format("in scene '{}' nothing can be looked for; wanted: one of {} that a camera can see from "
                    "{} m, and a place {} m away from it",
                    tables_->scene().name, fmt::join(kObjectGoals, ", "), kGoalReach, kGoalDistance));
  }
}

ObjectNav::~ObjectNav() = default;
ObjectNav::ObjectNav(ObjectNav&&) noexcept = default;
ObjectNav& ObjectNav::operator=(ObjectNav&&) noexcept = default;

ObjectNavEpisode ObjectNav::sample(std::uint64_t seed, std::uint32_t index, std::string_view category) const {
  const RngKey key{.seed = seed, .episode = index, .sensor = 7, .stream = Stream::sampler};
  const auto pick = [&](std::uint64_t sample, std::uint32_t lane, std::size_t count) {
    return static_cast<std::size_t>(uniform(key, sample, lane) * static_cast<double>(count));
  };
  ObjectNavEpisode episode;
  const auto bits = random_bits(key, 0, 0);
  episode.seed = std::uint64_t{bits[0]} << 32 | bits[1];
  episode.goal = category.empty() ? offered_[pick(0, 1, offered_.size())] : object_goal(category);
  const Goal& goal = goal_of(episode.goal);
  const GridFrame& frame = tables_->passable().frame;
  const CameraIntrinsics intrinsics = camera_.intrinsics();
  std::optional<Pose2D> start;
  for (std::uint64_t sample = 1; sample <= kStartTries && !start; ++sample) {
    const Vec2 middle = frame.center(frame.cell(goal.starts[pick(sample, 0, goal.starts.size())]));
    const Pose2D pose{middle.x, middle.y, wrap_angle(uniform(key, sample, 1, -exact::kPi, exact::kPi))};
    if (!goal.in_view(camera_, intrinsics, pose)) start = pose;
  }
  if (!start) start = goal.search(camera_, frame, pick(0, 2, goal.starts.size()));  // there is one: `make` found it
  episode.start = *start;
  episode.geodesic = distance(episode.goal, start->position());
  return episode;
}

const ObjectNav::Goal& ObjectNav::goal_of(std::size_t goal) const {
  if (goals_[goal]) return *goals_[goal];
  throw ConfigError(fmt::format("in scene '{}' no {} can be looked for; goals there: {}", tables_->scene().name,
                                kObjectGoals[goal], fmt::join(goal_names(offered_), ", ")));
}

ObjectNavEpisode ObjectNav::sample_in_sight(std::uint64_t seed, std::uint32_t index, std::string_view category) const {
  const RngKey key{.seed = seed, .episode = index, .sensor = 8, .stream = Stream::sampler};
  const GridFrame& frame = tables_->passable().frame;
  const std::span<const std::size_t> roomy = tables_->roomy();
  const auto place = [&](double chance, std::size_t count) {
    return static_cast<std::size_t>(chance * static_cast<double>(count));
  };
  ObjectNavEpisode episode;
  const auto bits = random_bits(key, 0, 0);
  episode.seed = std::uint64_t{bits[0]} << 32 | bits[1];

  // each kind is as likely, but for those of which nothing is found in sight
  std::vector<std::size_t> kinds = category.empty() ? offered_ : std::vector{object_goal(category)};
  for (std::uint32_t turn = 0; !kinds.empty(); ++turn) {
    const auto kind = kinds.begin() + static_cast<std::ptrdiff_t>(place(uniform(key, turn, 1), kinds.size()));
    const Goal& goal = goal_of(*kind);
    for (std::uint64_t sample = turn * kSightTries; sample < (turn + 1) * kSightTries; ++sample) {
      const Vec2 middle = frame.center(frame.cell(roomy[place(uniform(key, sample, 2), roomy.size())]));
      const Pose2D pose{middle.x, middle.y, wrap_angle(uniform(key, sample, 3, -exact::kPi, exact::kPi))};
      const double nearest = goal.distance(middle);
      if (nearest < kSightNearest || nearest > kSightFarthest || !in_sight(goal, pose)) continue;
      episode.goal = *kind;
      episode.start = pose;
      episode.geodesic = distance(*kind, middle);
      if (episode.geodesic < kInfinity) return episode;
    }
    kinds.erase(kind);
  }
  throw ConfigError(fmt::format("in scene '{}' no start was found with a {} in sight", tables_->scene().name,
                                category.empty() ? "goal" : category));
}

std::vector<std::size_t> ObjectNav::in_sight(const Pose2D& base) const {
  std::vector<std::size_t> kinds;
  std::ranges::copy_if(offered_, std::back_inserter(kinds),
                       [&](std::size_t kind) { return in_sight(*goals_[kind], base); });
  return kinds;
}

bool ObjectNav::in_sight(const Goal& goal, const Pose2D& base) const {
  const CameraIntrinsics intrinsics = camera_.intrinsics();
  if (!goal.in_view(camera_, intrinsics, base)) return false;
  const Eye eye = eye_of(camera_, base);
  return std::ranges::any_of(goal.instances, [&](const Instance& instance) {
    if (distance_to(instance.solids, base.position()) > kSightFarthest) return false;
    const int silhouette = visible_pixels(intrinsics, eye, instance.solids, {});
    if (silhouette < kGoalPixels) return false;
    double farthest = 0.0;
    for (const Solid& solid : instance.solids)
      farthest = std::max(farthest, threewe::distance(solid.center, base.position()) + solid.radius);
    std::vector<Solid> others;
    std::ranges::copy_if(solids_, std::back_inserter(others), [&](const Solid& solid) {
      return solid.object != instance.id - kFirstObjectId && distance_to(solid, base.position()) <= farthest;
    });
    const int seen = visible_pixels(intrinsics, eye, instance.solids, others);
    return seen >= kGoalPixels && seen >= kGoalShare * silhouette;
  });
}

double ObjectNav::distance(std::size_t goal, Vec2 base) const {
  return goals_[goal] ? goals_[goal]->to_success.length_from(base) : kInfinity;
}

std::vector<std::size_t> ObjectNav::found(std::size_t goal, const Pose2D& base, const FrameIds& look) const {
  std::vector<std::size_t> found;
  if (!goals_[goal]) return found;
  std::span<const std::int16_t> frame;
  for (const Instance& instance : goals_[goal]->instances) {
    if (distance_to(instance.solids, base.position()) > kGoalReach) continue;
    if (frame.empty()) frame = look();
    const auto pixels = std::ranges::count(frame, instance.id);
    if (pixels < kGoalPixels) continue;
    const int silhouette = visible_pixels(camera_.intrinsics(), eye_of(camera_, base), instance.solids, {});
    if (static_cast<double>(pixels) >= kGoalShare * silhouette)
      found.push_back(static_cast<std::size_t>(instance.id - kFirstObjectId));
  }
  return found;
}

StopTaskStep ObjectNav::step(const ObjectNavEpisode& episode, StopTaskState& state, const Pose2D& base,
                             std::span<const float, 3> action, Duration period, const FrameIds& look) const {
  return advance(state, action, period, distance(episode.goal, base.position()),
                 [&] { return is_success(episode.goal, base, look); });
}

}  // namespace threewe::task
