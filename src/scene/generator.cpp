#include "threewe/scene/generator.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "floor_plan.hpp"
#include "furnishing.hpp"
#include "scene/occupancy.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

constexpr int kWallInset = 9;                // [cm] from the middle of a wall to what stands along it
constexpr int kWidestDoor = 105;             // [cm] of a doorway with a leaf
constexpr double kRobotHeight = 0.5;         // [m], of the tallest robot
constexpr double kWayRadius = 0.30;          // [m] around the middle of a way to every room, for the widest robot
constexpr double kAnchorClearance = 0.38;    // [m]
constexpr std::uint32_t kMostAttempts = 64;  // at a floor plan that has a place to start

void check(const GeneratorOptions& options) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  if (!within(options.difficulty, 0.0, 1.0)) {
    throw ConfigError(fmt::format("difficulty {} is outside [0, 1]", options.difficulty));
  }
  for (const double side : {options.size.x, options.size.y}) {
    if (!within(side, 6.0, 40.0)) throw ConfigError(fmt::format("a side of {} m is outside [6, 40]", side));
  }
}

int in_centimetres(double metres) { return 10 * static_cast<int>(std::lround(10.0 * metres)); }

class Generator {
 public:
  Generator(std::uint64_t seed, std::uint32_t attempt, const GeneratorOptions& options)
      : seed_(seed), options_(options), random_({.seed = seed, .episode = attempt, .stream = Stream::scene}) {}

  // Nothing where the floor plan has no place to start.
  std::optional<Scene> generate() {
    plan_ =
        draw_floor_plan(in_centimetres(options_.size.x), in_centimetres(options_.size.y), options_.difficulty, random_);
    if (!choose_start()) return std::nullopt;
    for (std::size_t i = 0; i < plan_.rooms.size(); ++i) {
      uses_.push_back(furnish(empty_room(i), options_.difficulty, random_));
    }
    Scene scene = build();
    while (make_way(scene)) scene = build();
    return scene;
  }

 private:
  // The start heads east, in the largest room in which (2, 1) from there is free as well.
  bool choose_start() {
    const Box* best = nullptr;
    for (const Box& room : plan_.rooms) {
      const bool fits = room.width() >= 360 && room.depth() >= 240;
      if (fits && (best == nullptr || room.width() * room.depth() > best->width() * best->depth())) best = &room;
    }
    if (best == nullptr) return false;
    start_x_ = best->x0 + 60 + random_.between(0, best->width() - 340);
    start_y_ = best->y0 + 60 + random_.between(0, best->depth() - 220);
    return true;
  }

  EmptyRoom empty_room(std::size_t index) {
    const Box& room = plan_.rooms[index];
    EmptyRoom empty;
    empty.inside = {room.x0 + kWallInset, room.y0 + kWallInset, room.x1 - kWallInset, room.y1 - kWallInset};
    empty.corridor = index < corridors();
    for (const Passage& passage : plan_.passages) {
      if (passage.room_a != index && passage.room_b != index) continue;
      const WallLine& wall = plan_.lines[passage.line];
      EmptyRoom::Doorway doorway;
      // the way into the room: north and east of a wall, or south and west
      const bool positive = passage.room_b == index;
      doorway.turns = wall.along_x ? (positive ? 1 : 3) : (positive ? 0 : 2);
      doorway.x = wall.along_x ? passage.at : wall.at;
      doorway.y = wall.along_x ? wall.at : passage.at;
      doorway.width = passage.width;
      // corridors are too narrow for leaves, and a door has but one
      doorway.leaf = !empty.corridor && passage.width <= kWidestDoor && (!positive || passage.room_a < corridors()) &&
                     random_.chance(0.6);
      empty.doorways.push_back(doorway);
    }
    // the start, (2, 1), and the straight way from one to the other
    empty.keep_free = {start_x_ - 45, start_y_ - 45, start_x_ + 245, start_y_ + 145};
    return empty;
  }

  std::size_t corridors() const { return static_cast<std::size_t>(plan_.corridors); }

  // The plan and what is left of the furniture as a scene.
  Scene build() const {
    Scene scene;
    scene.name = fmt::format("generated_{}", seed_);
    scene.description = fmt::format("A generated building of {} x {} m, difficulty {}, seed {}", options_.size.x,
                                    options_.size.y, options_.difficulty, seed_);
    scene.starts = {{0.0, 0.0, 0.0}};
    add_walls(scene);
    add_objects(scene);
    add_rooms(scene);
    return scene;
  }

  void add_walls(Scene& scene) const {
    for (std::size_t i = 0; i < plan_.lines.size(); ++i) {
      const WallLine& line = plan_.lines[i];
      WallPlan wall;
      wall.wall.a = line.along_x ? at(line.from, line.at) : at(line.at, line.from);
      wall.wall.b = line.along_x ? at(line.to, line.at) : at(line.at, line.to);
      if (line.outer) wall.wall.thickness = 0.15;
      for (const Passage& passage : plan_.passages) {
        if (passage.line != i) continue;
        const auto number = &passage - plan_.passages.data() + 1;
        wall.doorways.push_back(
            {fmt::format("door_{}", number), (passage.at - line.from) / 100.0, passage.width / 100.0});
      }
      scene.plan.push_back(std::move(wall));
    }
    scene.build_walls();
  }

  void add_objects(Scene& scene) const {
    std::map<std::string, int> count;
    for (const RoomUse& use : uses_) {
      for (const Group& group : use.groups) {
        for (Object object : group.objects) {
          object.name = fmt::format("{}_{}", object.category, ++count[object.category]);
          object.pose.x = from_start(object.pose.x, start_x_);
          object.pose.y = from_start(object.pose.y, start_y_);
          scene.objects.push_back(std::move(object));
        }
      }
    }
  }

  void add_rooms(Scene& scene) const {
    const Obstacles obstacles(scene.solids_between(0.0, kRobotHeight));
    std::map<std::string, int> count;
    for (std::size_t i = 0; i < plan_.rooms.size(); ++i) {
      const Box& box = plan_.rooms[i];
      const int number = ++count[uses_[i].name];
      const std::string name = number == 1 ? uses_[i].name : fmt::format("{}_{}", uses_[i].name, number);
      scene.rooms.push_back({name, at(box.x0, box.y0), at(box.x1, box.y1), uses_[i].floor, anchor(i, obstacles)});
    }
  }

  // The middle of a room, or else the space in front of its door, or in the only room the start: both are always free.
  Vec2 anchor(std::size_t index, const Obstacles& obstacles) const {
    const Box& box = plan_.rooms[index];
    const Vec2 middle = at((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2);
    if (obstacles.clearance(middle) >= kAnchorClearance) return middle;
    const auto passage =
        std::ranges::find_if(plan_.passages, [&](const Passage& p) { return p.room_a == index || p.room_b == index; });
    if (passage == plan_.passages.end()) return {0.0, 0.0};
    const WallLine& wall = plan_.lines[passage->line];
    const int inside = wall.at + (passage->room_a == index ? -50 : 50);
    return wall.along_x ? at(passage->at, inside) : at(inside, passage->at);
  }

  // Looks for a room that cannot be reached; takes what was put there last, or in the room before it, out again.
  // Returns whether anything had to go.
  bool make_way(const Scene& scene) {
    const Obstacles obstacles(scene.solids_between(0.0, kRobotHeight));
    // between the middles of neighbouring cells the way is at most 5 cm narrower
    GridFrame coarse = grid_over(scene);
    coarse = {coarse.origin, 2.0 * coarse.resolution, (coarse.width + 1) / 2, (coarse.height + 1) / 2};
    const CellGrid<float> distance = distance_field(occupied_cells(coarse, obstacles.solids()));
    const CellSet reached = connected_cells(cells_with_clearance(obstacles, distance, kWayRadius), {0.0, 0.0});
    const auto can_reach = [&](std::size_t room) {
      return reached.value_or(reached.frame.cell(scene.rooms[room].anchor), 0) != 0;
    };
    for (const Passage& passage : plan_.passages) {
      if (can_reach(passage.room_a) == can_reach(passage.room_b)) continue;
      auto& a = uses_[passage.room_a].groups;
      auto& b = uses_[passage.room_b].groups;
      auto& fuller = a.size() > b.size() ? a : b;
      if (fuller.empty()) continue;
      fuller.pop_back();
      return true;
    }
    return false;
  }

  Vec2 at(int x, int y) const { return {(x - start_x_) / 100.0, (y - start_y_) / 100.0}; }
  // poses are whole centimetres too: they are moved without a rounding error
  static double from_start(double metres, int start) {
    return (static_cast<int>(std::lround(100.0 * metres)) - start) / 100.0;
  }

  std::uint64_t seed_;
  GeneratorOptions options_;
  RandomStream random_;
  FloorPlan plan_;
  int start_x_ = 0;  // [cm]
  int start_y_ = 0;
  std::vector<RoomUse> uses_;
};

}  // namespace

Scene generate(std::uint64_t seed, const GeneratorOptions& options) {
  check(options);
  for (std::uint32_t attempt = 0; attempt < kMostAttempts; ++attempt) {
    if (auto scene = Generator(seed, attempt, options).generate()) return std::move(*scene);
  }
  throw ConfigError(fmt::format("no room to start in a building of {} x {} m", options.size.x, options.size.y));
}

}  // namespace threewe::scene
