// OMPL: sampling planners for a point among cells (needs Debian's libompl-dev).
#include <ompl/base/MotionValidator.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/config.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/AITstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

#include "core/grid_line.hpp"
#include "course.hpp"

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kBudget = 5.0;  // [s] of CPU time a query
constexpr double kRange = 3.0;   // [m] of a motion; by default 56 m, with which a third as many are solved

threewe::Vec2 cells(const peers::Course& course, const ob::State* state) {
  const auto* at = state->as<ob::RealVectorStateSpace::StateType>()->values;
  return {at[0] / course.resolution, at[1] / course.resolution};
}

// Looks at every cell that a motion crosses, where OMPL's own way looks every so often along it.
class CellsCrossed : public ob::MotionValidator {
 public:
  CellsCrossed(const ob::SpaceInformationPtr& space, const peers::Course& course)
      : MotionValidator(space), course_(course) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const bool valid = threewe::walk_grid_line(cells(course_, a), cells(course_, b),
                                               [&](int x, int y) { return course_.is_free(x, y); });
    ++(valid ? valid_ : invalid_);
    return valid;
  }

  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last) const override {
    if (checkMotion(a, b)) return true;
    if (last.first != nullptr) si_->copyState(last.first, a);
    last.second = 0.0;
    return false;
  }

 private:
  const peers::Course& course_;
};

class PlanningProblem {
 public:
  explicit PlanningProblem(const peers::Course& course)
      : course_(course), space_(std::make_shared<ob::RealVectorStateSpace>(2)) {
    ob::RealVectorBounds bounds(2);
    bounds.setHigh(0, course.width * course.resolution);
    bounds.setHigh(1, course.height * course.resolution);
    space_->setBounds(bounds);
  }

  // The way that a planner has when it is done, or the time over; simplified where it would not improve it by itself.
  template <class Planner>
  std::vector<peers::Point> solve(const peers::Query& query, bool simplify) {
    const double begin = peers::cpu_seconds();
    og::SimpleSetup setup(space_);
    const ob::SpaceInformationPtr& space = setup.getSpaceInformation();
    setup.setStateValidityChecker([&](const ob::State* state) {
      const threewe::Vec2 at = cells(course_, state);
      return course_.is_free(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
    });
    space->setMotionValidator(std::make_shared<CellsCrossed>(space, course_));
    setup.setOptimizationObjective(std::make_shared<ob::PathLengthOptimizationObjective>(space));
    setup.setStartAndGoalStates(state(query.from), state(query.to));
    const auto planner = std::make_shared<Planner>(space);
    if constexpr (requires { planner->setRange(kRange); }) planner->setRange(kRange);
    setup.setPlanner(planner);
    setup.solve(ob::PlannerTerminationCondition([&] { return peers::cpu_seconds() - begin > kBudget; }));
    if (!setup.haveExactSolutionPath()) return {};
    if (simplify) setup.simplifySolution();
    std::vector<peers::Point> way;
    for (const ob::State* at : setup.getSolutionPath().getStates()) {
      const auto* values = at->as<ob::RealVectorStateSpace::StateType>()->values;
      way.push_back({values[0], values[1]});
    }
    return way;
  }

 private:
  ob::ScopedState<> state(peers::Point p) const {
    ob::ScopedState<ob::RealVectorStateSpace> made(space_);
    made[0] = p.x, made[1] = p.y;
    return made;
  }

  const peers::Course& course_;
  std::shared_ptr<ob::RealVectorStateSpace> space_;
};

template <class Planner>
void report(const peers::Course& course, const std::string& name, const std::string& differs, std::size_t queries) {
  constexpr bool kSimplify = std::is_same_v<Planner, og::RRTConnect>;
  PlanningProblem problem(course);
  const std::string version = std::to_string(OMPL_MAJOR_VERSION) + "." + std::to_string(OMPL_MINOR_VERSION) + "." +
                              std::to_string(OMPL_PATCH_VERSION);
  peers::report_plans("OMPL " + version + ", " + name, differs + "; C++", course, queries,
                      [&](const peers::Query& q) { return problem.solve<Planner>(q, kSimplify); });
}

}  // namespace

int main(int, char** argv) {
  ompl::msg::noOutputHandler();
  ompl::RNG::setSeed(1);
  const peers::Course course = peers::read_course(argv[1]);
  report<og::RRTConnect>(course, "RRT-Connect", "samples; the first way, simplified; gives up after 5 s", 20);
  report<og::RRTstar>(course, "RRT*", "samples; what 5 s of improving lead to", 6);
  report<og::AITstar>(course, "AIT*", "samples in batches of 100; the same", 3);
}
