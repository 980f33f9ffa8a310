// Mapping on its own, from scans and odometry.
#include "threewe/slam/slam.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nanobind/stl/pair.h>

#include "bindings.hpp"
#include "core/bounds.hpp"
#include "one_thread.hpp"
#include "value.hpp"

template <>
inline constexpr const char* kSecondThread<threewe::slam::Slam> =
    "a Slam is in use on another thread, and one thread at a time may use it: wait for that call, or guard the Slam "
    "with a lock of your own";

namespace {

using namespace threewe;
using slam::LoopClosure, slam::SlamConfig, slam::SlamEvent, slam::StampedPose;
using Slam = Guarded<slam::Slam>;

template <int Columns>
using Rows = nb::ndarray<nb::numpy, double, nb::shape<-1, Columns>>;

// A new array with a row for each item; `numbers(item)` is an array of that many columns.
template <class Item, class Numbers>
auto rows_of(const std::vector<Item>& items, Numbers numbers) {
  using Row = decltype(numbers(items.front()));
  constexpr std::size_t kColumns = std::tuple_size_v<Row>;
  auto* rows = new double[kColumns * items.size() + 1];
  const nb::capsule owner(rows, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  for (std::size_t i = 0; i < items.size(); ++i) std::ranges::copy(numbers(items[i]), rows + kColumns * i);
  return Rows<static_cast<int>(kColumns)>(rows, {items.size(), kColumns}, owner);
}

auto rows_of(const std::vector<StampedPose>& poses) {
  return rows_of(poses, [](const StampedPose& p) {
    const Pose2D& pose = p.map_from_base;
    return std::array{to_seconds(p.stamp), pose.x, pose.y, pose.theta};
  });
}

auto rows_of(const std::vector<LoopClosure>& closures) {
  return rows_of(closures, [](const LoopClosure& c) {
    const Pose2D& pose = c.earlier_from_later;
    return std::array{to_seconds(c.earlier), to_seconds(c.later), pose.x, pose.y, pose.theta};
  });
}

}  // namespace

void init_slam(nb::module_& m) {
  const SlamConfig defaults;
  nb::class_<SlamConfig>(m, "SlamConfig", "What `threewe.slam.Slam` knows about the robot beforehand.")
      .def(Value())
      .def(
          "__init__",
          [](SlamConfig* self, const Pose2D& base_from_lidar, double range_max, double resolution,
             double range_bias_sigma, double distance_sigma, double position_drift, double heading_drift) {
            new (self) SlamConfig{base_from_lidar, range_max,      resolution,   range_bias_sigma,
                                  distance_sigma,  position_drift, heading_drift};
          },
          nb::kw_only(), "base_from_lidar"_a = Pose2D{}, "range_max"_a = defaults.range_max,
          "resolution"_a = defaults.resolution, "range_bias_sigma"_a = defaults.range_bias_sigma,
          "distance_sigma"_a = defaults.distance_sigma, "position_drift"_a = defaults.position_drift,
          "heading_drift"_a = defaults.heading_drift)
      .def_ro("base_from_lidar", &SlamConfig::base_from_lidar, "where the lidar is on the robot")
      .def_ro("range_max", &SlamConfig::range_max, "[m]; what a scan sees farther away is left out")
      .def_ro("resolution", &SlamConfig::resolution, "[m] a cell of the map")
      .def_ro("range_bias_sigma", &SlamConfig::range_bias_sigma, "[m] of the lidar's constant error")
      .def_ro("distance_sigma", &SlamConfig::distance_sigma, "share by which the odometry's distances may all be wrong")
      .def_ro("position_drift", &SlamConfig::position_drift, "[m/sqrt(m)] by which the odometry's position wanders")
      .def_ro("heading_drift", &SlamConfig::heading_drift, "[rad/sqrt(m)] by which the odometry's heading wanders");
  m.def(
      "check_reading",
      [](const LaserScan& scan, const Pose2D& odometry) {
        check_bounds("odometry", odometry);
        check_bounds(scan);
      },
      "scan"_a, "odometry"_a, "Raises ContractError where `Slam.add` would for these numbers, whatever came before.");
  nb::class_<SlamEvent>(m, "SlamEvent",
                        "What was wrong with a mapper's input, from the first scan concerned to the last.")
      .def_prop_ro(
          "incident", [](const SlamEvent& e) { return std::string(to_string(e.incident)); },
          "lidar_frozen, odometry_jumped, odometry_stopped, odometry_scaled, track_lost or components_joined")
      .def_prop_ro(
          "begin", [](const SlamEvent& e) { return to_seconds(e.begin); }, "[s] of the first scan concerned")
      .def_prop_ro(
          "end", [](const SlamEvent& e) { return to_seconds(e.end); }, "[s] of the last one")
      .def_ro("scans", &SlamEvent::scans, "how many are concerned")
      .def("__repr__", [](const SlamEvent& e) {
        return fmt::format("SlamEvent({}, begin={:.3f}, end={:.3f}, scans={})", to_string(e.incident),
                           to_seconds(e.begin), to_seconds(e.end), e.scans);
      });
  OneThreadClass<Slam>(m, "Slam", "Mapping from scans and odometry: what `threewe.slam.Slam` is made of.")
      .def(nb::init<const SlamConfig&>(), "config"_a = defaults)
      .def(
          "add",
          [](Slam& slam, Time time, const LaserScan& scan, const std::optional<Pose2D>& odometry) {
            const std::size_t before = slam.events().size();
            const Pose2D pose = odometry ? slam.add(time, scan, *odometry) : slam.add(time, scan);
            std::vector<SlamEvent> events = slam.events();
            events.erase(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(before));
            return std::pair(pose, std::move(events));
          },
          "time"_a, "scan"_a, "odometry"_a.none(), WithoutGil(),
          "One scan, measured at `time` [s]; where the robot is, and events that began.")
      .def(
          "map", [](const Slam& slam, int component) { return slam.map(component); }, "component"_a = 0, WithoutGil(),
          "The map so far, of one component.")
      .def(
          "trajectory", [](const Slam& slam) { return rows_of(slam.trajectory()); },
          "(N, 4) float64: time [s], x [m], y [m], heading [rad] at each scan.")
      .def(
          "components",
          [](const Slam& slam) {
            std::vector<int> components;
            for (const StampedPose& pose : slam.trajectory()) components.push_back(pose.component);
            return components;
          },
          "The component of the pose graph that each scan belongs to; 0 is the map's.")
      .def(
          "events", [](const Slam& slam) { return slam.events(); }, "What was wrong with the input, in order of time.")
      .def(
          "closures", [](const Slam& slam) { return rows_of(slam.closures()); },
          "(N, 5) float64: earlier and later time [s], x [m], y [m], heading [rad] of the later pose seen from the "
          "earlier one.")
      .def(
          "save", [](const Slam& slam, const std::string& path) { slam.save(path); }, "path"_a, WithoutGil(),
          "Keeps the map in a file with all that is behind it.")
      .def_static(
          "load",
          [](const std::string& path, std::optional<Pose2D> map_from_base) {
            return new Slam(slam::Slam::load(path, map_from_base));
          },
          "path"_a, "map_from_base"_a = nb::none(), WithoutGil(),
          "A map that was kept, to be looked at or to go on with.");
}
