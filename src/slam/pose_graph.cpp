#include "slam/pose_graph.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kFirstDamping = 1e-5;  // of the diagonal
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e9;
constexpr double kSmallStep = 1e-7;   // [m] and [rad]: nothing moves by more any more
constexpr double kSmallGain = 1e-10;  // of the cost
// Of chi squared: of right closures, whose three numbers are off by chance alone, one in 6,000 is beyond.
constexpr double kLossWidth = 20.0;
constexpr double kWeak = 1e-3;    // a constraint that counts for less joins nothing ...
constexpr double kStrong = 1e-2;  // ... until it counts for more

// Of a block's three rows or columns.
constexpr Eigen::Index first_of(int block) { return 3 * static_cast<Eigen::Index>(block); }

struct Loss {
  double cost = 0.0;    // half of it, as for chi squared
  double weight = 1.0;  // its derivative
};

// Dynamic covariance scaling (Agarwal et al. 2013), as the loss whose weights are the square of its scale: quadratic up
// to kLossWidth, then levelling off at 1.5 kLossWidth. Measured on walks of 1,000 nodes through a city, solved every
// 10, of which 0, 10 and 30 % of the closures are wrong (6 seeds each; mean error [m], and walks that ended in a wrong
// minimum):
//                      odometry 1 cm, 2 mrad a step                3 cm, 10 mrad a step
//   this               0.20  0.22  0.31   0 of 18                  0.65  0.76  1.34   0 of 18
//   this, width 5      0.20  0.23  0.33   0                        4.39  2.18  3.37   11
//   Cauchy, width 20   0.20  0.25  0.35   0                        0.64  2.07  too slow
//   Cauchy, width 5    0.21  0.24  0.35   0                        0.62  0.99  3.68   0
//   Geman-McClure, 5   0.24  0.32  0.38   1                        5.69  4.72  6.21   17
// Cauchy's wrong closures go on pulling; those of Geman-McClure lose their hold of right ones after a long drift, as
// does a narrow width.
Loss loss_of(const Constraint& constraint, double chi_squared) {
  if (!constraint.doubtful) return {0.5 * chi_squared, 1.0};
  if (chi_squared <= kLossWidth) return {0.5 * chi_squared, 1.0};
  const double scale = 2.0 * kLossWidth / (kLossWidth + chi_squared);
  return {0.5 * kLossWidth * (3.0 - 2.0 * scale), scale * scale};
}

// By how much a constraint is off, in the frame of its `from`, and how that changes with the (x, y, theta) of both.
struct Residual {
  Vector3d value;
  Matrix3d by_from;
  Matrix3d by_to;
};

Residual residual(const Constraint& c, const Pose2D& from, const Pose2D& to) {
  const auto [s, k] = exact::sincos(from.theta);
  const Vec2 d = to.position() - from.position();
  const Vec2 seen{k * d.x + s * d.y, k * d.y - s * d.x};
  const Pose2D& z = c.from_from_to;
  Residual r;
  r.value << seen.x - z.x, seen.y - z.y, wrap_angle(to.theta - from.theta - z.theta);
  r.by_to << k, s, 0.0, -s, k, 0.0, 0.0, 0.0, 1.0;
  r.by_from = -r.by_to;
  r.by_from(0, 2) = seen.y;
  r.by_from(1, 2) = -seen.x;
  return r;
}

double chi_squared(const Constraint& c, const Vector3d& off) { return off.dot(c.information * off); }

Fit fit_of(const Constraint& c, const std::vector<Pose2D>& poses) {
  const Vector3d off =
      residual(c, poses[static_cast<std::size_t>(c.from)], poses[static_cast<std::size_t>(c.to)]).value;
  const double chi = chi_squared(c, off);
  return {chi, loss_of(c, chi).weight};
}

double cost_of(std::span<const Constraint> constraints, const std::vector<Pose2D>& poses) {
  double cost = 0.0;
  for (const Constraint& c : constraints) cost += loss_of(c, fit_of(c, poses).chi_squared).cost;
  return cost;
}

Pose2D moved(const Pose2D& pose, const Vector3d& by) {
  return {pose.x + by(0), pose.y + by(1), wrap_angle(pose.theta + by(2))};
}

// Which constraints count for something. The others are kept out of the pattern of the equations: closures between
// random places would fill the factors.
std::vector<char> strong_ones(std::span<const Constraint> constraints, const std::vector<Pose2D>& poses) {
  std::vector<char> strong;
  strong.reserve(constraints.size());
  for (const Constraint& c : constraints) {
    strong.push_back(!c.doubtful || fit_of(c, poses).weight > kWeak ? 1 : 0);
  }
  return strong;
}

// Does every node hang together with a fixed one? Returns one that does not, or -1.
int loose_node(std::span<const Constraint> constraints, const std::vector<char>& fixed) {
  std::vector<int> parent(fixed.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int node) {
    const auto up = [&parent](int n) -> int& { return parent[static_cast<std::size_t>(n)]; };
    while (up(node) != node) node = up(node) = up(up(node));
    return node;
  };
  for (const Constraint& c : constraints) parent[static_cast<std::size_t>(root(c.from))] = root(c.to);
  std::vector<char> held(fixed.size(), 0);
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i] != 0) held[static_cast<std::size_t>(root(static_cast<int>(i)))] = 1;
  }
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (held[static_cast<std::size_t>(root(static_cast<int>(i)))] == 0) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

// The normal equations of all free nodes, in an order that keeps their factors sparse. Nodes are blocks of three
// numbers; of the symmetric matrix the upper triangle is kept.
class PoseGraph::Normal {
 public:
  Normal(std::span<const Constraint> constraints, const std::vector<char>& fixed, std::vector<char> strong)
      : strong_(std::move(strong)) {
    if (const int loose = loose_node(constraints, fixed); loose >= 0) {
      throw ContractError(
          fmt::format("pose graph: no constraints lead from node {} to a fixed node, so that it might lie anywhere; "
                      "fix one node of each part that hangs together",
                      loose));
    }
    find_order(constraints, fixed);
    lay_out(constraints);
    if (free_ > 0) ldlt_.analyzePattern(h_);
  }

  const std::vector<char>& strong() const { return strong_; }
  // Whether a constraint that had counted for nothing now does.
  bool is_out_of_date() const { return out_of_date_; }
  // Fills in the equations at `poses`; returns the cost there.
  double linearize(std::span<const Constraint> constraints, const std::vector<Pose2D>& poses);
  // The step that they lead to when their diagonal counts (1 + damping) times.
  Eigen::VectorXd step(double damping);
  void factorize() {
    if (free_ > 0) ldlt_.factorize(h_);
  }
  // The three numbers of a node within a step; zero for a fixed one.
  Vector3d of(const Eigen::VectorXd& step, std::size_t node) const {
    return place_[node] < 0 ? Vector3d::Zero() : Vector3d(step.segment<3>(first_of(place_[node])));
  }
  // Of the columns of the inverse that belong to the node, what is above the diagonal of the factors: L^-1 E. A list of
  // (row, three numbers); any two give a block of the inverse.
  using Column = std::vector<std::pair<int, Eigen::RowVector3d>>;
  Column column(int node) const;
  Matrix3d block(const Column& a, const Column& b) const;

 private:
  using Ldlt = Eigen::SimplicialLDLT<Sparse, Eigen::Upper, Eigen::NaturalOrdering<int>>;

  void find_order(std::span<const Constraint> constraints, const std::vector<char>& fixed);
  void lay_out(std::span<const Constraint> constraints);
  void add(int row_place, int column_place, int slot, const Matrix3d& block);

  std::vector<char> strong_;  // of each constraint: whether it joins its nodes in the pattern
  std::vector<int> place_;    // of each node in the order, -1 for fixed ones
  int free_ = 0;
  std::vector<int> slot_;      // of each constraint in its block column: how many blocks are above it
  std::vector<int> diagonal_;  // the same for the diagonal block of each column
  bool out_of_date_ = false;
  Sparse h_;
  Eigen::VectorXd g_;
  Ldlt ldlt_;
};

void PoseGraph::Normal::find_order(std::span<const Constraint> constraints, const std::vector<char>& fixed) {
  for (const char f : fixed) place_.push_back(f != 0 ? -1 : free_++);
  std::vector<Eigen::Triplet<double>> joined;
  for (int i = 0; i < free_; ++i) joined.emplace_back(i, i, 1.0);
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const int a = place_[static_cast<std::size_t>(constraints[i].from)];
    const int b = place_[static_cast<std::size_t>(constraints[i].to)];
    if (strong_[i] != 0 && a >= 0 && b >= 0) joined.emplace_back(std::min(a, b), std::max(a, b), 1.0);
  }
  Sparse pattern(free_, free_);
  pattern.setFromTriplets(joined.begin(), joined.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Upper>(), order);
  std::vector<int> rank(static_cast<std::size_t>(free_));
  for (int i = 0; i < free_; ++i) rank[static_cast<std::size_t>(order.indices()(i))] = i;
  for (int& p : place_) p = p < 0 ? -1 : rank[static_cast<std::size_t>(p)];
}

// The pattern of the matrix, and where in it each constraint adds.
void PoseGraph::Normal::lay_out(std::span<const Constraint> constraints) {
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(free_));
  for (int i = 0; i < free_; ++i) rows[static_cast<std::size_t>(i)].push_back(i);
  const auto pair_of = [&](std::size_t i) {
    const Constraint& c = constraints[i];
    if (strong_[i] == 0) return std::pair{-1, -1};
    const auto pair = std::minmax({place_[static_cast<std::size_t>(c.from)], place_[static_cast<std::size_t>(c.to)]});
    return std::pair{pair.first, pair.second};
  };
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    if (const auto [low, high] = pair_of(i); low >= 0) rows[static_cast<std::size_t>(high)].push_back(low);
  }
  for (std::vector<int>& column : rows) {
    std::ranges::sort(column);
    column.erase(std::unique(column.begin(), column.end()), column.end());
    diagonal_.push_back(static_cast<int>(column.size()) - 1);
  }
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const auto [low, high] = pair_of(i);
    const auto find = [&](int row, const std::vector<int>& column) {
      return static_cast<int>(std::ranges::lower_bound(column, row) - column.begin());
    };
    slot_.push_back(low >= 0 ? find(low, rows[static_cast<std::size_t>(high)]) : -1);
  }

  if (free_ == 0) return;  // Eigen's matrices cannot be compressed when they are empty
  h_.resize(first_of(free_), first_of(free_));
  std::vector<int> sizes;
  for (const std::vector<int>& column : rows) {
    for (int k = 0; k < 3; ++k) sizes.push_back(3 * static_cast<int>(column.size()) - 2 + k);
  }
  h_.reserve(sizes);
  for (int column = 0; column < free_; ++column) {
    for (int k = 0; k < 3; ++k) {
      for (const int row : rows[static_cast<std::size_t>(column)]) {
        for (int i = 0; i < (row == column ? k + 1 : 3); ++i) h_.insert(3 * row + i, 3 * column + k) = 1.0;
      }
    }
  }
  h_.makeCompressed();
  g_.resize(first_of(free_));
}

// Adds a block to the matrix, or its transpose where that is what lies above the diagonal.
void PoseGraph::Normal::add(int row_place, int column_place, int slot, const Matrix3d& block) {
  const int column = std::max(row_place, column_place);
  for (int k = 0; k < 3; ++k) {
    double* value = h_.valuePtr() + h_.outerIndexPtr()[first_of(column) + k] + first_of(slot);
    const int rows = row_place == column_place ? k + 1 : 3;
    for (int i = 0; i < rows; ++i) value[i] += row_place <= column_place ? block(i, k) : block(k, i);
  }
}

double PoseGraph::Normal::linearize(std::span<const Constraint> constraints, const std::vector<Pose2D>& poses) {
  std::fill_n(h_.valuePtr(), h_.nonZeros(), 0.0);
  g_.setZero();
  double cost = 0.0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& c = constraints[i];
    const auto from = static_cast<std::size_t>(c.from);
    const auto to = static_cast<std::size_t>(c.to);
    const Residual r = residual(c, poses[from], poses[to]);
    const Loss loss = loss_of(c, chi_squared(c, r.value));
    cost += loss.cost;
    // what does not join counts twice on the diagonal: no less than all of it (Cauchy-Schwarz), and steps still go down
    const Matrix3d weight = loss.weight * c.information;
    const double share = strong_[i] != 0 ? 1.0 : 2.0;
    if (strong_[i] == 0 && loss.weight > kStrong) out_of_date_ = true;
    const Matrix3d from_weighted = r.by_from.transpose() * weight;
    const Matrix3d to_weighted = r.by_to.transpose() * weight;
    const int a = place_[from];
    const int b = place_[to];
    if (a >= 0) {
      add(a, a, diagonal_[static_cast<std::size_t>(a)], share * from_weighted * r.by_from);
      g_.segment<3>(first_of(a)) += from_weighted * r.value;
    }
    if (b >= 0) {
      add(b, b, diagonal_[static_cast<std::size_t>(b)], share * to_weighted * r.by_to);
      g_.segment<3>(first_of(b)) += to_weighted * r.value;
    }
    if (slot_[i] >= 0) add(a, b, slot_[i], from_weighted * r.by_to);
  }
  return cost;
}

Eigen::VectorXd PoseGraph::Normal::step(double damping) {
  const auto last = [this](int column) { return h_.valuePtr() + h_.outerIndexPtr()[column + 1] - 1; };
  Eigen::VectorXd diagonal(3 * free_);
  for (int i = 0; i < 3 * free_; ++i) {
    diagonal(i) = *last(i);
    *last(i) += damping * diagonal(i);
  }
  ldlt_.factorize(h_);
  for (int i = 0; i < 3 * free_; ++i) *last(i) = diagonal(i);
  return ldlt_.solve(-g_);
}

// Only what lies on the way from a node to the root of the elimination tree is not zero (Davis 2006, ch. 4).
PoseGraph::Normal::Column PoseGraph::Normal::column(int node) const {
  const int place = place_[static_cast<std::size_t>(node)];
  if (place < 0) return {};
  const Sparse& l = ldlt_.matrixL().nestedExpression();
  Column way;
  for (int row = 3 * place; row >= 0;) {
    Eigen::RowVector3d value = Eigen::RowVector3d::Zero();
    if (row < 3 * place + 3) value(row - 3 * place) = 1.0;
    way.emplace_back(row, value);
    const Sparse::InnerIterator next(l, row);
    row = next ? static_cast<int>(next.row()) : -1;
  }
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::size_t k = i;
    for (Sparse::InnerIterator it(l, way[i].first); it; ++it) {
      while (way[k].first < it.row()) ++k;
      way[k].second -= it.value() * way[i].second;
    }
  }
  return way;
}

Matrix3d PoseGraph::Normal::block(const Column& a, const Column& b) const {
  Matrix3d sum = Matrix3d::Zero();
  const auto& d = ldlt_.vectorD();
  for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
    if (a[i].first == b[k].first) {
      sum += (1.0 / d(a[i].first)) * a[i].second.transpose() * b[k].second;
      ++i, ++k;
    } else {
      ++(a[i].first < b[k].first ? i : k);
    }
  }
  return sum;
}

PoseGraph::PoseGraph() = default;
PoseGraph::~PoseGraph() = default;
PoseGraph::PoseGraph(PoseGraph&& other) noexcept = default;
PoseGraph::PoseGraph(const PoseGraph& other)
    : poses_(other.poses_), fixed_(other.fixed_), constraints_(other.constraints_), solved_(other.solved_) {}
PoseGraph& PoseGraph::operator=(PoseGraph other) noexcept {
  poses_.swap(other.poses_);
  fixed_.swap(other.fixed_);
  constraints_.swap(other.constraints_);
  solved_ = other.solved_;
  normal_.swap(other.normal_);
  return *this;
}

int PoseGraph::add_node(const Pose2D& guess, bool fixed) {
  const int node = static_cast<int>(poses_.size());
  poses_.emplace_back();
  fixed_.push_back(fixed ? 1 : 0);
  try {
    set_pose(node, guess);
  } catch (const ContractError&) {
    poses_.pop_back();
    fixed_.pop_back();
    throw;
  }
  normal_.reset();
  return node;
}

int PoseGraph::add_constraint(const Constraint& c) {
  const int index = static_cast<int>(constraints_.size());
  const auto refuse = [index](const std::string& why) {
    throw ContractError(fmt::format("pose graph, constraint {}: {}", index, why));
  };
  const auto exists = [this](int node) { return node >= 0 && std::cmp_less(node, poses_.size()); };
  if (!exists(c.from) || !exists(c.to) || c.from == c.to) {
    refuse(fmt::format("it joins nodes {} and {}; there are {}, and it takes two", c.from, c.to, poses_.size()));
  }
  if (!is_finite(c.from_from_to) || !c.information.allFinite()) refuse("numbers must be finite");
  if (c.information != c.information.transpose()) refuse("the information matrix must be symmetric");
  // each direction on the scale of its own axis, so that metres and radians compare
  const Vector3d diagonal = c.information.diagonal();
  constexpr double kLeast = 1e-9;
  bool tells = diagonal.minCoeff() > 0.0;
  if (tells) {
    const Vector3d scale = diagonal.cwiseSqrt().cwiseInverse();
    const Matrix3d scaled = scale.asDiagonal() * c.information * scale.asDiagonal();
    tells = (scaled - kLeast * Matrix3d::Identity()).llt().info() == Eigen::Success;
  }
  if (!tells) refuse("the information matrix must be positive definite; where nothing is known, say so little");
  constraints_.push_back(c);
  constraints_.back().from_from_to.theta = wrap_angle(c.from_from_to.theta);
  normal_.reset();
  solved_ = false;
  return index;
}

void PoseGraph::set_pose(int node, const Pose2D& pose) {
  if (!is_finite(pose)) throw ContractError(fmt::format("pose graph, node {}: its pose must be finite", node));
  poses_[static_cast<std::size_t>(node)] = {pose.x, pose.y, wrap_angle(pose.theta)};
  solved_ = false;
}

Fit PoseGraph::fit(int constraint) const { return fit_of(constraints_[static_cast<std::size_t>(constraint)], poses_); }

// The pattern is a function of the present estimate alone, not of how it came about.
void PoseGraph::update_pattern() {
  std::vector<char> strong = strong_ones(constraints_, poses_);
  if (!normal_ || normal_->strong() != strong) {
    normal_ = std::make_unique<Normal>(constraints_, fixed_, std::move(strong));
  }
}

GraphSolution PoseGraph::solve(int max_iterations) {
  if (std::ranges::find(fixed_, 0) == fixed_.end()) solved_ = true;  // nothing can move
  if (solved_) return {true, 0, cost_of(constraints_, poses_)};
  update_pattern();
  GraphSolution solution;
  solution.cost = normal_->linearize(constraints_, poses_);
  double damping = kFirstDamping;
  std::vector<Pose2D> tried(poses_.size());
  while (!solution.converged && solution.iterations < max_iterations && damping < kMostDamping) {
    const Eigen::VectorXd step = normal_->step(damping);
    ++solution.iterations;
    for (std::size_t i = 0; i < poses_.size(); ++i) tried[i] = moved(poses_[i], normal_->of(step, i));
    const double cost = cost_of(constraints_, tried);
    solution.converged = step.isZero(0.0) || step.cwiseAbs().maxCoeff() < kSmallStep;
    if (!(cost <= solution.cost)) {
      damping *= 10.0;
      continue;
    }
    solution.converged = solution.converged || solution.cost - cost <= kSmallGain * solution.cost;
    poses_.swap(tried);
    damping = std::max(0.1 * damping, kLeastDamping);
    solution.cost = normal_->linearize(constraints_, poses_);
    if (normal_->is_out_of_date()) {
      update_pattern();
      solution.cost = normal_->linearize(constraints_, poses_);
    }
  }
  solved_ = solution.converged;
  return solution;
}

GraphCovariance::GraphCovariance(const PoseGraph& graph) : poses_(graph.poses_) {
  // what counts for nothing is left out, unless some node has no other hold
  const std::vector<char> strong = strong_ones(graph.constraints_, poses_);
  std::vector<Constraint> counted;
  for (std::size_t i = 0; i < strong.size(); ++i) {
    if (strong[i] != 0) counted.push_back(graph.constraints_[i]);
  }
  if (loose_node(counted, graph.fixed_) >= 0) counted = graph.constraints_;
  normal_ = std::make_unique<PoseGraph::Normal>(counted, graph.fixed_, std::vector<char>(counted.size(), 1));
  normal_->linearize(counted, poses_);
  normal_->factorize();
}
GraphCovariance::~GraphCovariance() = default;

Eigen::Matrix3d GraphCovariance::of(int node) const {
  const auto column = normal_->column(node);
  return normal_->block(column, column);
}

Eigen::Matrix3d GraphCovariance::between(int from, int to) const {
  const auto a = normal_->column(from);
  const auto b = normal_->column(to);
  const Residual r = residual({}, poses_[static_cast<std::size_t>(from)], poses_[static_cast<std::size_t>(to)]);
  const Matrix3d across = r.by_from * normal_->block(a, b) * r.by_to.transpose();
  return r.by_from * normal_->block(a, a) * r.by_from.transpose() + across + across.transpose() +
         r.by_to * normal_->block(b, b) * r.by_to.transpose();
}

}  // namespace threewe::slam
