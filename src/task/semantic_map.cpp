#include "task/semantic_map.hpp"

#include <algorithm>
#include <utility>

#include "core/numbers.hpp"
#include "threewe/scene/cell_grid.hpp"

namespace threewe::task {
namespace {

using scene::CellIndex;
using scene::GridFrame;
using scene::Room;
using scene::Solid;

constexpr double kBorderGap = 0.3;    // [m] between rooms that share a border
constexpr double kNarrowest = 0.1;    // [m] along which a base must be able to cross a border
constexpr double kOnTheFloor = 0.3;   // [m]: what reaches below can be gone up to
constexpr double kBeside = 0.5;       // [m] between two things beside one another
constexpr double kAt = 0.5;           // [m] between a robot's base and the thing it stands at
constexpr double kInside = 0.7;       // [m] behind an opening
constexpr double kFarFromWish = 1.5;  // [m] between a wished place and the roomy cell that is taken for it

double gap(const std::vector<Solid>& a, const std::vector<Solid>& b) {
  double nearest = kInfinity;
  for (const Solid& s : a) {
    for (const Solid& t : b) {
      const double between =
          t.shape == Solid::Shape::box ? distance_to(s, t.corners) : std::max(0.0, distance_to(s, t.center) - t.radius);
      nearest = std::min(nearest, between);
    }
  }
  return nearest;
}

}  // namespace

SemanticMap::SemanticMap(const scene::SceneTables& tables, const language::Language& language)
    : tables_(&tables), roomy_(tables.passable().frame.size(), 0) {
  for (const std::size_t cell : tables.roomy()) roomy_[cell] = 1;
  const std::vector<Room>& rooms = tables.scene().rooms;
  for (const Room& room : rooms) rooms_.push_back(language.room(room.name));
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    for (std::size_t j = i + 1; j < rooms.size(); ++j) find_openings(rooms[i], rooms[j], i, j);
  }
  find_landmarks(language);
}

std::optional<std::size_t> SemanticMap::room_at(Vec2 point) const {
  const Room* room = tables_->scene().room_at(point);
  if (room == nullptr) return std::nullopt;
  return static_cast<std::size_t>(room - tables_->scene().rooms.data());
}

// Along the border that two rooms share, every stretch of cells that can be reached is an opening; one with the middle
// of a doorway in it is a door.
void SemanticMap::find_openings(const Room& a, const Room& b, std::size_t index_a, std::size_t index_b) {
  const bool a_first_x = std::abs(a.max.x - b.min.x) <= kBorderGap;
  const bool b_first_x = std::abs(b.max.x - a.min.x) <= kBorderGap;
  const bool a_first_y = std::abs(a.max.y - b.min.y) <= kBorderGap;
  const bool b_first_y = std::abs(b.max.y - a.min.y) <= kBorderGap;
  const Vec2 low{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y)};
  const Vec2 high{std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y)};
  const bool beside_in_x = (a_first_x || b_first_x) && high.y - low.y > kBorderGap;
  const bool beside_in_y = (a_first_y || b_first_y) && high.x - low.x > kBorderGap;
  if (!beside_in_x && !beside_in_y) return;

  const Vec2 along = beside_in_x ? Vec2{0.0, 1.0} : Vec2{1.0, 0.0};
  const Vec2 normal = beside_in_x ? Vec2{a_first_x ? 1.0 : -1.0, 0.0} : Vec2{0.0, a_first_y ? 1.0 : -1.0};
  const Vec2 begin = beside_in_x ? Vec2{0.5 * (low.x + high.x), low.y} : Vec2{low.x, 0.5 * (low.y + high.y)};
  const double length = dot(high - low, along);
  const auto& reachable = tables_->reachable();
  const double step = reachable.frame.resolution;
  Opening open{.is_door = false, .rooms = {index_a, index_b}, .a = {}, .b = {}, .normal = normal};
  bool inside = false;
  const int steps = static_cast<int>(length / step);
  for (int i = 0; i <= steps; ++i) {
    const Vec2 point = begin + ((i + 0.5) * step) * along;
    const bool free = i < steps && reachable.value_or(reachable.frame.cell(point), 0) != 0;
    if (free && !inside) open.a = point;
    if (free) open.b = point;
    if (!free && inside && distance(open.a, open.b) >= kNarrowest) {
      open.is_door = std::ranges::any_of(tables_->scene().doors, [&](const scene::Door& door) {
        return distance_to_segment(door.center, open.a, open.b) <= kBorderGap;
      });
      openings_.push_back(open);
    }
    inside = free;
  }
}

void SemanticMap::find_landmarks(const language::Language& language) {
  const auto& objects = tables_->scene().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const scene::Object& object = objects[i];
    if (object.category == "door") continue;  // a leaf would be taken for a doorway
    Landmark landmark{.object = i,
                      .room = 0,
                      .noun = language.thing(object.category, object.shape),
                      .general = language.thing(object.category),
                      .center = {},
                      .solids = {}};
    double lowest = kInfinity;
    for (const scene::Prism& prism : object.prisms) {
      landmark.solids.push_back(solid_of(prism, object.pose, static_cast<int>(i)));
      lowest = std::min(lowest, landmark.solids.back().z_min);
    }
    const auto [low, high] = bounds(landmark.solids);
    landmark.center = 0.5 * (low + high);
    const auto room = room_at(landmark.center);
    if (!room || lowest > kOnTheFloor) continue;
    landmark.room = *room;
    landmarks_.push_back(std::move(landmark));
  }

  beside_.resize(landmarks_.size());
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    for (std::size_t j = 0; j < landmarks_.size(); ++j) {
      const bool same_room = i != j && landmarks_[i].room == landmarks_[j].room;
      if (same_room && gap(landmarks_[i].solids, landmarks_[j].solids) <= kBeside) beside_[i].push_back(j);
    }
  }
}

std::optional<Vec2> SemanticMap::place_at(std::size_t landmark, Vec2 from) const {
  const Landmark& thing = landmarks_[landmark];
  const GridFrame& frame = tables_->passable().frame;
  const auto [low, high] = bounds(thing.solids);
  const CellIndex first = frame.cell(low - Vec2{kAt, kAt});
  const CellIndex last = frame.cell(high + Vec2{kAt, kAt});
  std::optional<Vec2> best;
  for (int y = std::max(first.y, 0); y <= std::min(last.y, frame.height - 1); ++y) {
    for (int x = std::max(first.x, 0); x <= std::min(last.x, frame.width - 1); ++x) {
      const Vec2 middle = frame.center({x, y});
      if (roomy_[frame.index({x, y})] == 0 || (best && distance(middle, from) >= distance(*best, from))) continue;
      if (distance_to(thing.solids, middle) <= kAt && room_at(middle) == thing.room) best = middle;
    }
  }
  return best;
}

std::optional<Vec2> SemanticMap::middle_of(std::size_t room) const {
  const Room& r = tables_->scene().rooms[room];
  return roomy_cell_near(room, 0.5 * (r.min + r.max), kFarFromWish);
}

std::optional<Vec2> SemanticMap::just_inside(std::size_t room, std::size_t opening) const {
  const Opening& o = openings_[opening];
  return roomy_cell_near(room, o.middle() - kInside * o.out_of(room), 0.5 * kInside);
}

std::optional<Vec2> SemanticMap::roomy_cell_near(std::size_t room, Vec2 point, double farthest) const {
  const GridFrame& frame = tables_->passable().frame;
  const CellIndex first = frame.cell(point - Vec2{farthest, farthest});
  const CellIndex last = frame.cell(point + Vec2{farthest, farthest});
  std::optional<Vec2> best;
  for (int y = std::max(first.y, 0); y <= std::min(last.y, frame.height - 1); ++y) {
    for (int x = std::max(first.x, 0); x <= std::min(last.x, frame.width - 1); ++x) {
      const Vec2 middle = frame.center({x, y});
      const double d = distance(middle, point);
      if (d > farthest || (best && d >= distance(*best, point)) || roomy_[frame.index({x, y})] == 0) continue;
      if (room_at(middle) == room) best = middle;
    }
  }
  return best;
}

}  // namespace threewe::task
