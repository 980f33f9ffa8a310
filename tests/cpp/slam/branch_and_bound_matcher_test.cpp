// The search against brute force over the same poses, and against the truth of generated scenes.
#include "slam/branch_and_bound_matcher.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "core/exact.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "slam/branch_and_bound_cases.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::slam {
namespace {

using map::Beam;
using map::OccupancyGrid;
using testing::Place;
using testing::place_of;
using Window = BranchAndBoundMatcher::Window;
using Found = BranchAndBoundMatcher::Found;

// The slow, obvious twin: the score of every pose, then the best one by the stated rule, then the best elsewhere.
struct BruteForce {
  const OccupancyGrid& grid;
  std::vector<int> field = scores();

  std::vector<int> scores() const {
    std::vector<int> of(grid.data.size(), 0);
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const int score = dx == 0 && dy == 0 ? 255 : dx == 0 || dy == 0 ? 155 : 94;
            if (grid.at({x + dx, y + dy}) >= 65) of[grid.index({x, y})] = std::max(of[grid.index({x, y})], score);
          }
        }
      }
    }
    return of;
  }

  std::optional<Found> find(const std::vector<Beam>& scan, const Window& window, double least) const {
    std::vector<Vec2> hits;
    double farthest = 0.0;
    for (const Beam& b : scan) {
      const Vec2 hit = b.origin + b.range * b.direction;
      if (!b.hit || (!hits.empty() && distance(hits.back(), hit) < 0.5 * grid.resolution)) continue;
      hits.push_back(hit);
      farthest = std::max(farthest, norm(hit));
    }
    if (hits.empty()) return {};
    double step = std::clamp(2.0 * grid.resolution / farthest, 0.001, 0.1);
    int first = -static_cast<int>(window.turn / step);
    int last = -first;
    if (window.turn >= exact::kPi) {
      const int headings = static_cast<int>(std::ceil(2.0 * exact::kPi / step));
      step = 2.0 * exact::kPi / headings;
      first = -((headings - 1) / 2);
      last = first + headings - 1;
    }
    struct Pose {
      int sum, x, y, turn;
    };
    std::vector<Pose> poses;
    const int reach_x = static_cast<int>(window.reach.x / grid.resolution);
    const int reach_y = static_cast<int>(window.reach.y / grid.resolution);
    const double full = 255.0 * static_cast<double>(hits.size());
    for (int turn = first; turn <= last; ++turn) {
      std::vector<map::Cell> cells;
      const double heading = wrap_angle(window.center.theta + turn * step);
      for (const Vec2& h : hits) cells.push_back(grid.cell(window.center.position() + rotate(h, heading)));
      for (int y = -reach_y; y <= reach_y; ++y) {
        for (int x = -reach_x; x <= reach_x; ++x) {
          int sum = 0;
          for (const map::Cell c : cells) {
            const map::Cell at{c.x + x, c.y + y};
            sum += grid.contains(at) ? field[grid.index(at)] : 0;
          }
          if (sum >= least * full) poses.push_back({sum, x, y, turn});
        }
      }
    }
    if (poses.empty()) return {};
    const auto merit = [](const Pose& p) {
      return std::tuple(p.sum, -(p.x * p.x + p.y * p.y), -std::abs(p.turn), -p.y, -p.x, -p.turn);
    };
    const Pose best = *std::ranges::max_element(poses, {}, merit);
    int second = 0;
    for (const Pose& p : poses) {
      const bool turned = std::fabs(wrap_angle((p.turn - best.turn) * step)) > exact::kPi / 12;
      const double away = grid.resolution * exact::hypot(p.x - best.x, p.y - best.y);
      if (turned || away > 0.5) second = std::max(second, p.sum);
    }
    return Found{{window.center.x + best.x * grid.resolution, window.center.y + best.y * grid.resolution,
                  wrap_angle(window.center.theta + best.turn * step)},
                 best.sum / full,
                 second / full};
  }
};

OccupancyGrid random_grid(Draw& draw, int width, int height) {
  OccupancyGrid grid{width, height, draw(0.05, 0.3), draw.point(-20, 20), {}};
  const double share = draw(0.0, 0.3);
  for (int i = 0; i < width * height; ++i) grid.data.push_back(draw(0, 1) < share ? 100 : draw(0, 1) < 0.5 ? 0 : -1);
  return grid;
}

// A few hits anywhere, some of them far out of the map, some beams without any.
std::vector<Beam> random_scan(Draw& draw, double size) {
  std::vector<Beam> scan;
  const int beams = draw.whole(0, 30);
  for (int i = 0; i < beams; ++i) {
    const auto [s, c] = exact::sincos(draw(-4, 4));
    scan.push_back({draw.point(-0.2, 0.2), {c, s}, draw(0.0, size), draw(0, 1) < 0.9});
  }
  return scan;
}

bool same(const std::optional<Found>& a, const std::optional<Found>& b) {
  if (!a || !b) return !a && !b;
  return a->pose == b->pose && a->score == b->score && a->elsewhere == b->elsewhere;
}

bool is_near(const Pose2D& a, const Pose2D& b) {
  return distance(a.position(), b.position()) < 0.1 && std::fabs(wrap_angle(a.theta - b.theta)) < 0.03;
}

TEST_CASE("brute force finds the same pose and scores in random maps, ties included") {
  std::uint64_t found = 0;
  std::uint64_t ties = 0;
  for (std::uint64_t seed = 0; seed < cases(2500); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    // now and then wide enough for three levels
    const OccupancyGrid grid = random_grid(draw, seed % 100 == 0 ? 600 : draw.whole(1, 90), draw.whole(1, 40));
    const BranchAndBoundMatcher search(grid);
    const BruteForce brute{grid};
    const double r = grid.resolution;
    const std::vector<Beam> scan = random_scan(draw, 12 * r * (seed % 7 == 0 ? 20 : 1));
    const Vec2 center{grid.origin.x + draw(0, grid.width * r), grid.origin.y + draw(0, grid.height * r)};
    Window window{{center.x, center.y, draw(-3, 3)}, {draw(0, 15 * r), draw(0, 15 * r)}, draw(0.0, 0.6)};
    if (seed % 10 == 0) window.turn = draw(3.0, 3.3);
    if (seed % 20 == 0) window.reach.x = 80 * r;
    const double least = draw(-0.2, 0.8);
    const std::optional<Found> ours = search.find(scan, window, least);
    CHECK(same(ours, brute.find(scan, window, least)));
    found += ours ? 1U : 0U;
    ties += ours && ours->score == ours->elsewhere ? 1U : 0U;
  }
  CHECK(found > cases(1000));
  CHECK(ties > cases(50));
}

TEST_CASE("brute force finds the same in generated scenes, up to the whole map and all headings") {
  for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Place place = place_of(scene::generate(seed), draw, 6, seed % 3 == 0 ? 0.25 : 0.05);
    const BranchAndBoundMatcher search(place.map.grid());
    const BruteForce brute{place.map.grid()};
    for (int i = 0; i < 4; ++i) {
      const Pose2D truth = place.random_pose(draw);
      std::vector<Beam> scan = place.look(draw, truth);
      for (std::size_t k = 0; k < scan.size(); ++k) scan[k].hit &= k % 8 == 0;
      const bool everywhere = seed % 3 == 0;
      const Pose2D near{truth.x + draw(-0.3, 0.3), truth.y + draw(-0.3, 0.3), truth.theta + draw(-0.2, 0.2)};
      const Window window = everywhere ? search.everywhere() : Window{near, {draw(0, 0.7), draw(0, 0.7)}, 0.2};
      const double least = draw(0.0, 0.5);
      CHECK(same(search.find(scan, window, least), brute.find(scan, window, least)));
      if (everywhere) break;
    }
  }
}

TEST_CASE(
    "a search that stops and goes on, or whose copy does, finds the same and does no more at once than it is told") {
  for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Place place = place_of(scene::generate(seed), draw, 10);
    const BranchAndBoundMatcher map(place.map.grid());
    const std::vector<Beam> scan = place.look(draw, place.random_pose(draw));
    const double least = draw(0.2, 0.6);
    BranchAndBoundMatcher::Search search(map, scan, map.everywhere(), least);
    for (bool ended = false; !ended;) {
      std::int64_t work = draw.whole(1, 400'000);
      ended = search.go_on(work);
      CHECK(work > -20'000);  // the last step, a heading at most, is done to its end
      if (!ended) CHECK(work <= 0);
      if (draw.whole(0, 3) == 0) search = BranchAndBoundMatcher::Search(search);
    }
    CHECK(same(search.found(), map.find(scan, map.everywhere(), least)));
  }
}

TEST_CASE("a scan is found anywhere in its scene, with any heading") {
  int found = 0;
  double best_elsewhere = 0.0;
  for (std::uint64_t seed = 100; seed < 115; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Place place = place_of(scene::generate(seed), draw, 40);
    const BranchAndBoundMatcher search(place.map.grid());
    for (int i = 0; i < 4; ++i) {
      const Pose2D truth = place.random_pose(draw);
      const std::optional<Found> result = search.find(place.look(draw, truth), search.everywhere(), 0.4);
      found += result && is_near(result->pose, truth) ? 1 : 0;
      if (result) best_elsewhere = std::max(best_elsewhere, result->elsewhere / result->score);
    }
  }
  MESSAGE(found << " of 60 found; elsewhere at most " << best_elsewhere << " of the score");
  CHECK(found == 60);
}

TEST_CASE("a place that looks like another is told by the score elsewhere") {
  // two rooms alike, 8 m apart
  OccupancyGrid grid{260, 80, 0.05, {-1, -1}, std::vector<std::int8_t>(20800, 0)};
  for (const int left : {10, 170}) {
    for (int i = 0; i < 60; ++i) {
      for (const map::Cell c :
           {map::Cell{left + i, 10}, {left + i, 59}, {left, 10 + i % 50}, {left + 59, 10 + i % 50}}) {
        grid.data[grid.index(c)] = 100;
      }
    }
    for (int i = 0; i < 12; ++i) grid.data[grid.index({left + 20 + i, 30})] = 100;
  }
  const BranchAndBoundMatcher search(grid);
  std::vector<Beam> scan;
  for (int i = 0; i < 60; ++i) {
    for (const map::Cell c : {map::Cell{10 + i, 10}, {10 + i, 59}, {10, 10 + i % 50}, {22 + i % 12, 30}}) {
      const Vec2 to = grid.center(c) - Vec2{1.0, 1.0};
      scan.push_back({{}, (1.0 / norm(to)) * to, norm(to), true});
    }
  }
  const Window both{{1, 1, 0}, {9, 1}, 0.3};
  const std::optional<Found> result = search.find(scan, both, 0.5);
  REQUIRE(result);
  CHECK(distance(result->pose.position(), {1, 1}) < 0.1);
  CHECK(result->elsewhere > 0.97 * result->score);
  const std::optional<Found> one = search.find(scan, {{1, 1, 0}, {2, 1}, 0.3}, 0.5);
  REQUIRE(one);
  CHECK(one->elsewhere < 0.8 * one->score);
}

TEST_CASE("every set of vector instructions finds the same") {
  Draw draw(4);
  const Place place = place_of(scene::generate(4), draw, 10);
  const BranchAndBoundMatcher search(place.map.grid());
  const std::vector<Beam> scan = place.look(draw, place.random_pose(draw));
  const std::optional<Found> expected = search.find(scan, search.everywhere(), 0.3);
  REQUIRE(expected);
  for (const std::string& target : available_targets()) {
    CAPTURE(target);
    force_target(target);
    CHECK(same(search.find(scan, search.everywhere(), 0.3), expected));
  }
  force_target("");
}

TEST_CASE("a scan of more hits than one sum of 16 bits holds scores what each hit does") {
  OccupancyGrid grid{100, 100, 0.05, {0, 0}, std::vector<std::int8_t>(10000, 100)};
  std::vector<Beam> scan;
  for (int i = 0; i < 2000; ++i) {
    scan.push_back({{2.5 + (i % 2 == 0 ? 0.1 : -0.1), 2.5}, {1, 0}, 0.0, true});
  }
  const std::optional<Found> result = BranchAndBoundMatcher(grid).find(scan, {{}, {0.2, 0.2}, 0.0}, 1.0);
  REQUIRE(result);
  CHECK(result->score == 1.0);
  CHECK(result->pose == Pose2D{});
}

TEST_CASE("nothing is found without a map, without hits or without a pose that scores enough") {
  const std::vector<Beam> one_hit = {{{}, {1, 0}, 1.0, true}};
  CHECK(!BranchAndBoundMatcher(OccupancyGrid{}).find(one_hit, {{}, {1, 1}, 1.0}, 0.0));
  OccupancyGrid grid{10, 10, 0.05, {}, std::vector<std::int8_t>(100, 0)};
  const BranchAndBoundMatcher search(grid);
  CHECK(!search.find({}, search.everywhere(), 0.0));
  CHECK(!search.find(one_hit, search.everywhere(), 0.1));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK(!search.find(std::vector<Beam>{{{}, {1, 0}, kNan, true}}, search.everywhere(), 0.0));
}

TEST_CASE("a window that is none is refused") {
  const BranchAndBoundMatcher search(OccupancyGrid{10, 10, 0.05, {}, std::vector<std::int8_t>(100, 0)});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto find = [&](const Window& window, double least) { return search.find({}, window, least); };
  CHECK_THROWS_AS(find({{kNan, 0, 0}, {1, 1}, 1}, 0.5), ContractError);
  CHECK_THROWS_AS(find({{}, {-1, 1}, 1}, 0.5), ContractError);
  CHECK_THROWS_AS(find({{}, {1, kNan}, 1}, 0.5), ContractError);
  CHECK_THROWS_AS(find({{}, {1e6, 1}, 1}, 0.5), ContractError);
  CHECK_THROWS_AS(find({{}, {1, 1}, -1}, 0.5), ContractError);
  CHECK_THROWS_AS(find({{}, {1, 1}, 1}, kNan), ContractError);
  CHECK(!find({{}, {1, 1}, 1}, 0.5));
}

}  // namespace
}  // namespace threewe::slam
