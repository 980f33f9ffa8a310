// The graph against a dense solver with numeric derivatives, and against the truth of a drawn city.
#include "slam/pose_graph.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/manhattan.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::draw_manhattan;
using testing::Manhattan;

// The slow, obvious twin: dense matrices, derivatives by differences, the loss by its published formula.
struct Dense {
  std::vector<Pose2D> poses;
  std::vector<Constraint> constraints;
  std::vector<int> free;  // its nodes

  explicit Dense(const PoseGraph& graph)
      : poses(graph.poses()), constraints(graph.constraints().begin(), graph.constraints().end()) {
    for (int i = 0; std::cmp_less(i, poses.size()); ++i) {
      if (!graph.is_fixed(i)) free.push_back(i);
    }
  }
  static Vector3d off(const Constraint& c, const std::vector<Pose2D>& at) {
    const Pose2D seen = inverse(at[static_cast<std::size_t>(c.from)]) * at[static_cast<std::size_t>(c.to)];
    return {seen.x - c.from_from_to.x, seen.y - c.from_from_to.y, wrap_angle(seen.theta - c.from_from_to.theta)};
  }
  static double weight(const Constraint& c, double chi) {
    if (!c.doubtful) return 1.0;
    const double scale = std::min(1.0, 2.0 * 20.0 / (20.0 + chi));  // Agarwal et al. 2013, eq. 15
    return scale * scale;
  }
  // the integral of the weight
  static double loss(const Constraint& c, double chi) {
    return c.doubtful && chi > 20.0 ? 0.5 * (60.0 - 4.0 * 400.0 / (20.0 + chi)) : 0.5 * chi;
  }
  std::vector<Pose2D> moved(const VectorXd& by) const {
    std::vector<Pose2D> at = poses;
    for (std::size_t i = 0; i < free.size(); ++i) {
      Pose2D& p = at[static_cast<std::size_t>(free[i])];
      const auto k = static_cast<Eigen::Index>(3 * i);
      p = {p.x + by(k), p.y + by(k + 1), wrap_angle(p.theta + by(k + 2))};
    }
    return at;
  }
  double cost(const std::vector<Pose2D>& at) const {
    double sum = 0.0;
    for (const Constraint& c : constraints) sum += loss(c, off(c, at).dot(c.information * off(c, at)));
    return sum;
  }
  // Returns the matrix of the normal equations; `g` gets their right side.
  MatrixXd normal(VectorXd& g) const {
    const auto n = static_cast<Eigen::Index>(3 * free.size());
    MatrixXd h = MatrixXd::Zero(n, n);
    g = VectorXd::Zero(n);
    constexpr double kStep = 1e-6;
    for (const Constraint& c : constraints) {
      MatrixXd j(3, n);
      for (Eigen::Index k = 0; k < n; ++k) {
        const VectorXd by = kStep * VectorXd::Unit(n, k);
        const Vector3d change = off(c, moved(by)) - off(c, moved(-by));
        j.col(k) = Vector3d(change(0), change(1), wrap_angle(change(2))) / (2 * kStep);
      }
      const Vector3d r = off(c, poses);
      const Matrix3d omega = weight(c, r.dot(c.information * r)) * c.information;
      h += j.transpose() * omega * j;
      g += j.transpose() * omega * r;
    }
    return h;
  }
  // Gauss-Newton, each step halved until it goes down.
  double solve() {
    for (int i = 0; i < 200; ++i) {
      VectorXd g;
      const MatrixXd h = normal(g);
      VectorXd step = -h.ldlt().solve(g);
      const double before = cost(poses);
      while (cost(moved(step)) > before && step.norm() > 1e-9) step *= 0.5;
      if (step.norm() <= 1e-9) break;
      poses = moved(step);
    }
    return cost(poses);
  }
};

Matrix3d random_information(Draw& draw) {
  Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i / 3, i % 3) = draw(-10, 10);
  const Matrix3d square = root * root.transpose() + 20.0 * Matrix3d::Identity();
  return 0.5 * (square + square.transpose());
}

// A chain of nodes with links across, some of them doubtful and a few of these plainly wrong; one node or two fixed.
PoseGraph random_graph(Draw& draw, double noise, bool wrong_ones) {
  PoseGraph graph;
  const int nodes = draw.whole(2, 9);
  std::vector<Pose2D> truth;
  const int fixed = draw.whole(0, nodes - 1);
  for (int i = 0; i < nodes; ++i) {
    truth.push_back(draw.pose(-5, 5));
    const Pose2D near{truth.back().x + draw(-noise, noise), truth.back().y + draw(-noise, noise),
                      truth.back().theta + draw(-noise, noise)};
    const bool is_fixed = i == fixed || draw(0, 1) < 0.1;
    graph.add_node(is_fixed ? truth.back() : near, is_fixed);
  }
  const int links = draw.whole(0, 2 * nodes);
  for (int i = 1; i < nodes + links; ++i) {
    Constraint c{i - 1, i};
    if (i >= nodes) {
      c.from = draw.whole(0, nodes - 1);
      c.to = (c.from + draw.whole(1, nodes - 1)) % nodes;
      c.doubtful = draw(0, 1) < 0.5;
    }
    const Pose2D seen = inverse(truth[static_cast<std::size_t>(c.from)]) * truth[static_cast<std::size_t>(c.to)];
    c.from_from_to = {seen.x + draw(-noise, noise), seen.y + draw(-noise, noise), seen.theta + draw(-noise, noise)};
    if (wrong_ones && c.doubtful && draw(0, 1) < 0.3) c.from_from_to = draw.pose(-5, 5);
    c.information = random_information(draw);
    graph.add_constraint(c);
  }
  return graph;
}

double rms(const PoseGraph& graph, const std::vector<Pose2D>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double d = distance(graph.poses()[i].position(), truth[i].position());
    sum += d * d;
  }
  return exact::sqrt(sum / static_cast<double>(truth.size()));
}

// As a robot tells it: node after node where odometry puts it, with its constraints; solved now and then.
PoseGraph tell(const Manhattan& city, int every) {
  PoseGraph graph;
  std::size_t next = 0;
  for (int i = 0; std::cmp_less(i, city.truth.size()); ++i) {
    graph.add_node(i == 0 ? city.truth[0] : graph.poses().back() * city.constraints[next].from_from_to, i == 0);
    for (; next < city.constraints.size() && city.constraints[next].to == i; ++next) {
      graph.add_constraint(city.constraints[next]);
    }
    if (i % every == 0) graph.solve();
  }
  CHECK(graph.solve().converged);
  return graph;
}

std::string refusal(const auto& action) {
  try {
    action();
  } catch (const ContractError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("solutions and covariances are those of a dense solver with numeric derivatives") {
  std::uint64_t left_out = 0;
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const bool wrong_ones = seed % 2 == 1;
    PoseGraph graph = random_graph(draw, 0.05, wrong_ones);
    Dense dense(graph);
    const GraphSolution solution = graph.solve();
    REQUIRE(solution.converged);
    CHECK(solution.cost == doctest::Approx(dense.cost(graph.poses())).epsilon(1e-9));

    // wrong closures make several minima: what was found must be one of them
    dense.poses = wrong_ones ? graph.poses() : dense.poses;
    CHECK(solution.cost == doctest::Approx(dense.solve()).epsilon(1e-6));
    double apart = 0.0;
    for (std::size_t i = 0; i < graph.poses().size(); ++i) {
      const Pose2D off = inverse(graph.poses()[i]) * dense.poses[i];
      apart = std::max({apart, norm(off.position()), std::fabs(off.theta)});
    }
    CHECK(apart < 1e-3);

    dense.poses = graph.poses();
    VectorXd g;
    left_out += std::erase_if(dense.constraints, [&](const Constraint& c) {
      const Vector3d r = Dense::off(c, dense.poses);
      return Dense::weight(c, r.dot(c.information * r)) <= 1e-3;
    });
    const MatrixXd covariance = dense.normal(g).inverse();
    const GraphCovariance ours(graph);
    const auto block = [&](std::size_t a, std::size_t b) {
      return Matrix3d(covariance.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b)));
    };
    for (std::size_t i = 0; i < dense.free.size(); ++i) {
      const Matrix3d own = ours.of(dense.free[i]);
      CHECK((own - block(i, i)).norm() < 1e-6 * own.norm());
      // the pose of one in the frame of another, by differences
      const std::size_t k = (i + 1) % dense.free.size();
      if (k == i) continue;
      const int a = dense.free[i];
      const int b = dense.free[k];
      Eigen::Matrix<double, 3, 6> j;
      for (int c = 0; c < 6; ++c) {
        const auto seen = [&](double by) {
          std::vector<Pose2D> at = graph.poses();
          Pose2D& p = at[static_cast<std::size_t>(c < 3 ? a : b)];
          (c % 3 == 0 ? p.x : c % 3 == 1 ? p.y : p.theta) += by;
          return inverse(at[static_cast<std::size_t>(a)]) * at[static_cast<std::size_t>(b)];
        };
        const Pose2D more = seen(1e-6);
        const Pose2D less = seen(-1e-6);
        j.col(c) = Vector3d(more.x - less.x, more.y - less.y, wrap_angle(more.theta - less.theta)) / 2e-6;
      }
      Eigen::Matrix<double, 6, 6> joint;
      joint << block(i, i), block(i, k), block(k, i), block(k, k);
      const Matrix3d expected = j * joint * j.transpose();
      CHECK((ours.between(a, b) - expected).norm() < 1e-6 * expected.norm());
    }
  }
  CHECK(left_out > cases(300));
}

TEST_CASE("a robot that walks a city knows where it was, with wrong closures too") {
  for (const double share : {0.0, 0.1, 0.3}) {
    CAPTURE(share);
    const Manhattan city = draw_manhattan(11, {.nodes = 3500, .wrong_share = share});
    const PoseGraph graph = tell(city, 250);
    // from the truth, without the wrong ones: the best that anybody could know
    PoseGraph best;
    for (std::size_t i = 0; i < city.truth.size(); ++i) best.add_node(city.truth[i], i == 0);
    int believed = 0;
    int disbelieved = 0;
    int wrong = 0;
    for (std::size_t i = 0; i < city.constraints.size(); ++i) {
      if (!city.wrong[i]) best.add_constraint(city.constraints[i]);
      const double weight = graph.fit(static_cast<int>(i)).weight;
      believed += city.wrong[i] && weight > 0.01 ? 1 : 0;
      disbelieved += !city.wrong[i] && weight < 0.5 ? 1 : 0;
      wrong += city.wrong[i] ? 1 : 0;
    }
    const GraphSolution least = best.solve();
    double cost = 0.0;
    for (std::size_t i = 0; i < city.constraints.size(); ++i) {
      if (!city.wrong[i]) cost += 0.5 * graph.fit(static_cast<int>(i)).chi_squared;
    }
    const std::size_t closures = city.constraints.size() - city.truth.size() + 1;
    MESSAGE(closures << " closures, " << wrong << " of them wrong: error " << rms(graph, city.truth) << " m, at best "
                     << rms(best, city.truth) << " m");
    CHECK(wrong >= 0.8 * share * static_cast<double>(closures));
    CHECK(believed == 0);
    CHECK(disbelieved == 0);
    CHECK(rms(graph, city.truth) < rms(best, city.truth) + 0.01);
    CHECK(cost < 1.001 * least.cost);
  }
}

TEST_CASE("a city's cost is that of the dense oracle") {
  const Manhattan city = draw_manhattan(5, {.nodes = 60, .wrong_share = 0.2});
  PoseGraph graph = tell(city, 10);
  Dense dense(graph);
  const GraphSolution solution = graph.solve();
  CHECK(solution.cost == doctest::Approx(dense.solve()).epsilon(1e-8));
}

TEST_CASE("closures that count for nothing come to count when the rest says so") {
  // a closed square of four steps, whose odometry turned out 30 degrees wrong in one corner
  PoseGraph graph;
  graph.add_node({}, true);
  const Matrix3d sure = 1e4 * Matrix3d::Identity();
  for (int i = 1; i < 5; ++i) {
    graph.add_node({10.0 * i, 50, 0});
    Constraint c{i - 1, i, {10, 0, exact::kPi / 2}, sure};
    graph.add_constraint(c);
  }
  const int closure = graph.add_constraint({4, 0, {}, sure, true});
  CHECK(graph.fit(closure).weight < 1e-3);
  CHECK(graph.solve().converged);
  CHECK(graph.fit(closure).weight == 1.0);
  CHECK(norm(graph.poses()[4].position()) < 1e-6);
}

TEST_CASE("what has not changed costs nothing, and a copy goes on with the same bits") {
  const Manhattan city = draw_manhattan(3, {.nodes = 300, .wrong_share = 0.1});
  PoseGraph graph = tell(city, 30);
  CHECK(graph.solve().iterations == 0);
  PoseGraph copy = graph;
  CHECK(copy == graph);
  for (PoseGraph* g : {&graph, &copy}) {
    g->add_node({1, 2, 3});
    g->add_constraint({7, 300, {0.5, 0.2, 0.1}, 100.0 * Matrix3d::Identity()});
    CHECK(g->solve().iterations > 0);
  }
  CHECK(copy == graph);
  copy.set_pose(9, {0, 0, 0});
  CHECK(copy != graph);
  copy = graph;
  CHECK(copy == graph);

  // built again from what it tells
  PoseGraph again;
  for (int i = 0; std::cmp_less(i, graph.poses().size()); ++i) {
    again.add_node(graph.poses()[static_cast<std::size_t>(i)], graph.is_fixed(i));
  }
  for (const Constraint& c : graph.constraints()) again.add_constraint(c);
  again.solve(0);
  CHECK(again.poses() == graph.poses());
}

TEST_CASE("a fixed node stays where it was put, and takes the others along when it is moved") {
  PoseGraph graph;
  graph.add_node({1, 2, 0.5}, true);
  graph.add_node({0, 0, 0});
  graph.add_constraint({0, 1, {1, 0, 0}, Matrix3d::Identity()});
  graph.solve();
  CHECK(graph.poses()[0] == Pose2D{1, 2, 0.5});
  CHECK(distance(graph.poses()[1].position(), Pose2D{1, 2, 0.5} * Vec2{1, 0}) < 1e-6);
  graph.set_pose(0, {-3, 4, 3});
  graph.solve();
  CHECK(distance(graph.poses()[1].position(), Pose2D{-3, 4, 3} * Vec2{1, 0}) < 1e-6);
  CHECK(GraphCovariance(graph).of(0) == Matrix3d::Zero());
}

TEST_CASE("a node that only a contradicted closure holds is known poorly, not perfectly") {
  PoseGraph graph;
  graph.add_node({}, true);
  graph.add_node({1, 0, 0});
  const Matrix3d sure = 1e4 * Matrix3d::Identity();
  graph.add_constraint({0, 1, {10, 0, 0}, sure, true});
  graph.add_constraint({0, 1, {-10, 0, 0}, sure, true});
  graph.solve(0);
  const Matrix3d covariance = GraphCovariance(graph).of(1);
  CHECK(covariance(0, 0) > 1.0);
  CHECK(std::isfinite(covariance(0, 0)));
}

TEST_CASE("an empty graph, or one of fixed nodes alone, is solved already") {
  PoseGraph graph;
  CHECK(graph.solve().converged);
  graph.add_node({}, true);
  graph.add_node({1, 0, 0}, true);
  graph.add_constraint({0, 1, {2, 0, 0}, Matrix3d::Identity()});
  const GraphSolution solution = graph.solve();
  CHECK(solution.converged);
  CHECK(solution.cost == doctest::Approx(0.5));
}

TEST_CASE("what makes no sense is refused, with the reason, and changes nothing") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PoseGraph graph;
  graph.add_node({}, true);
  graph.add_node({1, 0, 0});
  graph.add_constraint({0, 1, {1, 0, 0}});
  const PoseGraph before = graph;
  const auto constraint = [&](const Constraint& c) { return refusal([&] { graph.add_constraint(c); }); };
  CHECK(refusal([&] { graph.add_node({kNan, 0, 0}); }) == "pose graph, node 2: its pose must be finite");
  CHECK(constraint({0, 2, {}}) == "pose graph, constraint 1: it joins nodes 0 and 2; there are 2, and it takes two");
  CHECK(constraint({1, 1, {}}).find("joins nodes 1 and 1") != std::string::npos);
  CHECK(constraint({-1, 1, {}}).find("joins nodes -1 and 1") != std::string::npos);
  CHECK(constraint({0, 1, {0, kNan, 0}}) == "pose graph, constraint 1: numbers must be finite");
  Matrix3d m = Matrix3d::Identity();
  m(0, 1) = 0.5;
  CHECK(constraint({0, 1, {}, m}).find("symmetric") != std::string::npos);
  m(1, 0) = 0.5, m(2, 2) = 0.0;
  CHECK(constraint({0, 1, {}, m}).find("positive definite") != std::string::npos);
  m(2, 2) = 1.0, m(0, 1) = m(1, 0) = 1.0;
  CHECK(constraint({0, 1, {}, m}).find("positive definite") != std::string::npos);
  m(2, 2) = kNan;
  CHECK(constraint({0, 1, {}, m}).find("finite") != std::string::npos);
  CHECK(graph == before);

  graph.add_node({5, 5, 0});
  graph.add_constraint({1, 0, {}});
  CHECK(refusal([&] { graph.solve(); }).find("from node 2 to a fixed node") != std::string::npos);
  CHECK(refusal([&] { GraphCovariance covariance(graph); }).find("from node 2") != std::string::npos);
  graph.add_constraint({2, 1, {}});
  CHECK(graph.solve().converged);
}

}  // namespace
}  // namespace threewe::slam
