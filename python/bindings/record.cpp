// Recorder and journals.
#include <algorithm>
#include <array>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/variant.h>

#include "bindings.hpp"
#include "one_thread.hpp"
#include "threewe/record/recorder.hpp"

template <>
inline constexpr const char* kSecondThread<threewe::record::Recorder> =
    "a recorder may be used on the thread of its robot only";

template <>
OneThread& thread_of(const threewe::record::Recorder& recorder) {
  return static_cast<const Guarded<threewe::World>&>(recorder.world()).one_thread;
}

namespace {

using namespace threewe;
using namespace threewe::record;

template <typename T>
using Owned = nb::ndarray<nb::numpy, T>;

// Of properties that make an array anew each time.
constexpr auto kFresh = nb::rv_policy::move;

// An array of its own that takes over a vector.
template <typename T>
Owned<T> own(std::vector<T> values, const std::vector<std::size_t>& shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Owned<T>(kept->data(), shape.size(), shape.data(), owner);
}

// One number of each item. (Not a vector<bool>, which has no memory to show.)
template <typename T, typename Item, typename Get>
Owned<T> column(const std::vector<Item>& items, const Get& get) {
  auto* kept = new T[items.size() + 1];
  const nb::capsule owner(kept, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  std::ranges::transform(items, kept, [&](const Item& item) { return static_cast<T>(get(item)); });
  const std::size_t shape[] = {items.size()};
  return Owned<T>(kept, 1, shape, owner);
}

// Three numbers of each item.
template <typename Item, typename Get>
Owned<double> rows(const std::vector<Item>& items, const Get& get) {
  std::vector<double> values;
  values.reserve(3 * items.size());
  for (const Item& item : items) {
    for (const double value : get(item)) values.push_back(value);
  }
  return own(std::move(values), {items.size(), 3});
}

std::array<double, 3> numbers(const Pose2D& p) { return {p.x, p.y, p.theta}; }
std::array<double, 3> numbers(const Velocity& v) { return {v.vx, v.vy, v.omega}; }

std::span<const std::byte> bytes_of(const nb::bytes& bytes) {
  return {static_cast<const std::byte*>(bytes.data()), bytes.size()};
}

void bind_recorder(nb::module_& m) {
  nb::class_<Frame>(m, "RecordingFrame", "One camera image on its way into a journal.")
      .def_ro("robot", &Frame::robot, "its number among those recorded")
      .def_ro("sensor", &Frame::sensor, "its number among the robot's sensors")
      .def_prop_ro(
          "color",
          [](const Frame& frame) {
            const RGBDImage& image = frame.picture.image();
            return ArrayView<std::uint8_t, nb::shape<-1, -1, 3>>(image.color.data(),
                                                                 {static_cast<std::size_t>(image.intrinsics.height),
                                                                  static_cast<std::size_t>(image.intrinsics.width), 3});
          },
          nb::rv_policy::reference_internal, "(H, W, 3) uint8, BGR; drawn on first access");

  OneThreadClass<Recorder> bound(m, "Recorder", "Crash-safe journal of what robots sense, are asked for and do.");
  bound
      .def(
          "__init__",
          [](Recorder* self, Guarded<World>& world, const std::string& folder, std::vector<std::size_t> robots,
             std::vector<std::string> sensors, bool encoder) {
            const OneThread::Use use(world.one_thread);
            new (self) Recorder(world, folder, {std::move(robots), std::move(sensors), encoder, {}});
          },
          "world"_a, "folder"_a, "robots"_a, "sensors"_a, "encoder"_a, nb::keep_alive<1, 2>())
      .def("start_episode", &Recorder::start_episode, "task"_a, "metadata"_a)
      .def("end_episode", &Recorder::end_episode, "success"_a.none(), "metadata"_a, WithoutGil())
      .def("close", &Recorder::close, WithoutGil())
      .def("discard_episode", &Recorder::discard_episode, WithoutGil())
      .def_prop_ro("recording", &Recorder::recording)
      .def_prop_ro("ticks", &Recorder::ticks)
      .def(
          "record_step",
          [](Recorder& recorder, std::size_t robot, const std::vector<double>& action) {
            recorder.record_step(robot, action);
          },
          "robot"_a, "action"_a)
      .def("set_instruction", &Recorder::set_instruction, "robot"_a, "instruction"_a)
      .def("set_takeover", &Recorder::set_takeover, "robot"_a, "takeover"_a);
  // what the thread of the encoder calls
  nb::class_<Recorder>(bound)
      .def("next_frame", &Recorder::next_frame, WithoutGil())
      .def(
          "put_packet",
          [](Recorder& recorder, const Frame& frame, const nb::bytes& packet) {
            const auto bytes = bytes_of(packet);
            const nb::gil_scoped_release other_threads_run;
            recorder.put_packet(frame, bytes);
          },
          "frame"_a, "packet"_a)
      .def("put_raw", &Recorder::put_raw, "frame"_a, WithoutGil())
      .def("detach_encoder", &Recorder::detach_encoder, WithoutGil());
}

void bind_robot(nb::module_& m) {
  nb::class_<RecordedRobot> robot(m, "RecordedRobot", "One robot of a recorded episode.");
  const auto times = [](const auto& tick) { return to_seconds(tick.now); };
  robot.def_ro("profile", &RecordedRobot::profile)
      .def_ro("hardware", &RecordedRobot::hardware, "the profile's YAML; empty where that was made in code")
      .def_ro("scene_from_map", &RecordedRobot::scene_from_map)
      .def_ro("sensors", &RecordedRobot::sensors)
      .def_ro("cameras", &RecordedRobot::cameras, "by the sensors' numbers; without pixels where it is no camera")
      .def_ro("samples", &RecordedRobot::samples, "in order of arrival; a camera's hold no image")
      .def_ro("frames", &RecordedRobot::frames)
      .def_prop_ro(
          "time", [times](const RecordedRobot& r) { return column<double>(r.ticks, times); }, kFresh)
      .def_prop_ro("simulated", [](const RecordedRobot& r) { return !r.ticks.empty() && r.ticks.front().simulated; })
      .def_prop_ro(
          "intervention",
          [](const RecordedRobot& r) {
            return column<std::uint8_t>(r.ticks, [](const RecordedTick& t) { return t.intervention; });
          },
          kFresh)
      .def_prop_ro(
          "lost",
          [](const RecordedRobot& r) { return column<bool>(r.ticks, [](const RecordedTick& t) { return t.lost; }); },
          kFresh)
      .def_prop_ro(
          "takeover",
          [](const RecordedRobot& r) {
            return column<bool>(r.ticks, [](const RecordedTick& t) { return t.takeover; });
          },
          kFresh)
      .def_prop_ro(
          "step_time", [times](const RecordedRobot& r) { return column<double>(r.steps, times); }, kFresh)
      .def_prop_ro(
          "step_action",
          [](const RecordedRobot& r) {
            const std::size_t width = r.steps.empty() ? 0 : r.steps.front().action.size();
            std::vector<double> all;
            for (const RecordedStep& step : r.steps) all.insert(all.end(), step.action.begin(), step.action.end());
            return own(std::move(all), {r.steps.size(), width});
          },
          kFresh)
      .def_prop_ro("instructions", [](const RecordedRobot& r) {
        std::vector<std::pair<double, std::string>> all;
        for (const RecordedInstruction& it : r.instructions) all.emplace_back(to_seconds(it.now), it.text);
        return all;
      });
  const auto with_three = [&robot](const char* name, auto member) {
    robot.def_prop_ro(
        name,
        [member](const RecordedRobot& r) {
          return rows(r.ticks, [member](const RecordedTick& t) { return numbers(t.*member); });
        },
        kFresh);
  };
  with_three("pose", &RecordedTick::map_from_base);
  with_three("odom_from_base", &RecordedTick::odom_from_base);
  with_three("true_pose", &RecordedTick::true_pose);
  with_three("velocity", &RecordedTick::velocity);
  with_three("requested", &RecordedTick::requested);
  with_three("executed", &RecordedTick::executed);
  with_three("true_velocity", &RecordedTick::true_velocity);
}

void bind_journal(nb::module_& m) {
  nb::class_<RecordedFrame>(m, "RecordedFrame", "Where the image of a camera sample is in its journal.")
      .def_ro("sensor", &RecordedFrame::sensor)
      .def_ro("measured", &RecordedFrame::measured, "[s]")
      .def_ro("received", &RecordedFrame::received, "[s]")
      .def_ro("width", &RecordedFrame::width, "[px]")
      .def_ro("height", &RecordedFrame::height, "[px]")
      .def_ro("encoded", &RecordedFrame::encoded, "as an H.264 access unit; raw otherwise")
      .def_prop_ro("has_depth", [](const RecordedFrame& frame) { return frame.depth.has_value(); });
  bind_robot(m);

  nb::class_<ReplayReport>(m, "ReplayReport", "How far a replay came from what was recorded.")
      .def_ro("ticks", &ReplayReport::ticks)
      .def_ro("max_deviation", &ReplayReport::max_deviation, "[m] between true positions")
      .def_ro("first_difference", &ReplayReport::first_difference, "[s] of any bit of a true pose or a sample");

  nb::class_<World::Origin>(m, "WorldOrigin", "Of which backend a world is, and how it was made.")
      .def_ro("backend", &World::Origin::backend)
      .def_prop_ro("scene", [](const World::Origin& o) { return o.options.scene; })
      .def_prop_ro("robots", [](const World::Origin& o) { return o.options.robots; })
      .def_prop_ro("seed", [](const World::Origin& o) { return o.options.seed; })
      .def_prop_ro("randomization", [](const World::Origin& o) { return o.options.randomization; });

  nb::class_<Journal>(m, "Journal", "One recorded episode, read from its file.")
      .def_static(
          "open", [](const std::string& file) { return Journal::open(file); }, "file"_a, WithoutGil())
      .def_prop_ro("episode", &Journal::episode)
      .def_prop_ro("task", &Journal::task)
      .def_prop_ro("success", &Journal::success)
      .def_prop_ro("metadata", &Journal::metadata)
      .def_prop_ro("recovered", &Journal::recovered)
      .def_prop_ro("started", &Journal::started, "wall clock [s since 1970]")
      .def_prop_ro("began", &Journal::began, "[s] of robot time")
      .def_prop_ro("robots", &Journal::robots, nb::rv_policy::reference_internal)
      .def_prop_ro("origin", &Journal::origin)
      .def_prop_ro("can_replay", [](const Journal& j) { return j.origin() && !j.initial_state().empty(); })
      .def(
          "color",
          [](const Journal& journal, const RecordedFrame& frame) {
            const auto bytes = journal.color(frame);
            return nb::bytes(bytes.data(), bytes.size());
          },
          "frame"_a, "An access unit, or (H, W, 3) blue, green, red.")
      .def(
          "depth",
          [](const Journal& journal, const RecordedFrame& frame) {
            return own(journal.depth(frame),
                       {static_cast<std::size_t>(frame.height), static_cast<std::size_t>(frame.width)});
          },
          "frame"_a, "(H, W) uint16 [mm], 0 where invalid.")
      .def(
          "replay", [](const Journal& journal) { return replay(journal); }, WithoutGil(),
          "Makes its world anew and sends the commands that were executed.");

  nb::class_<Recovered>(m, "Recovered", "What was made of a journal that a crash had cut off.")
      .def_ro("file", &Recovered::file, "empty where nothing of it could be saved")
      .def_ro("ticks", &Recovered::ticks)
      .def_ro("lost_bytes", &Recovered::lost_bytes);
  nb::class_<JournalHeader>(m, "JournalHeader", "What a journal says at its beginning.")
      .def_ro("episode", &JournalHeader::episode)
      .def_ro("task", &JournalHeader::task)
      .def_ro("robots", &JournalHeader::robots, "the names of their hardware profiles");
  m.def(
      "read_journal_header", [](const std::string& journal) { return read_header(journal); }, "journal"_a, WithoutGil(),
      "Reads no more of a journal, however long it is.");
  m.def("recover_journals", [](const std::string& folder) { return recover(folder); }, "folder"_a, WithoutGil());
  m.def("journals", [](const std::string& folder) { return journals(folder); }, "folder"_a);
}

}  // namespace

void init_record(nb::module_& m) {
  bind_recorder(m);
  bind_journal(m);
}
