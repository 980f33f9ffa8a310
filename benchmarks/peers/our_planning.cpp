// Our planner on the journeys of nav_bench.cpp; writes them for the peers, and judges the ways that they find.
#include <iostream>
#include <optional>
#include <sstream>
#include <string_view>

#include "../course.hpp"
#include "course.hpp"

namespace {

using namespace threewe;

constexpr std::size_t kShortJourneys = 10;

Course course_of(std::string_view name) { return name == "campus" ? campus() : campus_window(kShortJourneys); }

void write(const Course& course, const std::string& name, const std::filesystem::path& folder) {
  std::ofstream map(folder / (name + ".pgm"), std::ios::binary);
  map << "P5 " << course.grid.width << ' ' << course.grid.height << " 255\n";
  for (int y = 0; y < course.grid.height; ++y) {
    for (int x = 0; x < course.grid.width; ++x) {
      const map::Cell c = course.costmap.cell(course.grid.center({x, y}));
      map.put(static_cast<char>(course.costmap.weight(c) == map::Costmap::kLethal ? 0 : 255));
    }
  }
  std::ofstream file(folder / (name + ".txt"));
  file.precision(17);
  file << "course " << name << ' ' << course.grid.resolution << ' ' << name << ".pgm\n";
  for (const Journey& j : course.journeys) {
    file << "query " << j.from.x << ' ' << j.from.y << ' ' << j.to.x << ' ' << j.to.y << '\n';
  }
}

void report(const std::string& who, const std::string& differs, const peers::Course& given, const map::Costmap& costmap,
            bool keep_tables) {
  std::optional<nav::Planner> planner;
  const auto plan = [&](const peers::Query& q) {
    if (!planner || !keep_tables) planner.emplace();
    std::vector<peers::Point> way;
    for (const Vec2 p : planner->plan(costmap, {q.from.x, q.from.y}, {q.to.x, q.to.y}, 0.25).points) {
      way.push_back({p.x, p.y});
    }
    return way;
  };
  if (keep_tables) {
    for (const peers::Query& q : given.queries) plan(q);
  }
  peers::report_plans(who, differs, given, given.queries.size(), plan);
}

void time(const Course& course, const peers::Course& given) {
  report("ours", "any angle, dear near obstacles; tables of tiles kept from plan to plan", given, course.costmap, true);
  report("ours, the first plan", "the same without any table", given, course.costmap, false);
  map::Costmap even({.near_weight = 0});
  even.update(course.grid, {}, {});
  report("ours, the shortest way", "nothing is dear near obstacles; tables kept", given, even, true);
}

// Of each way, a line `x y x y ...`, its length [m], its cost [m times weight] and how much of it [m] is blocked.
void judge(const Course& course) {
  constexpr double kStep = 0.005;  // [m]
  const map::Costmap::Settings settings;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::vector<Vec2> way;
    for (Vec2 p; words >> p.x >> p.y;) way.push_back(p);
    double cost = 0.0;
    double blocked = 0.0;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const Vec2 along = way[i] - way[i - 1];
      const int pieces = std::max(1, static_cast<int>(std::ceil(distance(way[i], way[i - 1]) / kStep)));
      const double piece = distance(way[i], way[i - 1]) / pieces;
      for (int k = 0; k < pieces; ++k) {
        const Vec2 p = way[i - 1] + ((k + 0.5) / pieces) * along;
        const map::Costmap::Weight w = course.costmap.weight(course.costmap.cell(p));
        if (w == map::Costmap::kLethal) blocked += piece;
        cost += piece * (w == map::Costmap::kLethal ? map::Costmap::kFree + settings.near_weight : w);
      }
    }
    std::cout << nav::path_length(way) << ' ' << cost << ' ' << blocked << '\n';
  }
}

}  // namespace

// our_planning FOLDER: writes the courses there, and times ours. our_planning --judge NAME: judges ways.
int main(int, char** argv) {
  if (std::string_view(argv[1]) == "--judge") {
    judge(course_of(argv[2]));
    return 0;
  }
  const std::filesystem::path folder = argv[1];
  for (const std::string name : {"campus", "window"}) {
    const Course course = course_of(name);
    write(course, name, folder);
    time(course, peers::read_course(folder / (name + ".txt")));
  }
}
