// Pose-graph optimizer: the back-end of SLAM.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// What one measurement says of two places.
struct Constraint {
  int from = 0;                                               ///< the node in whose frame `to` was seen
  int to = 0;                                                 ///< another one
  Pose2D from_from_to{};                                      ///< the pose of `to` in the frame of `from`
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of its (x, y, theta)
  /// It may be plainly wrong, as a loop closure may: what is far from the rest then counts for little.
  bool doubtful = false;
  friend bool operator==(const Constraint&, const Constraint&) = default;
};

/// A measurement against the present estimate.
struct Fit {
  double chi_squared = 0.0;  ///< squared distance, in the constraint's own deviations
  double weight = 1.0;       ///< in (0, 1]: how much of it counts; 1 unless doubtful
};

/// How a solution went.
struct GraphSolution {
  bool converged = false;
  int iterations = 0;  ///< steps taken or tried
  double cost = 0.0;   ///< half the sum of squared distances, doubtful ones bounded
};

/// Poses of submaps and keyframes, and constraints between them; the estimate is the most likely one. Nodes and
/// constraints may be added at any time: the next solution starts from the present estimate, and what has not changed
/// costs nothing. Plain data: a copy, or one built again from `poses`, `is_fixed` and `constraints`, goes on with the
/// same bits. Meant for SLAM's closing of loops and for continuing saved maps, where old nodes are fixed.
class PoseGraph {
 public:
  PoseGraph();
  ~PoseGraph();
  PoseGraph(const PoseGraph& other);
  PoseGraph(PoseGraph&& other) noexcept;
  PoseGraph& operator=(PoseGraph other) noexcept;

  /// A new node near `guess`; returns its index, counted from 0. A fixed one stays where it is.
  int add_node(const Pose2D& guess, bool fixed = false);
  /// Returns its index. Throws ContractError when it is not finite, says nothing in some direction or joins no two
  /// nodes.
  int add_constraint(const Constraint& constraint);
  /// Moves a node: where the next solution starts or, for a fixed node, where it is.
  void set_pose(int node, const Pose2D& pose);

  /// Levenberg-Marquardt from the present estimate. Throws ContractError when no constraints lead from some node to a
  /// fixed one: it might lie anywhere.
  GraphSolution solve(int max_iterations = 100);

  const std::vector<Pose2D>& poses() const { return poses_; }
  bool is_fixed(int node) const { return fixed_[static_cast<std::size_t>(node)] != 0; }
  std::span<const Constraint> constraints() const { return constraints_; }
  Fit fit(int constraint) const;

  friend bool operator==(const PoseGraph& a, const PoseGraph& b) {
    return a.poses_ == b.poses_ && a.fixed_ == b.fixed_ && a.constraints_ == b.constraints_ && a.solved_ == b.solved_;
  }

 private:
  friend class GraphCovariance;

  std::vector<Pose2D> poses_;
  std::vector<char> fixed_;
  std::vector<Constraint> constraints_;
  bool solved_ = true;  // the estimate is the solution

  // what follows from which nodes are joined, until they change; copies work it out again
  class Normal;
  void update_pattern();
  std::unique_ptr<Normal> normal_;
};

/// How sure a graph is of its present estimate: worked out once, then each question is cheap. Doubtful constraints
/// whose weight is below 0.001 tell nothing here, as long as others hold every node.
class GraphCovariance {
 public:
  /// Throws ContractError where `solve` does.
  explicit GraphCovariance(const PoseGraph& graph);
  ~GraphCovariance();

  /// Of a node's (x, y, theta) in the graph's frame; zero for a fixed one.
  Eigen::Matrix3d of(int node) const;
  /// Of the pose of `to` in the frame of `from`: how far off a new constraint between them may be expected.
  Eigen::Matrix3d between(int from, int to) const;

 private:
  std::vector<Pose2D> poses_;
  std::unique_ptr<PoseGraph::Normal> normal_;
};

}  // namespace threewe::slam
