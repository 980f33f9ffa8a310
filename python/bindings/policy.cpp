// Learned policies: the action timeline, and the embedding of instructions.
#include "policy/timeline.hpp"

#include <nanobind/stl/array.h>

#include "bindings.hpp"
#include "language/vocabulary.hpp"
#include "one_thread.hpp"

using namespace threewe;
using policy::Merge, policy::Timeline;

namespace {

using Actions = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

std::vector<Velocity> velocities(const Actions& actions) {
  std::vector<Velocity> list;
  for (std::size_t k = 0; k < actions.shape(0); ++k) {
    const double* v = actions.data() + 3 * k;
    list.push_back({v[0], v[1], v[2]});
  }
  return list;
}

Merge merge_of(std::string_view name) {
  if (name == "replace") return Merge::replace;
  if (name == "blend") return Merge::blend;
  if (name == "ensemble") return Merge::ensemble;
  throw ContractError(fmt::format("merge must be replace, blend or ensemble, got '{}'", name));
}

}  // namespace

void init_policy(nb::module_& m) {
  OneThreadClass<Guarded<Timeline>>(m, "ActionTimeline",
                                    "Chunks of actions in robot time: merged, interpolated, braked at their end.")
      .def(
          "__init__",
          [](Guarded<Timeline>* self, const Limits& limits, double rate, std::size_t chunk, std::string_view merge) {
            new (self) Guarded<Timeline>(policy::make_timeline_model(limits, rate, chunk, merge_of(merge)));
          },
          "limits"_a, "rate"_a, "chunk"_a, "merge"_a)
      .def(
          "add",
          [](Guarded<Timeline>& self, Duration measured, const Actions& actions, Duration now) {
            self.add(measured, velocities(actions), now);
          },
          "measured"_a, "actions"_a, "now"_a,
          "Merges in (chunk, 3) [m/s, m/s, rad/s] made from a picture of `measured` [s]. Raises ContractError.")
      .def("next", &Timeline::next, "now"_a, "The velocity of the control tick at `now` [s].")
      .def_prop_ro(
          "end", [](const Guarded<Timeline>& self) { return self.end(); }, "[s] of robot time; None before any chunk")
      .def_prop_ro(
          "applied", [](const Guarded<Timeline>& self) { return self.counts().applied; }, "chunks merged in")
      .def_prop_ro(
          "late", [](const Guarded<Timeline>& self) { return self.counts().late; }, "chunks that came after their end")
      .def_prop_ro(
          "jumps", [](const Guarded<Timeline>& self) { return self.counts().jumps; },
          "chunks that changed the velocity by more than one period's acceleration");
  m.def("instruction_embedding", &language::embedding_of, "text"_a, "(64,) of a sentence, as in `3we/VLN-v1`.");
}
