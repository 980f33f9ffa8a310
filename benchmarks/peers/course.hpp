// What planners in C++ are given, and how they are timed: course.py says the same in Python.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "world.hpp"

namespace peers {

struct Point {
  double x, y;  // [m]
};
struct Query {
  Point from, to;
};

// Cells, of which those that no path may touch are blocked: obstacles have the robot's radius already. Cell (0, 0) has
// its lower left corner at (0, 0) m.
struct Course {
  std::string name;
  int width = 0, height = 0;  // [cells]
  double resolution = 0.0;    // [m]
  std::vector<std::uint8_t> free;
  std::vector<Query> queries;

  bool is_free(int x, int y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return false;
    return free[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] != 0;
  }
};

inline Course read_course(const std::filesystem::path& path) {
  Course course;
  std::ifstream file(path);
  std::string map;
  for (std::string word; file >> word;) {
    if (word == "course") {
      file >> course.name >> course.resolution >> map;
    } else if (word == "query") {
      Query& q = course.queries.emplace_back();
      file >> q.from.x >> q.from.y >> q.to.x >> q.to.y;
    }
  }
  std::ifstream cells(path.parent_path() / map, std::ios::binary);
  std::string magic;
  int most = 0;
  cells >> magic >> course.width >> course.height >> most;
  cells.get();
  course.free.resize(static_cast<std::size_t>(course.width) * static_cast<std::size_t>(course.height));
  cells.read(reinterpret_cast<char*>(course.free.data()), static_cast<std::streamsize>(course.free.size()));
  return course;
}

// Prints what each query took and the way that `plan(query)` finds, as JSON; none is no way.
template <class Plan>
void report_plans(const std::string& who, const std::string& differs, const Course& course, std::size_t queries,
                  const Plan& plan) {
  for (std::size_t i = 0; i < std::min(queries, course.queries.size()); ++i) {
    const double begin = cpu_seconds();
    const std::vector<Point> way = plan(course.queries[i]);
    const double seconds = cpu_seconds() - begin;
    std::printf(R"({"kind": "plan", "who": "%s", "differs": "%s", "size": "%s", "query": %zu, )", who.c_str(),
                differs.c_str(), course.name.c_str(), i);
    std::printf(R"("seconds": %.6g, "way": [)", seconds);
    for (std::size_t p = 0; p < way.size(); ++p) std::printf("%s[%.9g, %.9g]", p ? ", " : "", way[p].x, way[p].y);
    std::printf("]}\n");
    std::fflush(stdout);
  }
}

}  // namespace peers
