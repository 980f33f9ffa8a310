// Motions as navigation sees them: how they go and end, plans, and who walks around.
#include <type_traits>

#include "bindings.hpp"
#include "named_enum.hpp"
#include "threewe/nav/navigator.hpp"
#include "value.hpp"

namespace {

using namespace threewe;
using nav::Progress;
using nav::Reason;
using nav::RecoveryState;
using nav::SampledPlan;
using perception::TrackedPerson;

/// Poses or velocities as rows of three numbers, without a copy.
template <typename Triple>
const double* numbers(const std::vector<Triple>& triples) {
  static_assert(std::is_standard_layout_v<Triple> && sizeof(Triple) == 3 * sizeof(double));
  return reinterpret_cast<const double*>(triples.data());  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
}
template <typename Triple>
ArrayView<double, nb::shape<-1, 3>> rows(const std::vector<Triple>& triples) {
  return {numbers(triples), {triples.size(), 3}};
}
template <typename Triple>
ArrayView<double, nb::shape<-1, -1, 3>> tables(const SampledPlan& plan, const std::vector<Triple>& triples) {
  return {numbers(triples), {plan.weights.size(), plan.poses.size(), 3}};
}

void bind_motions(nb::module_& m) {
  NamedEnum<Reason>(m, "Reason", "How a motion ends, and why.")
      .value("running", Reason::running, "It has not ended.")
      .value("reached", Reason::reached, "Success.")
      .value("no_path", Reason::no_path, "No way leads there: the goal is in a wall, outside the world or cut off.")
      .value("blocked", Reason::blocked, "Something in the way did not go away.")
      .value("timeout", Reason::timeout, "Robot time ran out.")
      .value("cancelled", Reason::cancelled, "A caller stopped it.")
      .value("estop", Reason::estop, "The emergency stop was latched.")
      .value("lost", Reason::lost, "The robot no longer knows where it is.")
      .value("uncertain", Reason::uncertain,
             "By its estimate it is at its goal, but that is known less well than the tolerance asks for.")
      .value("fault", Reason::fault, "The robot or its backend failed.")
      .value("starved", Reason::starved, "The policy that steers it gave no actions any more.")
      .value("policy_error", Reason::policy_error,
             "The policy that steers it raised, or gave numbers that are not finite.");

  NamedEnum<RecoveryState>(m, "RecoveryState",
                           "What a robot does that does not get on: in this order, as often as it takes or until it "
                           "gives up.")
      .value("driving", RecoveryState::driving, "It gets on.")
      .value("clearing", RecoveryState::clearing, "It stands still until what it sees is fresh.")
      .value("backing_off", RecoveryState::backing_off, "The way it came, or where there is most room.")
      .value("arc_escape", RecoveryState::arc_escape, "Where it cannot turn: out in arcs, forwards and backwards.")
      .value("looking", RecoveryState::looking, "It turns to look; all the way round where it is lost.")
      .value("replanning", RecoveryState::replanning, "It plans anew, for one period.")
      .value("given_up", RecoveryState::given_up, "The result's `detail` says why.");

  nb::class_<Progress>(m, "Progress", "How far a motion has come.")
      .def(Value())
      .def_ro("distance_left", &Progress::distance_left, "[m] along the path; when exploring to the next frontier")
      .def_ro("time_left", &Progress::time_left,
              "[s] that this, and turning to a heading, will take at the pace so far")
      .def_ro("distance_driven", &Progress::distance_driven, "[m] since the start of the motion")
      .def_ro("pose", &Progress::pose, "in `map`")
      .def_ro("recovery", &Progress::recovery, "what it does that does not get on")
      .def("__repr__", [](const Progress& p) {
        return fmt::format("Progress({:.2f} m and {:.1f} s left, {:.2f} m driven)", p.distance_left, p.time_left,
                           p.distance_driven);
      });
}

void bind_plan(nb::module_& m) {
  nb::class_<SampledPlan>(m, "SampledPlan",
                          "A plan, and the samples of which it is the weighted mean.\n\n"
                          "Poses in `odom`, at the ends of the steps; velocities in the body frame, as they are "
                          "asked for: the poses are where these lead within the limits of the base.")
      .def(Value())
      .def_ro("made", &SampledPlan::made,
              "[s] of robot time; it begins a little later, when its first command takes effect")
      .def_ro("step", &SampledPlan::step, "[s]")
      .def_prop_ro(
          "poses", [](const SampledPlan& p) { return rows(p.poses); }, nb::rv_policy::reference_internal,
          "(steps, 3) where the plan leads: x, y [m], theta [rad]")
      .def_prop_ro(
          "velocities", [](const SampledPlan& p) { return rows(p.velocities); }, nb::rv_policy::reference_internal,
          "(steps, 3) what it asks for: vx, vy [m/s], omega [rad/s]")
      .def_prop_ro(
          "trajectories", [](const SampledPlan& p) { return tables(p, p.trajectories); },
          nb::rv_policy::reference_internal, "(samples, steps, 3) where each sample leads, as `poses`")
      .def_prop_ro(
          "controls", [](const SampledPlan& p) { return tables(p, p.controls); }, nb::rv_policy::reference_internal,
          "(samples, steps, 3) what each asks for, as `velocities`")
      .def_prop_ro(
          "weights",
          [](const SampledPlan& p) { return ArrayView<double, nb::ndim<1>>(p.weights.data(), {p.weights.size()}); },
          nb::rv_policy::reference_internal, "(samples,) how much each counts; 1 in all")
      .def("__repr__", [](const SampledPlan& p) {
        return fmt::format("SampledPlan({} samples of {} steps of {:.2f} s, made at {:.2f} s)", p.weights.size(),
                           p.poses.size(), p.step, to_seconds(p.made));
      });
}

void bind_people(nb::module_& m) {
  nb::class_<TrackedPerson>(m, "TrackedPerson", "A person who walks, as the robot's lidar sees them. `odom` frame.")
      .def(Value())
      .def_ro("id", &TrackedPerson::id, "the same as long as the person is not lost sight of")
      .def_ro("position", &TrackedPerson::position, "(x, y) [m]")
      .def_ro("velocity", &TrackedPerson::velocity, "(vx, vy) [m/s]")
      .def_prop_ro(
          "covariance",
          [](const TrackedPerson& p) { return ArrayView<double, nb::shape<4, 4>>(p.covariance.data(), {4, 4}); },
          nb::rv_policy::reference_internal, "(4, 4) float64, of x, y [m], vx, vy [m/s]")
      .def("__repr__", [](const TrackedPerson& p) {
        return fmt::format("TrackedPerson({} at ({:.2f}, {:.2f}), {:.2f}, {:.2f} m/s)", p.id, p.position.x,
                           p.position.y, p.velocity.x, p.velocity.y);
      });
}

}  // namespace

void init_nav(nb::module_& m) {
  bind_motions(m);
  bind_plan(m);
  bind_people(m);
}
