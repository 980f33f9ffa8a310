#include "floor_plan.hpp"

#include <algorithm>
#include <utility>

namespace threewe::scene {
namespace {

constexpr int kNarrowestRoom = 260;          // [cm]
constexpr int kNarrowestOffice = 300;        // [cm], on both sides of a corridor
constexpr int kNarrowestWithCorridor = 940;  // [cm], of a building: one side of the corridor is wide enough to start in
constexpr int kDoorMargin = 22;              // [cm] of wall on both sides of a doorway

class Draughtsman {
 public:
  Draughtsman(double difficulty, RandomStream& random) : difficulty_(difficulty), random_(random) {}

  FloorPlan draw(int width, int depth) {
    const Box outline{0, 0, width, depth};
    draw_outline(outline);
    std::vector<Box> regions = {outline};
    if (std::min(width, depth) >= kNarrowestWithCorridor) regions = cut_corridor(outline);
    for (const Box& region : regions) split(region);
    connect();
    return std::move(plan_);
  }

 private:
  void draw_outline(const Box& b) {
    plan_.lines = {{true, b.y0, b.x0, b.x1, true},
                   {false, b.x1, b.y0, b.y1, true},
                   {true, b.y1, b.x0, b.x1, true},
                   {false, b.x0, b.y0, b.y1, true}};
  }

  // A corridor from end to end, along the longer side. Returns what lies beside it.
  std::vector<Box> cut_corridor(const Box& b) {
    const bool along_x = b.width() >= b.depth();
    const int wide = 10 * random_.between(17, 22);
    const int across = along_x ? b.depth() : b.width();
    const int low = 10 * random_.between(kNarrowestOffice / 10, (across - wide - kNarrowestOffice) / 10);
    const int high = low + wide;
    plan_.corridors = 1;
    if (along_x) {
      plan_.rooms.push_back({b.x0, low, b.x1, high});
      plan_.lines.push_back({true, low, b.x0, b.x1, false});
      plan_.lines.push_back({true, high, b.x0, b.x1, false});
      return {{b.x0, b.y0, b.x1, low}, {b.x0, high, b.x1, b.y1}};
    }
    plan_.rooms.push_back({low, b.y0, high, b.y1});
    plan_.lines.push_back({false, low, b.y0, b.y1, false});
    plan_.lines.push_back({false, high, b.y0, b.y1, false});
    return {{b.x0, b.y0, low, b.y1}, {high, b.y0, b.x1, b.y1}};
  }

  // Splits a region across its longer side until its parts are as small as rooms are.
  void split(const Box& b) {
    const bool across_x = b.width() >= b.depth();
    const int length = across_x ? b.width() : b.depth();
    if (length < 2 * kNarrowestRoom || length < 10 * random_.between(46, 72)) {
      plan_.rooms.push_back(b);
      return;
    }
    const int third = std::max(kNarrowestRoom, length / 3);
    const int cut = 10 * random_.between(third / 10, (length - third) / 10);
    if (across_x) {
      plan_.lines.push_back({false, b.x0 + cut, b.y0, b.y1, false});
      split({b.x0, b.y0, b.x0 + cut, b.y1});
      split({b.x0 + cut, b.y0, b.x1, b.y1});
    } else {
      plan_.lines.push_back({true, b.y0 + cut, b.x0, b.x1, false});
      split({b.x0, b.y0, b.x1, b.y0 + cut});
      split({b.x0, b.y0 + cut, b.x1, b.y1});
    }
  }

  // Two rooms and the stretch of wall between them.
  struct Neighbours {
    std::size_t a;
    std::size_t b;
    std::size_t line;
    int from;
    int to;
  };

  std::vector<Neighbours> neighbours() const {
    std::vector<Neighbours> all;
    for (std::size_t line = 0; line < plan_.lines.size(); ++line) {
      const WallLine& wall = plan_.lines[line];
      if (wall.outer) continue;
      for (std::size_t i = 0; i < plan_.rooms.size(); ++i) {
        for (std::size_t j = 0; j < plan_.rooms.size(); ++j) {
          const Box& a = plan_.rooms[i];
          const Box& b = plan_.rooms[j];
          if ((wall.along_x ? a.y1 : a.x1) != wall.at || (wall.along_x ? b.y0 : b.x0) != wall.at) continue;
          const int from = std::max({wall.from, wall.along_x ? a.x0 : a.y0, wall.along_x ? b.x0 : b.y0});
          const int to = std::min({wall.to, wall.along_x ? a.x1 : a.y1, wall.along_x ? b.x1 : b.y1});
          if (to - from >= 100 + 2 * kDoorMargin) all.push_back({i, j, line, from, to});
        }
      }
    }
    return all;
  }

  // Doorways: a tree over all rooms that begins at the corridor, then one in four of the other possible ones.
  void connect() {
    std::vector<Neighbours> candidates = neighbours();
    random_.shuffle(candidates);
    const auto corridors = static_cast<std::size_t>(plan_.corridors);
    std::stable_partition(candidates.begin(), candidates.end(),
                          [&](const Neighbours& n) { return n.a < corridors || n.b < corridors; });

    std::vector<bool> connected(plan_.rooms.size(), false);
    connected[0] = true;
    std::vector<bool> used(candidates.size(), false);
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t i = 0; i < candidates.size() && !grown; ++i) {
        const Neighbours& n = candidates[i];
        if (connected[n.a] == connected[n.b]) continue;
        connected[n.a] = connected[n.b] = used[i] = grown = true;
        open(n);
      }
    }
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!used[i] && random_.chance(0.25)) open(candidates[i]);
    }
  }

  void open(const Neighbours& n) {
    const int room = n.to - n.from - 2 * kDoorMargin;
    const bool wide = random_.chance(0.2) && room >= 200;
    const int narrowest = 90 - static_cast<int>(10.0 * difficulty_);
    const int width = wide ? 10 * random_.between(14, 20) : std::min(room, narrowest + 5 * random_.between(0, 2));
    const int at = random_.between(n.from + kDoorMargin + (width + 1) / 2, n.to - kDoorMargin - (width + 1) / 2);
    plan_.passages.push_back({n.a, n.b, n.line, at, width});
  }

  double difficulty_;
  RandomStream& random_;
  FloorPlan plan_;
};

}  // namespace

FloorPlan draw_floor_plan(int width, int depth, double difficulty, RandomStream& random) {
  return Draughtsman(difficulty, random).draw(width, depth);
}

}  // namespace threewe::scene
