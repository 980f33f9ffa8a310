// Backends written in Python, and the checks that any backend must pass.
#include <cctype>
#include <memory>

#include <nanobind/stl/shared_ptr.h>

#include <fmt/ranges.h>

#include "backend/plugin.hpp"
#include "backend/simulated/plugin_truth.hpp"
#include "bindings.hpp"
#include "core/exact.hpp"
#include "named_enum.hpp"
#include "threewe/backend/conformance.hpp"
#include "threewe/backend/registry.hpp"
#include "value.hpp"

namespace {

using namespace threewe;
using backend::CheckResult, backend::Outcome, backend::WorldOptions;
using backend::PluginLink, backend::PluginReading, backend::PluginReply, backend::PluginRequest, backend::PluginTruth;

// What Python answers is checked here for its types and shapes, and in C++ for its values.

std::string kind_of(nb::handle object) { return nb::cast<std::string>(object.type().attr("__name__")); }
std::string text(nb::handle object) { return nb::cast<std::string>(nb::str(object)); }

/// One reading under conversion: knows how to complain.
struct Field {
  const std::string& sensor;
  nb::handle reading;

  [[noreturn]] void fail(const char* field, const std::string& what) const {
    throw ContractError(fmt::format("sensor '{}': {} {}", sensor, field, what));
  }

  double number(const char* field, nb::handle value) const {
    const double converted = PyFloat_AsDouble(value.ptr());
    if (converted == -1.0 && PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      fail(field, fmt::format("must be a number, got {}", kind_of(value)));
    }
    return converted;
  }
  double number(const char* field) const { return number(field, reading.attr(field)); }

  Time time(const char* field) const {
    const double value = number(field);
    if (!std::isfinite(value)) fail(field, fmt::format("is {}; it must be a finite number of seconds", value));
    if (std::abs(value) > 1e9) {  // no robot runs for 30 years
      fail(field,
           fmt::format("is {:.0f}, which is probably wall-clock time; it must be robot time, which begins at 0 s "
                       "when the world is made or reset: stamp with the `t` of step()",
                       value));
    }
    return from_seconds(value);
  }

  std::array<double, 3> triple(const char* field) const {
    const nb::object value = reading.attr(field);
    if (nb::hasattr(value, "shape") && !value.attr("shape").equal(nb::make_tuple(3))) {
      fail(field, fmt::format("has shape {}; it must be (3,)", text(value.attr("shape"))));
    }
    if (!nb::isinstance<nb::iterable>(value)) fail(field, fmt::format("must be 3 numbers, got {}", kind_of(value)));
    const nb::list items(value);
    if (items.size() != 3) fail(field, fmt::format("must be 3 numbers, got {}", items.size()));
    return {number(field, items[0]), number(field, items[1]), number(field, items[2])};
  }

  /// A copy of an array, row by row; `shape` is how messages tell what is right, with a letter for any size.
  template <typename T>
  std::vector<T> array(const char* field, const char* dtype, const std::vector<std::string>& shape) const {
    const nb::object value = reading.attr(field);
    if (!nb::ndarray_check(value)) {
      fail(field, fmt::format("must be a numpy array of {}, got {}", dtype, kind_of(value)));
    }
    const auto any = nb::cast<nb::ndarray<nb::ro, nb::device::cpu>>(value);
    if (any.dtype() != nb::dtype<T>()) {
      fail(field, fmt::format("has dtype {}; it must be {}", text(value.attr("dtype")), dtype));
    }
    bool fits = any.ndim() == shape.size();
    for (std::size_t i = 0; fits && i < shape.size(); ++i) {
      fits = std::isalpha(shape[i].front()) != 0 || std::to_string(any.shape(i)) == shape[i];
    }
    if (!fits) {
      const char* comma = shape.size() == 1 ? "," : "";
      fail(field,
           fmt::format("has shape {}; it must be ({}{})", text(value.attr("shape")), fmt::join(shape, ", "), comma));
    }
    const auto rows = nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(value);  // copies what is strided
    return {rows.data(), rows.data() + rows.size()};
  }
};

Picture picture_of(const CameraSpec& spec, const Field& field) {
  const std::string height = std::to_string(spec.height);
  const std::string width = std::to_string(spec.width);
  RGBDImage image{spec.intrinsics(), field.array<std::uint8_t>("color", "uint8", {height, width, "3"}), {}};
  if (!field.reading.attr("depth").is_none()) image.depth = field.array<float>("depth", "float32", {height, width});
  return Picture(std::move(image));
}

SampleData data_of(SensorType type, const Field& field, const RobotProfile& profile) {
  switch (type) {
    case SensorType::lidar: {
      const LidarSpec& spec = *profile.lidar;
      return LaserScan{.angle_min = field.number("angle_min"),
                       .angle_increment = 2.0 * exact::kPi / spec.beams,
                       .time_increment = field.number("time_increment"),
                       .range_min = spec.range_min,
                       .range_max = spec.range_max,
                       .ranges = field.array<float>("ranges", "float32", {"N"})};
    }
    case SensorType::imu: return IMUData{field.triple("angular_velocity"), field.triple("linear_acceleration")};
    case SensorType::odometry: {
      const auto [x, y, theta] = field.triple("pose");
      const auto [vx, vy, omega] = field.triple("velocity");
      return Odometry{{x, y, theta}, {vx, vy, omega}};
    }
    case SensorType::battery:
      return BatteryState{field.number("voltage"), field.number("current"), field.number("charge")};
    case SensorType::ultrasonic: {
      const UltrasonicSpec& spec = *profile.ultrasonics;
      return RangeData{spec.field_of_view, spec.range_min, spec.range_max, field.number("range")};
    }
    case SensorType::camera: return picture_of(*profile.camera, field);
  }
  throw ContractError("a sensor of no kind");
}

PluginReading to_reading(nb::handle reading, const PluginLink& link) {
  const nb::object base = nb::module_::import_("threewe.backend").attr("Reading");
  if (!nb::isinstance(reading, base)) {
    throw ContractError(
        fmt::format("step() must return readings such as OdometryReading, got one {}", kind_of(reading)));
  }
  const nb::object name = reading.attr("sensor");
  if (!nb::isinstance<nb::str>(name)) {
    throw ContractError(fmt::format("the name of a sensor must be a str, got {}", kind_of(name)));
  }
  const auto sensor = nb::cast<std::string>(name);
  const auto type = nb::cast<SensorType>(reading.attr("type"));
  if (!link.profile().has(type)) {
    throw ContractError(
        fmt::format("sensor '{}': the profile '{}' has no {}", sensor, link.profile().name, to_string(type)));
  }
  const Field field{sensor, reading};
  return {.sensor = sensor, .measured = field.time("measured"), .data = data_of(type, field, link.profile())};
}

PluginTruth to_truth(nb::handle answer) {
  if (!nb::isinstance(answer, nb::module_::import_("threewe.backend").attr("Truth"))) {
    throw ContractError(fmt::format("truth() must return a Truth, got {}", kind_of(answer)));
  }
  const std::string name = "truth()";
  const Field field{name, answer};
  const auto pose = [&](const char* which) {
    const auto [x, y, theta] = field.triple(which);
    return Pose2D{x, y, theta};
  };
  const auto [vx, vy, omega] = field.triple("velocity");
  return {.start = pose("start"),
          .pose = pose("pose"),
          .velocity = {vx, vy, omega},
          .distance_driven = field.number("distance_driven"),
          .max_collision_speed = field.number("max_collision_speed")};
}

PluginReply to_reply(PluginRequest::Call call, nb::handle answer, const PluginLink& link) {
  PluginReply reply;
  if (call == PluginRequest::Call::step) {
    if (!nb::isinstance<nb::iterable>(answer)) {
      throw ContractError(fmt::format("step() must return a list of readings, got {}", kind_of(answer)));
    }
    for (const nb::handle reading : nb::list(answer)) reply.readings.push_back(to_reading(reading, link));
  } else if (call == PluginRequest::Call::truth) {
    reply.truth = to_truth(answer);
  } else if (call == PluginRequest::Call::save) {
    if (!nb::isinstance<nb::bytes>(answer)) {
      throw ContractError(fmt::format("save() must return bytes, got {}", kind_of(answer)));
    }
    const auto bytes = nb::cast<nb::bytes>(answer);
    const auto* begin = static_cast<const std::byte*>(bytes.data());
    reply.state.assign(begin, begin + bytes.size());
  }
  return reply;
}

nb::tuple arguments(const PluginRequest& request) {
  switch (request.call) {
    case PluginRequest::Call::step: return nb::make_tuple(to_seconds(request.t), request.velocity);
    case PluginRequest::Call::reset: return nb::make_tuple(request.seed, request.pose);
    case PluginRequest::Call::restore: return nb::make_tuple(nb::bytes(request.state.data(), request.state.size()));
    default: return nb::make_tuple();
  }
}

/// The link as the thread of a Python backend sees it.
struct Mailbox {
  std::shared_ptr<PluginLink> link;
  std::shared_ptr<const scene::Scene> scene;  ///< null where the truth is not known
  PluginRequest::Call call{};

  nb::object take() {
    std::optional<PluginRequest> request;
    {
      const nb::gil_scoped_release other_threads_run;
      request = link->take();
    }
    if (!request) return nb::none();
    call = request->call;
    return nb::make_tuple(std::string(to_string(call)), arguments(*request));
  }

  void answer(nb::handle answer) {
    PluginReply reply;
    std::string wrong;
    try {
      reply = to_reply(call, answer, *link);
    } catch (const std::exception& error) {  // whatever it was, the world must hear of it
      wrong = error.what();
    }
    const nb::gil_scoped_release other_threads_run;
    wrong.empty() ? link->answer(std::move(reply)) : link->refuse(wrong);
  }
};

/// A world of the backend that Python registered under `name`. Holds no Python object, so that it may outlive Python.
std::unique_ptr<backend::World> make_python_world(const std::string& name, const WorldOptions& options) {
  if (options.robots.size() != 1) {
    throw ConfigError(fmt::format("backend '{}' has one robot, not {}", name, options.robots.size()));
  }
  const nb::gil_scoped_acquire python_runs;
  const nb::object open = nb::module_::import_("threewe.backend").attr("_open");
  const nb::object pose = options.poses.empty() ? nb::none() : nb::cast(options.poses.front());
  const nb::object size = options.image_size
                              ? nb::object(nb::make_tuple(options.image_size->height, options.image_size->width))
                              : nb::none();
  const nb::object mailbox =
      open(name, options.scene, options.robots.front(), options.noise == NoiseLevel::ideal ? "ideal" : "realistic",
           options.seed, pose, size, options.randomization);
  const auto& [link, scene, call] = nb::cast<Mailbox&>(mailbox);
  std::unique_ptr<const scene::TruthView> truth;
  if (scene) truth = std::make_unique<backend::simulated::PluginTruthView>(link, scene);
  return std::make_unique<backend::PluginWorld>(link, std::move(truth));
}

void bind_plugins(nb::module_& m) {
  nb::class_<Mailbox>(m, "BackendMailbox", "Between the core and the thread of a backend written in Python.")
      .def(
          "__init__",
          [](Mailbox* self, std::string name, const backend::Features& features, const RobotProfile& profile,
             const scene::Scene* scene) {
            new (self) Mailbox{std::make_shared<PluginLink>(std::move(name), features, profile),
                               scene == nullptr ? nullptr : std::make_shared<const scene::Scene>(*scene)};
          },
          "name"_a, "features"_a, "profile"_a, "scene"_a.none(),
          "`scene` is that of a simulator which tells the truth.")
      .def("take", &Mailbox::take, nb::sig("def take(self) -> tuple[str, tuple[object, ...]] | None"),
           "The next method to call and its arguments; None when the thread shall end.")
      .def("answer", &Mailbox::answer, "answer"_a.none(), "What the method returned.")
      .def(
          "fail", [](Mailbox& mailbox, const std::string& what) { mailbox.link->fail(what); }, "what"_a, WithoutGil(),
          "What the method raised.")
      .def(
          "close", [](Mailbox& mailbox) { mailbox.link->close(); }, WithoutGil(),
          "Tells the backend to disconnect and its thread to end.");
  m.def(
      "register_backend",
      [](const std::string& name) {
        backend::register_backend(name,
                                  [name](const WorldOptions& options) { return make_python_world(name, options); });
      },
      "name"_a, "Makes a backend of threewe.backend known to the core.");
}

void bind_conformance(nb::module_& m) {
  NamedEnum<Outcome>(m, "Outcome", "How a check of a backend ended.")
      .value("passed", Outcome::passed)
      .value("failed", Outcome::failed)
      .value("not_applicable", Outcome::not_applicable, "The backend does not claim the feature.");
  nb::class_<CheckResult>(m, "CheckResult", "What one check of a backend found.")
      .def(Value())
      .def_ro("name", &CheckResult::name)
      .def_ro("outcome", &CheckResult::outcome)
      .def_ro("detail", &CheckResult::detail, "what was wrong, or why the check does not apply; empty when passed")
      .def_prop_ro("passed", &CheckResult::passed, "False only for a failure.")
      .def("__repr__", [](const CheckResult& result) {
        return fmt::format("CheckResult('{}', {}{}{})", result.name, to_string(result.outcome),
                           result.detail.empty() ? "" : ": ", result.detail);
      });
  m.def("check_names", &backend::check_names, "The names of all checks of a backend, in the order in which they run.");
  m.def(
      "run_check",
      [](const std::string& check, const std::string& name, const std::string& scene, const std::string& hardware,
         const std::string& noise, std::uint64_t seed, std::string color_ahead) {
        WorldOptions options;
        options.scene = scene;
        options.robots = {hardware};
        options.noise = noise_level(noise);
        options.seed = seed;
        const auto make = [&name](const WorldOptions& with) {
          try {
            return backend::make_world(name, with);
          } catch (const nb::python_error& error) {  // one line, where what() is a traceback
            const nb::gil_scoped_acquire gil;
            throw ContractError(fmt::format("{}: {}", kind_of(error.value()), text(error.value())));
          }
        };
        return backend::check_backend(make, options, check, {.color_ahead = std::move(color_ahead)});
      },
      "check"_a, nb::kw_only(), "backend"_a, "scene"_a, "hardware"_a, "noise"_a, "seed"_a, "color_ahead"_a = "",
      WithoutGil(), "Runs one check on a fresh world.");
}

}  // namespace

void init_plugin(nb::module_& m) {
  bind_plugins(m);
  bind_conformance(m);
}
