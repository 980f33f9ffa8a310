// Learned policies: the action timeline, the session that computes actions, and the embedding of instructions.
#include "policy/timeline.hpp"

#include <future>

#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "language/vocabulary.hpp"
#include "one_thread.hpp"
#include "policy/graph_session.hpp"
#include "policy/recovery.hpp"

using namespace threewe;
using policy::GraphInput, policy::GraphSession, policy::Merge, policy::PictureInput, policy::TensorShape,
    policy::Timeline;

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

using Floats = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using Pixels = nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<nb::numpy, float, nb::c_contig>;
using Shape = std::pair<std::string, std::vector<std::int64_t>>;

TensorShape tensor_of(const Shape& shape) { return {shape.first, shape.second}; }

PictureInput picture_of(const Pixels& bgr, std::size_t height, std::size_t width, bool rgb) {
  if (height == 0 || bgr.shape(0) % height != 0 || bgr.shape(1) != bgr.shape(0) / height * width) {
    throw ContractError(
        fmt::format("a picture of {} x {} is no whole multiple of {} x {}", bgr.shape(0), bgr.shape(1), height, width));
  }
  return {{bgr.data(), bgr.data() + bgr.size()}, height, width, bgr.shape(0) / height, rgb};
}

// An array, or (image, height, width, rgb).
GraphInput input_of(nb::handle given) {
  if (nb::isinstance<nb::tuple>(given)) {
    const auto [bgr, height, width, rgb] = nb::cast<std::tuple<Pixels, std::size_t, std::size_t, bool>>(given);
    return picture_of(bgr, height, width, rgb);
  }
  const auto values = nb::cast<Floats>(given);
  return std::vector<float>(values.data(), values.data() + values.size());
}

std::vector<GraphInput> inputs_of(const nb::typed<nb::list, nb::object>& given) {
  std::vector<GraphInput> inputs;
  for (const nb::handle each : given) inputs.push_back(input_of(each));
  return inputs;
}

Output array_of(std::vector<float> values, const std::vector<std::int64_t>& lengths) {
  auto* kept = new std::vector<float>(std::move(values));
  const nb::capsule owner(kept, [](void* one) noexcept { delete static_cast<std::vector<float>*>(one); });
  const std::vector<std::size_t> shape(lengths.begin(), lengths.end());
  return {kept->data(), shape.size(), shape.data(), owner};
}

// What threads share is no object of Python's: none of them waits for the interpreter when it lets go.
struct SharedSession {
  std::shared_ptr<const GraphSession> session;
};

// One run of a session in a thread of its own.
class Inference {
 public:
  Inference(const std::shared_ptr<const GraphSession>& session, std::vector<GraphInput> inputs)
      : lengths_(session->output().lengths), result_(policy::start(session, std::move(inputs))) {}

  bool wait(double seconds) const {
    return result_.wait_for(std::chrono::duration<double>(seconds)) == std::future_status::ready;
  }
  Output result() const {
    if (!wait(0.0)) throw TimeoutError("the inference is not done");
    return array_of(result_.get(), lengths_);
  }

 private:
  std::vector<std::int64_t> lengths_;
  std::shared_future<std::vector<float>> result_;
};

void define_steering(nb::module_& m) {
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
      .def(
          "planned", [](const Guarded<Timeline>& self, Duration t) { return self.planned(t); }, "time"_a,
          "The velocity that the control tick at `time` [s], now or later, will have; None beyond the end.")
      .def_prop_ro(
          "end", [](const Guarded<Timeline>& self) { return self.end(); }, "[s] of robot time; None before any chunk")
      .def_prop_ro(
          "applied", [](const Guarded<Timeline>& self) { return self.counts().applied; }, "chunks merged in")
      .def_prop_ro(
          "late", [](const Guarded<Timeline>& self) { return self.counts().late; }, "chunks that came after their end")
      .def_prop_ro(
          "jumps", [](const Guarded<Timeline>& self) { return self.counts().jumps; },
          "chunks that changed the velocity by more than one period's acceleration");
  OneThreadClass<Guarded<policy::Recovery>>(m, "PolicyRecovery",
                                            "Moves a robot away from what the gate has stopped a policy for.")
      .def(
          "__init__",
          [](Guarded<policy::Recovery>* self, const RobotProfile& profile) {
            new (self) Guarded<policy::Recovery>(profile);
          },
          "profile"_a)
      .def(
          "next",
          [](Guarded<policy::Recovery>& self, Duration now, const Velocity& wanted, bool stopped,
             const LaserScan* scan) { return self.next(now, wanted, stopped, scan); },
          "now"_a, "wanted"_a, "stopped"_a, "scan"_a.none(),
          "What to ask of the gate in the control tick at `now` [s]; `stopped`: in the one before it let nothing "
          "through.")
      .def_prop_ro(
          "count", [](const Guarded<policy::Recovery>& self) { return self.count(); }, "how often it moved away");
}

}  // namespace

void init_policy(nb::module_& m) {
  define_steering(m);
  nb::class_<Inference>(m, "Inference", "One run of a graph in a thread of its own, which needs no Python.")
      .def(
          "done", [](const Inference& self) { return self.wait(0.0); }, "Whether there is a result or an error.")
      .def("wait", &Inference::wait, "seconds"_a, WithoutGil(), "Waits for it so long [s] at most; whether it is done.")
      .def("result", &Inference::result, "The graph's output, float32. Raises what went wrong, TimeoutError before.");
  nb::class_<SharedSession>(m, "GraphSession", "A policy's graph on one thread, by onnxruntime's library.")
      .def(
          "__init__",
          [](SharedSession* self, std::string_view library, const nb::bytes& graph, const std::vector<Shape>& inputs,
             const Shape& output) {
            std::vector<TensorShape> shapes;
            for (const Shape& each : inputs) shapes.push_back(tensor_of(each));
            const std::span content(static_cast<const std::byte*>(graph.data()), graph.size());
            new (self) SharedSession{
                std::make_shared<const GraphSession>(library, content, std::move(shapes), tensor_of(output))};
          },
          "library"_a, "graph"_a, "inputs"_a, "output"_a)
      .def(
          "run",
          [](const SharedSession& self, const nb::typed<nb::list, nb::object>& given) {
            const std::vector<GraphInput> inputs = inputs_of(given);
            std::vector<float> values;
            {
              const nb::gil_scoped_release other_threads_run;
              values = self.session->run(inputs);
            }
            return array_of(std::move(values), self.session->output().lengths);
          },
          "inputs"_a,
          "The output for inputs in their order: float32 arrays, or (image, height, width, rgb) of pictures.")
      .def(
          "start",
          [](const SharedSession& self, const nb::typed<nb::list, nb::object>& inputs) {
            return Inference(self.session, inputs_of(inputs));
          },
          "inputs"_a, "The same in a thread of its own.");
  m.def(
      "network_input",
      [](const Pixels& image, std::size_t height, std::size_t width, bool rgb) {
        const auto lengths = {1L, 3L, static_cast<long>(height), static_cast<long>(width)};
        return array_of(policy::network_input(picture_of(image, height, width, rgb)), lengths);
      },
      "image"_a, "height"_a, "width"_a, "rgb"_a,
      "(1, 3, height, width) 0 to 1 of a BGR picture, each pixel the mean of those that it stands for.");
  m.def("instruction_embedding", &language::embedding_of, "text"_a, "(64,) of a sentence, as in `3we/VLN-v1`.");
}
