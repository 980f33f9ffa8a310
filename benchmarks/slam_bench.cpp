// What one scan costs: fitting it to the map, adding it to the map, finding it without a guess; and solving pose
// graphs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "core/exact.hpp"
#include "slam/branch_and_bound_matcher.hpp"
#include "slam/pose_graph.hpp"
#include "slam/scan_matcher.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

namespace {

using namespace threewe;

// What a lidar sees from a pose in office_v2.
std::vector<map::Beam> look(const scene::Slice& slice, const Pose2D& pose) {
  std::vector<map::Beam> beams;
  for (int i = 0; i < 360; ++i) {
    const double angle = i * exact::kPi / 180.0;
    const auto [s, c] = exact::sincos(angle);
    const double range = scene::cast_ray(slice, pose.position(), pose.theta + angle, 12.0);
    beams.push_back({{}, {c, s}, range, range < 12.0});
  }
  return beams;
}

std::vector<map::Beam> in_map(std::vector<map::Beam> beams, const Pose2D& pose) {
  for (map::Beam& b : beams) {
    b.origin = pose * b.origin;
    b.direction = rotate(b.direction, pose.theta);
  }
  return beams;
}

// A map of what is seen on the first metres of a drive.
map::LogOddsMap first_map(const scene::Slice& slice) {
  map::LogOddsMap map;
  for (int i = 0; i < 30; ++i) {
    const Pose2D pose{0.08 * i, 0.0, 0.02 * i};
    map.insert(in_map(look(slice, pose), pose));
  }
  return map;
}

void BM_match_scan(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  const map::LogOddsMap map = first_map(slice);
  const Pose2D pose{1.23, 0.0, 0.31};
  const std::vector<map::Beam> beams = look(slice, pose);
  const Pose2D guess{pose.x + 0.004, pose.y - 0.003, pose.theta + 0.002};
  const slam::Matrix4 prior = slam::Vector4{4e4, 4e4, 1e6, 4e3}.asDiagonal();
  for (auto _ : state) benchmark::DoNotOptimize(slam::match_scan(map, beams, {guess, 0.0}, prior, guess));
}
BENCHMARK(BM_match_scan)->Unit(benchmark::kMicrosecond);

void BM_search_pose(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  const map::LogOddsMap map = first_map(slice);
  const std::vector<map::Beam> beams = look(slice, {1.23, 0.0, 0.31});
  for (auto _ : state) benchmark::DoNotOptimize(slam::search_pose(map, beams, {1.1, 0.1, 0.2}, {}));
}
BENCHMARK(BM_search_pose)->Unit(benchmark::kMicrosecond);

void BM_insert_scan(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  map::LogOddsMap map = first_map(slice);
  const Pose2D pose{1.23, 0.0, 0.31};
  const std::vector<map::Beam> beams = in_map(look(slice, pose), pose);
  for (auto _ : state) map.insert(beams);
}
BENCHMARK(BM_insert_scan)->Unit(benchmark::kMicrosecond);

// All of office_v2, seen from wherever on a grid of 1.5 m there is room to stand.
const map::LogOddsMap& office_map() {
  static const map::LogOddsMap office = [] {
    const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
    map::LogOddsMap map;
    for (int column = 0; column < 26; ++column) {
      for (int row = 0; row < 20; ++row) {
        const double x = -19.0 + 1.5 * column;
        const double y = -14.0 + 1.5 * row;
        const std::vector<map::Beam> beams = look(slice, {x, y, 0.0});
        const auto blocked = [](const map::Beam& b) { return b.range < 0.3 || !b.hit; };
        if (std::none_of(beams.begin(), beams.end(), blocked)) map.insert(in_map(beams, {x, y, 0.0}));
      }
    }
    return map;
  }();
  return office;
}

void BM_build_branch_and_bound(benchmark::State& state) {
  const map::OccupancyGrid& grid = office_map().grid();
  for (auto _ : state) benchmark::DoNotOptimize(slam::BranchAndBoundMatcher(grid));
  state.counters["bytes"] = static_cast<double>(slam::BranchAndBoundMatcher(grid).bytes());
}
BENCHMARK(BM_build_branch_and_bound)->Unit(benchmark::kMillisecond);

// 5 m each way, 30 degrees: is the robot back at a submap that it left long ago?
void BM_branch_and_bound_loop(benchmark::State& state) {
  const slam::BranchAndBoundMatcher search(office_map().grid());
  const std::vector<map::Beam> beams = look(scene::Scene::load("office_v2").at_height(0.135), {1.23, 0.1, 0.31});
  const slam::BranchAndBoundMatcher::Window window{{-1.9, 3.3, 0.1}, {5.0, 5.0}, exact::kPi / 6};
  for (auto _ : state) benchmark::DoNotOptimize(search.find(beams, window, 0.55));
}
BENCHMARK(BM_branch_and_bound_loop)->Unit(benchmark::kMillisecond);

// The whole map and all headings: where am I?
void BM_branch_and_bound_everywhere(benchmark::State& state) {
  const slam::BranchAndBoundMatcher search(office_map().grid());
  const std::vector<map::Beam> beams = look(scene::Scene::load("office_v2").at_height(0.135), {1.23, 0.1, 0.31});
  for (auto _ : state) benchmark::DoNotOptimize(search.find(beams, search.everywhere(), 0.55));
}
BENCHMARK(BM_branch_and_bound_everywhere)->Unit(benchmark::kMillisecond);

// A walk to and fro over a square, in steps of 1 m, with odometry that turns a little too far, and a closure to the
// lane before from every second node.
slam::PoseGraph lanes(int nodes) {
  constexpr int kLane = 40;
  slam::PoseGraph graph;
  const auto truth = [](int i) {
    const int lane = i / kLane;
    const int along = lane % 2 == 0 ? i % kLane : kLane - 1 - i % kLane;
    return Pose2D{1.0 * along, 1.0 * lane, lane % 2 == 0 ? 0.0 : exact::kPi};
  };
  const Eigen::Matrix3d information = Eigen::Vector3d(1e3, 1e3, 1e4).asDiagonal();
  graph.add_node(truth(0), true);
  for (int i = 1; i < nodes; ++i) {
    Pose2D step = inverse(truth(i - 1)) * truth(i);
    step.theta += 0.0001;
    graph.add_node(graph.poses().back() * step);
    graph.add_constraint({i - 1, i, step, information});
    const int beside = 2 * kLane * (i / kLane) - 1 - i;
    if (i >= kLane && i % 2 == 0) {
      graph.add_constraint({beside, i, inverse(truth(beside)) * truth(i), information, true});
    }
  }
  return graph;
}

void BM_solve_pose_graph(benchmark::State& state) {
  const slam::PoseGraph start = lanes(static_cast<int>(state.range(0)));
  slam::GraphSolution solution;
  for (auto _ : state) {
    slam::PoseGraph graph = start;
    solution = graph.solve();
  }
  state.counters["iterations"] = solution.iterations;
  state.counters["converged"] = solution.converged ? 1.0 : 0.0;
}
BENCHMARK(BM_solve_pose_graph)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

// One more node and closure in a graph that was solved.
void BM_extend_pose_graph(benchmark::State& state) {
  slam::PoseGraph start = lanes(static_cast<int>(state.range(0)));
  start.solve();
  const int last = static_cast<int>(start.poses().size()) - 1;
  const Eigen::Matrix3d information = Eigen::Vector3d(1e3, 1e3, 1e4).asDiagonal();
  for (auto _ : state) {
    slam::PoseGraph graph = start;
    graph.add_node(graph.poses().back() * Pose2D{1.0, 0.0, 0.0});
    graph.add_constraint({last, last + 1, {1.0, 0.0, 0.0}, information});
    graph.add_constraint({last - 80, last + 1,
                          inverse(graph.poses()[static_cast<std::size_t>(last - 80)]) * graph.poses().back(),
                          information, true});
    benchmark::DoNotOptimize(graph.solve());
  }
}
BENCHMARK(BM_extend_pose_graph)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

void BM_pose_graph_covariance(benchmark::State& state) {
  slam::PoseGraph graph = lanes(static_cast<int>(state.range(0)));
  graph.solve();
  for (auto _ : state) benchmark::DoNotOptimize(slam::GraphCovariance(graph).between(5, 500));
}
BENCHMARK(BM_pose_graph_covariance)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
