#include "agent/rooms.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::agent {
namespace {

using map::OccupancyGrid;
using semantics::Place;
using semantics::SemanticMap;

constexpr double kThrough = 0.2;     // [m] on both sides of a border that are free where it is open
constexpr double kBeyond = 0.35;     // [m] behind a border, where the room is that adjoins
constexpr double kNarrowest = 0.35;  // [m] of an opening
constexpr double kHole = 0.12;       // [m] in an opening, of cells that no beam has crossed
constexpr double kWidestDoor = 2.2;  // [m]
constexpr double kJamb = 0.3;        // [m] from an opening's end to the wall that ends it
constexpr double kUnseenApart = 0.25;

double area(const Place& place) {
  double twice = 0.0;
  for (std::size_t i = 0, j = place.polygon.size() - 1; i < place.polygon.size(); j = i++)
    twice += cross(place.polygon[j], place.polygon[i]);
  return 0.5 * twice;
}

bool is_room(const Place& place) { return place.polygon.size() >= 3; }

enum class Cells : std::uint8_t { open, wall, unknown };

// What a map says of the line across a border at a point.
Cells across(const OccupancyGrid& grid, Vec2 point, Vec2 normal) {
  Cells found = Cells::open;
  const auto steps = static_cast<int>(kThrough / grid.resolution);
  for (int i = -steps; i <= steps; ++i) {
    const auto value = grid.at(grid.cell(point + (i * grid.resolution) * normal));
    if (value >= OccupancyGrid::kOccupiedThreshold) return Cells::wall;
    if (value < 0 || value > OccupancyGrid::kFreeThreshold) found = Cells::unknown;
  }
  return found;
}

// One wall of a room, from one end to the other.
class Wall {
 public:
  Wall(const OccupancyGrid& grid, const std::vector<Place>& places, std::size_t room, Vec2 begin, Vec2 end)
      : grid_(grid), places_(places), room_(room), begin_(begin), length_(distance(begin, end)) {
    along_ = (1.0 / length_) * (end - begin);
    const double side = area(places[room]) > 0.0 ? 1.0 : -1.0;
    normal_ = {side * along_.y, -side * along_.x};
  }

  void add_to(Border& border) {
    const auto steps = static_cast<int>(length_ / grid_.resolution);
    for (int i = 0; i <= steps; ++i) {
      const Vec2 point = begin_ + ((i + 0.5) * grid_.resolution) * along_;
      const std::size_t to = i < steps ? beyond(point) : places_.size();
      const Cells cells = to < places_.size() ? across(grid_, point, normal_) : Cells::wall;
      if (cells == Cells::unknown &&
          (border.unseen.empty() || distance(border.unseen.back().point, point) >= kUnseenApart))
        border.unseen.push_back({.to = to, .point = point, .normal = normal_});
      const bool ends = open_ && (to != open_->to || cells == Cells::wall || distance(open_->b, point) > kHole);
      if (ends) close(border);
      if (cells != Cells::open) continue;
      if (!open_) open_ = Opening{.to = to, .a = point, .b = point, .normal = normal_};
      open_->b = point;
    }
  }

 private:
  // The room behind a point; the number of places where there is none.
  std::size_t beyond(Vec2 point) const {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (i != room_ && is_room(places_[i]) && SemanticMap::contains(places_[i], point + kBeyond * normal_)) return i;
    }
    return places_.size();
  }

  void close(Border& border) {
    const double width = distance(open_->a, open_->b);
    open_->is_door = width <= kWidestDoor && jamb(open_->a, -1.0) && jamb(open_->b, 1.0);
    if (width >= kNarrowest) border.openings.push_back(*open_);
    open_.reset();
  }

  bool jamb(Vec2 end, double direction) const {
    const auto steps = static_cast<int>(kJamb / grid_.resolution);
    for (int i = 0; i <= steps; ++i) {
      if (across(grid_, end + (direction * i * grid_.resolution) * along_, normal_) == Cells::wall) return true;
    }
    return false;
  }

  const OccupancyGrid& grid_;
  const std::vector<Place>& places_;
  std::size_t room_;
  Vec2 begin_;
  double length_;
  Vec2 along_;
  Vec2 normal_;
  std::optional<Opening> open_;
};

}  // namespace

Border border_of(const OccupancyGrid& grid, const std::vector<Place>& places, std::size_t room) {
  Border border;
  const auto& polygon = places[room].polygon;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    if (distance(polygon[j], polygon[i]) > grid.resolution)
      Wall(grid, places, room, polygon[j], polygon[i]).add_to(border);
  }
  return border;
}

std::optional<std::size_t> room_at(const std::vector<Place>& places, Vec2 point) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_room(places[i]) || !SemanticMap::contains(places[i], point)) continue;
    if (!found || std::fabs(area(places[i])) < std::fabs(area(places[*found]))) found = i;
  }
  return found;
}

Vec2 along_walls(const Place& room, Vec2 heading) {
  const auto& polygon = room.polygon;
  Vec2 longest{1.0, 0.0};
  double length = 0.0;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    if (distance(polygon[j], polygon[i]) <= length) continue;
    length = distance(polygon[j], polygon[i]);
    longest = (1.0 / length) * (polygon[i] - polygon[j]);
  }
  const Vec2 left{-longest.y, longest.x};
  const double along = dot(heading, longest);
  const double across = dot(heading, left);
  if (std::fabs(along) >= std::fabs(across)) return along >= 0.0 ? longest : -1.0 * longest;
  return across >= 0.0 ? left : -1.0 * left;
}

}  // namespace threewe::agent
