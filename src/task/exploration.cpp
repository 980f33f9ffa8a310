#include "threewe/task/tasks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "scene/cell_lines.hpp"
#include "scene/coverage.hpp"
#include "scene/scene_tables.hpp"
#include "task/draws.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

constexpr double kRewardPerArea = 0.2;  // [1/m^2]
constexpr double kStepCost = 0.01;
constexpr double kSuccessReward = 10.0;
constexpr double kContactCost = 0.1;
constexpr double kContactSpeed = 0.05;  // [m/s]
constexpr std::size_t kRays = 360;

constexpr int kWindow = 64;        // cells of the coverage map, each way
constexpr double kMapCell = 0.25;  // [m]
constexpr double kApart = 1.0;     // [m] between robots that start together, at most 4 m
constexpr double kTogether = 4.0;

// One bit for each of many cells.
class Bits {
 public:
  void reset(std::size_t count) { words_.assign((count + 63) / 64, 0); }
  bool get(std::size_t i) const { return (words_[i / 64] >> (i % 64) & 1U) != 0; }
  void set(std::size_t i) { words_[i / 64] |= std::uint64_t{1} << (i % 64); }
  void clear(std::size_t i) { words_[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }

 private:
  std::vector<std::uint64_t> words_;
};

// The directions of a fan's beams, one after the other. Every sixteenth is exact, and the others are turned from there.
class Directions {
 public:
  Directions(double angle, double increment)
      : angle_(angle), increment_(increment), step_(rotate({1.0, 0.0}, increment)) {}
  Vec2 next() {
    if (count_ % 16 == 0) {
      now_ = rotate({1.0, 0.0}, angle_ + count_ * increment_);
    } else {
      now_ = {now_.x * step_.x - now_.y * step_.y, now_.x * step_.y + now_.y * step_.x};
    }
    ++count_;
    return now_;
  }

 private:
  double angle_;
  double increment_;
  Vec2 step_;
  Vec2 now_;
  int count_ = 0;
};

// What there is to cover in a scene.
struct Ground {
  scene::GridFrame frame;
  Bits coverable;
  std::size_t cells = 0;
  double reach = 0.0;  // [m] that no two places of the scene are farther apart than

  explicit Ground(const scene::SceneTables& tables) {
    const scene::CellSet set = scene::coverable_cells(tables);
    frame = set.frame;
    coverable.reset(frame.size());
    for (std::size_t i = 0; i < set.cells.size(); ++i) {
      if (!set.cells[i]) continue;
      coverable.set(i);
      ++cells;
    }
    reach = distance(tables.scene().min, tables.scene().max);
  }
  double area() const { return static_cast<double>(cells) * frame.resolution * frame.resolution; }
};

// What the robots of a world have seen, as they believe: a square around the start of the first.
class SeenMap {
 public:
  void begin(double reach) {
    half_ = static_cast<int>(std::ceil(reach / kMapCell)) + kWindow / 2;
    frame_ = {{-half_ * kMapCell, -half_ * kMapCell}, kMapCell, 2 * half_, 2 * half_};
    free_.reset(frame_.size());
    occupied_.reset(frame_.size());
  }

  void add_scan(const Belief& belief) {
    const Pose2D map_from_lidar = belief.map_from_base * belief.base_from_lidar;
    const double increment = 2.0 * exact::kPi / static_cast<double>(belief.scan.size());
    Directions directions(map_from_lidar.theta - exact::kPi, increment);
    for (const float beam : belief.scan) {
      const Vec2 direction = directions.next();
      const auto range = static_cast<double>(beam);
      if (range <= 0.0) continue;
      const double seen = std::min(range, scene::kCoverageRange);
      const Vec2 end = map_from_lidar.position() + seen * direction;
      const bool hit = range < belief.range_max && range <= scene::kCoverageRange;
      scene::mark_line(frame_, map_from_lidar.position(), end, [&](std::size_t i) { free_.set(i); });
      const scene::CellIndex last = frame_.cell(end);
      if (hit && frame_.contains(last)) occupied_.set(frame_.index(last));
    }
  }

  // The window around a place: row by row from low y.
  void fill(Vec2 place, std::span<std::byte> window) const {
    if (window.empty()) return;
    const auto corner = [&](double at) {
      return static_cast<int>(std::floor(at / kMapCell + 0.5)) + half_ - kWindow / 2;
    };
    const int left = corner(place.x);
    const int low = corner(place.y);
    std::size_t i = 0;
    for (int y = low; y < low + kWindow; ++y) {
      for (int x = left; x < left + kWindow; ++x) window[i++] = static_cast<std::byte>(value({x, y}));
    }
  }

 private:
  int value(scene::CellIndex cell) const {
    if (!frame_.contains(cell)) return 0;
    const std::size_t i = frame_.index(cell);
    return occupied_.get(i) ? 255 : free_.get(i) ? 127 : 0;
  }

  scene::GridFrame frame_;
  int half_ = 0;
  Bits free_;
  Bits occupied_;
};

// One world's episode.
struct CoverageState {
  std::size_t scene = 0;
  Bits left;  // to be covered
  std::size_t covered = 0;
  SeenMap seen;
  std::vector<double> driven;   // [m] by each robot
  std::vector<double> contact;  // [m/s] of each robot's fastest
  bool success = false;
};

class Exploration final : public Task {
 public:
  Exploration(const TaskContext& context, const ExplorationOptions& options)
      : options_(options), scenes_(context.scenes), robots_(context.robots), coverages_(context.worlds) {
    for (const auto& scene : scenes_) grounds_.emplace_back(*scene);
  }

  std::vector<Field> fields() const override {
    return {{"coverage_map", Field::Type::uint8, {kWindow, kWindow, 1}, 0.0, 255.0}};
  }
  std::vector<std::string> metrics() const override {
    return {"success", "coverage", "path_length", "collision_speed"};
  }
  std::size_t rays() const override { return kRays; }

  void begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
             std::span<Pose2D> starts) override;
  void step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) override;
  void update(std::size_t world, const Belief& belief) override { coverages_[world].seen.add_scan(belief); }
  void observe(std::size_t world, std::size_t /*robot*/, const Belief& belief,
               std::span<const std::span<std::byte>> fields) override {
    coverages_[world].seen.fill(belief.map_from_base.position(), fields[0]);
  }
  void measure(std::size_t world, std::span<double> metrics) const override;
  DebugOverlay debug_overlay(std::size_t world) const override;

 private:
  double share(const CoverageState& coverage) const {
    return static_cast<double>(coverage.covered) / static_cast<double>(grounds_[coverage.scene].cells);
  }
  void cover(const TaskState& moment, CoverageState& coverage) const;

  ExplorationOptions options_;
  Scenes scenes_;
  std::size_t robots_;
  std::vector<Ground> grounds_;           // by scene
  std::vector<CoverageState> coverages_;  // by world
};

// The first robot starts anywhere, the others near it.
void Exploration::begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
                        std::span<Pose2D> starts) {
  constexpr int kTries = 20000;
  if (request.goal) throw ConfigError("exploration has no goal to be asked for");
  const scene::SceneTables& tables = *scenes_[key.scene];
  Draws draws(key, 0);
  starts[0] = request.start ? *request.start : draws.roomy_pose(tables);
  int tries = 0;
  for (std::size_t robot = 1; robot < robots_;) {
    if (++tries > kTries) {
      throw ConfigError(fmt::format("scene '{}' has no room for {} robots near ({}, {})", tables.scene().name, robots_,
                                    starts[0].x, starts[0].y));
    }
    starts[robot] = draws.roomy_pose(tables);
    const auto apart = [&](const Pose2D& other) { return distance(other.position(), starts[robot].position()); };
    const bool near = apart(starts[0]) <= kTogether;
    const auto too_near = [&](const Pose2D& other) { return apart(other) < kApart; };
    if (near && std::ranges::none_of(starts.first(robot), too_near)) ++robot;
  }

  CoverageState& coverage = coverages_[world];
  coverage.scene = key.scene;
  coverage.left = grounds_[key.scene].coverable;
  coverage.covered = 0;
  coverage.seen.begin(grounds_[key.scene].reach);
  coverage.driven.assign(robots_, 0.0);
  coverage.contact.assign(robots_, 0.0);
  coverage.success = false;
}

void Exploration::step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) {
  CoverageState& coverage = coverages_[world];
  const double before = share(coverage);
  int contacts = 0;
  for (std::size_t robot = 0; robot < robots_; ++robot) {
    cover(robots[robot], coverage);
    coverage.driven[robot] = robots[robot].distance_driven;
    const double contact = robots[robot].max_collision_speed;
    if (contact > std::max(coverage.contact[robot], kContactSpeed)) ++contacts;
    coverage.contact[robot] = contact;
  }
  coverage.success = share(coverage) >= options_.enough;
  const double gained = kRewardPerArea * grounds_[coverage.scene].area() * (share(coverage) - before);
  const double reward = gained - kStepCost + (coverage.success ? kSuccessReward : 0.0) - contacts * kContactCost;
  for (Outcome& outcome : outcomes) outcome = {reward, coverage.success};
}

void Exploration::cover(const TaskState& moment, CoverageState& coverage) const {
  const scene::GridFrame& frame = grounds_[coverage.scene].frame;
  const Vec2 origin = moment.lidar.position();
  Directions directions(moment.lidar.theta, 2.0 * exact::kPi / static_cast<double>(moment.ranges.size()));
  for (const float beam : moment.ranges) {
    const double range = std::min(static_cast<double>(beam), scene::kCoverageRange);
    mark_line(frame, origin, origin + range * directions.next(), [&](std::size_t i) {
      if (!coverage.left.get(i)) return;
      coverage.left.clear(i);
      ++coverage.covered;
    });
  }
}

void Exploration::measure(std::size_t world, std::span<double> metrics) const {
  const CoverageState& coverage = coverages_[world];
  auto to = metrics.begin();
  for (std::size_t robot = 0; robot < robots_; ++robot) {
    const std::array<double, 4> values{coverage.success ? 1.0 : 0.0, share(coverage), coverage.driven[robot],
                                       coverage.contact[robot]};
    to = std::ranges::copy(values, to).out;
  }
}

DebugOverlay Exploration::debug_overlay(std::size_t world) const {
  const CoverageState& coverage = coverages_[world];
  const Ground& ground = grounds_[coverage.scene];
  DebugOverlay debug_overlay{.ground = {ground.frame, 0}};
  for (std::size_t i = 0; i < ground.frame.size(); ++i) {
    if (ground.coverable.get(i)) debug_overlay.ground.cells[i] = coverage.left.get(i) ? 1 : 2;
  }
  return debug_overlay;
}

}  // namespace

std::unique_ptr<Task> make_exploration(const TaskContext& context, const ExplorationOptions& options) {
  return std::make_unique<Exploration>(context, options);
}

}  // namespace threewe::task
