// Poses, velocities, sensor samples, assets.
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/variant.h>

#include <fmt/ranges.h>

#include "as_array.hpp"
#include "bindings.hpp"
#include "core/names.hpp"
#include "core/targets.hpp"
#include "named_enum.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/samples.hpp"
#include "value.hpp"

namespace {

using namespace threewe;

std::string repr(const Pose2D& p) { return fmt::format("Pose2D(x={:.3f}, y={:.3f}, theta={:.3f})", p.x, p.y, p.theta); }
std::string repr(const Velocity& v) {
  return fmt::format("Velocity(vx={:.3f}, vy={:.3f}, omega={:.3f})", v.vx, v.vy, v.omega);
}
std::string unknown(std::string_view kind, std::string_view name, const std::vector<std::string>& candidates) {
  return unknown_name(kind, name, candidates);
}

nb::object iterate(nb::handle values) { return nb::steal(PyObject_GetIter(values.ptr())); }
nb::object as_tuple(nb::handle values) { return nb::tuple(values); }

void bind_poses(nb::module_& m) {
  nb::class_<Pose2D>(m, "Pose2D",
                     "A pose in the plane: position [m] and heading [rad] in (-pi, pi], X forward, Y left.\n\n"
                     "A transform is a pose too: `map_from_base * base_from_lidar` is `map_from_lidar`.")
      .def(Value())
      .def(
          "__init__",
          [](Pose2D* self, double x, double y, double theta) { new (self) Pose2D{x, y, wrap_angle(theta)}; },
          "x"_a = 0.0, "y"_a = 0.0, "theta"_a = 0.0)
      .def_ro("x", &Pose2D::x, "[m]")
      .def_ro("y", &Pose2D::y, "[m]")
      .def_ro("theta", &Pose2D::theta, "[rad], counter-clockwise, in (-pi, pi]")
      .def(
          "__mul__", [](const Pose2D& a, const Pose2D& b) { return a * b; }, "b_from_c"_a, nb::is_operator())
      .def(
          "transform", [](const Pose2D& a, Vec2 point) { return a * point; }, "point"_a,
          "The point (x, y) [m] of this pose's frame, seen from outside.")
      .def(
          "inverse", [](const Pose2D& pose) { return inverse(pose); }, "`b_from_a` of `a_from_b`.")
      .def(
          "distance", [](const Pose2D& a, const Pose2D& b) { return distance(a.position(), b.position()); }, "other"_a,
          "Between the positions [m].")
      .def(
          "__iter__", [](const Pose2D& p) { return iterate(nb::make_tuple(p.x, p.y, p.theta)); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"), "x, y, theta")
      .def(AsArray("(3,) float64: x, y [m], theta [rad]", as_tuple, true))
      .def("__len__", [](const Pose2D&) { return 3; })
      .def("__repr__", [](const Pose2D& pose) { return repr(pose); });

  nb::class_<Velocity>(m, "Velocity",
                       "A velocity in the body frame: forward, left [m/s] and counter-clockwise [rad/s].")
      .def(Value())
      .def(nb::init<double, double, double>(), "vx"_a = 0.0, "vy"_a = 0.0, "omega"_a = 0.0)
      .def_ro("vx", &Velocity::vx, "[m/s], forward")
      .def_ro("vy", &Velocity::vy, "[m/s], to the left")
      .def_ro("omega", &Velocity::omega, "[rad/s], counter-clockwise")
      .def(
          "__iter__", [](const Velocity& v) { return iterate(nb::make_tuple(v.vx, v.vy, v.omega)); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"), "vx, vy, omega")
      .def(AsArray("(3,) float64: vx, vy [m/s], omega [rad/s]", as_tuple, true))
      .def("__len__", [](const Velocity&) { return 3; })
      .def("__repr__", [](const Velocity& velocity) { return repr(velocity); });
}

void bind_scans(nb::module_& m) {
  nb::class_<LaserScan>(
      m, "LaserScan",
      "One turn of a planar lidar.\n\n"
      "Beam i points along `angle_min + i * angle_increment`, counter-clockwise, in the sensor's frame, and was\n"
      "measured `i * time_increment` seconds after beam 0 (before it, where that is negative).")
      .def(Value())
      .def(
          "__init__",
          [](LaserScan* self, const nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>& ranges,
             double angle_min, double angle_increment, double range_min, double range_max, double time_increment) {
            new (self)
                LaserScan{angle_min, angle_increment, time_increment,
                          range_min, range_max,       std::vector<float>(ranges.data(), ranges.data() + ranges.size())};
          },
          "ranges"_a, "angle_min"_a, "angle_increment"_a, "range_min"_a, "range_max"_a, "time_increment"_a = 0.0)
      .def_prop_ro(
          "ranges",
          [](const LaserScan& scan) { return ArrayView<float, nb::ndim<1>>(scan.ranges.data(), {scan.ranges.size()}); },
          nb::rv_policy::reference_internal, "(N,) float32 [m]; no return = range_max, invalid = 0.0")
      .def(AsArray("`ranges`", [](nb::handle scan) { return nb::object(scan.attr("ranges")); }))
      .def("__len__", [](const LaserScan& scan) { return scan.ranges.size(); })
      .def(
          "__iter__", [](nb::handle scan) { return iterate(scan.attr("ranges")); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"), "the ranges")
      .def_ro("angle_min", &LaserScan::angle_min, "[rad], of beam 0")
      .def_ro("angle_increment", &LaserScan::angle_increment, "[rad], positive")
      .def_ro("time_increment", &LaserScan::time_increment, "[s], negative for a device that turns clockwise")
      .def_ro("range_min", &LaserScan::range_min, "[m]")
      .def_ro("range_max", &LaserScan::range_max, "[m]")
      .def("__repr__", [](const LaserScan& scan) {
        std::size_t hits = 0;
        for (const float range : scan.ranges)
          hits += range > 0.0F && range < static_cast<float>(scan.range_max) ? 1 : 0;
        return fmt::format("LaserScan({} beams, {} hits, range_max={:.1f} m)", scan.ranges.size(), hits,
                           scan.range_max);
      });
}

using ColorView = ArrayView<std::uint8_t, nb::shape<-1, -1, 3>>;
template <typename T>
using PixelView = ArrayView<T, nb::ndim<2>>;

ColorView color_of(const RGBDImage& image) {
  const auto [width, height] = std::pair(image.intrinsics.width, image.intrinsics.height);
  return {image.color.data(), {static_cast<std::size_t>(height), static_cast<std::size_t>(width), 3}};
}

template <typename T>
PixelView<T> pixels_of(const std::vector<T>& pixels, const CameraIntrinsics& camera) {
  return {pixels.data(), {static_cast<std::size_t>(camera.height), static_cast<std::size_t>(camera.width)}};
}

std::string size_of(const CameraIntrinsics& camera) { return fmt::format("{} x {}", camera.width, camera.height); }

void bind_images(nb::module_& m) {
  nb::class_<CameraIntrinsics>(
      m, "CameraIntrinsics",
      "A pinhole without distortion: a point (x forward, y left, z up) of the camera's frame is seen at column\n"
      "cx - fx y / x and row cy - fy z / x; the middle of the first pixel is at (0.5, 0.5).")
      .def(Value())
      .def(
          "__init__",
          [](CameraIntrinsics* self, int width, int height, double fx, double fy, double cx, double cy) {
            const CameraIntrinsics camera{width, height, fx, fy, cx, cy};
            check(camera);
            new (self) CameraIntrinsics(camera);
          },
          "width"_a, "height"_a, "fx"_a, "fy"_a, "cx"_a, "cy"_a)
      .def_static(
          "of_view",
          [](int width, int height, double horizontal_fov) {
            const CameraIntrinsics camera = make_intrinsics(width, height, horizontal_fov);
            check(camera);
            return camera;
          },
          "width"_a, "height"_a, "horizontal_fov"_a, "One that sees `horizontal_fov` [rad] with square pixels.")
      .def_ro("width", &CameraIntrinsics::width, "[px]")
      .def_ro("height", &CameraIntrinsics::height, "[px]")
      .def_ro("fx", &CameraIntrinsics::fx, "[px]")
      .def_ro("fy", &CameraIntrinsics::fy, "[px]")
      .def_ro("cx", &CameraIntrinsics::cx, "[px]")
      .def_ro("cy", &CameraIntrinsics::cy, "[px]")
      .def("__repr__", [](const CameraIntrinsics& camera) {
        return fmt::format("CameraIntrinsics({}, fx={:.1f}, fy={:.1f}, cx={:.1f}, cy={:.1f})", size_of(camera),
                           camera.fx, camera.fy, camera.cx, camera.cy);
      });

  nb::class_<Picture>(m, "RGBDImage", "One image of a camera. Arrays are read-only views.")
      .def(Value())
      .def(NoArray("`color` or `depth`"))
      .def_prop_ro(
          "color", [](const Picture& picture) { return color_of(picture.image()); }, nb::rv_policy::reference_internal,
          "(H, W, 3) uint8, BGR")
      .def_prop_ro(
          "depth",
          [](const Picture& picture) -> std::optional<PixelView<float>> {
            const RGBDImage& image = picture.image();
            if (image.depth.empty()) return std::nullopt;
            return pixels_of(image.depth, image.intrinsics);
          },
          nb::rv_policy::reference_internal,
          "(H, W) float32 [m] along the optical axis, invalid = 0.0; None of a camera that measures none")
      .def_prop_ro("intrinsics", [](const Picture& picture) { return picture.image().intrinsics; })
      .def("__repr__", [](const Picture& picture) {
        const RGBDImage& image = picture.image();
        return fmt::format("RGBDImage({}{})", size_of(image.intrinsics), image.depth.empty() ? ", no depth" : "");
      });

  nb::class_<SemanticImage>(m, "SemanticImage", "What is truly there to be seen. Arrays are read-only views.")
      .def(Value())
      .def(NoArray("`color`, `depth` or `ids`"))
      .def_prop_ro(
          "color", [](const SemanticImage& truth) { return color_of(truth.image); }, nb::rv_policy::reference_internal,
          "(H, W, 3) uint8, BGR, without noise")
      .def_prop_ro(
          "depth", [](const SemanticImage& truth) { return pixels_of(truth.image.depth, truth.image.intrinsics); },
          nb::rv_policy::reference_internal, "(H, W) float32 [m] along the optical axis, nothing there = 0.0")
      .def_prop_ro(
          "ids", [](const SemanticImage& truth) { return pixels_of(truth.ids, truth.image.intrinsics); },
          nb::rv_policy::reference_internal, "(H, W) int16, of what each pixel shows")
      .def_ro("names", &SemanticImage::names,
              "What ids mean, by id: nothing, floor, wall, ceiling, then objects, people and robots.")
      .def_prop_ro("intrinsics", [](const SemanticImage& truth) { return truth.image.intrinsics; })
      .def("__repr__", [](const SemanticImage& truth) {
        return fmt::format("SemanticImage({})", size_of(truth.image.intrinsics));
      });
}

void bind_samples(nb::module_& m) {
  nb::class_<IMUData>(m, "IMUData", "One reading of the inertial unit, in the robot's base frame.")
      .def(Value())
      .def(NoArray("`angular_velocity` or `linear_acceleration`"))
      .def(nb::init<std::array<double, 3>, std::array<double, 3>>(), "angular_velocity"_a, "linear_acceleration"_a)
      .def_prop_ro(
          "angular_velocity",
          [](const IMUData& imu) { return ArrayView<double, nb::shape<3>>(imu.angular_velocity.data(), {3}); },
          nb::rv_policy::reference_internal, "(3,) float64 [rad/s] about x, y, z")
      .def_prop_ro(
          "linear_acceleration",
          [](const IMUData& imu) { return ArrayView<double, nb::shape<3>>(imu.linear_acceleration.data(), {3}); },
          nb::rv_policy::reference_internal, "(3,) float64 [m/s^2] along x, y, z, with gravity: +9.81 on z at rest")
      .def("__repr__", [](const IMUData& imu) {
        return fmt::format("IMUData(angular_velocity=[{:.4f}], linear_acceleration=[{:.3f}])",
                           fmt::join(imu.angular_velocity, ", "), fmt::join(imu.linear_acceleration, ", "));
      });

  nb::class_<Odometry>(m, "Odometry", "Where the wheels alone say that the robot is, and how fast it moves.")
      .def(Value())
      .def(NoArray("`pose` or `velocity`"))
      .def(nb::init<Pose2D, Velocity>(), "pose"_a, "velocity"_a)
      .def_ro("pose", &Odometry::pose, "in the `odom` frame")
      .def_ro("velocity", &Odometry::velocity, "in the body frame")
      .def("__repr__", [](const Odometry& odometry) {
        return "Odometry(pose=" + repr(odometry.pose) + ", velocity=" + repr(odometry.velocity) + ")";
      });

  nb::class_<BatteryState>(m, "BatteryState", "The state of the battery.")
      .def(Value())
      .def(nb::init<double, double, double>(), "voltage"_a, "current"_a, "charge"_a)
      .def_ro("voltage", &BatteryState::voltage, "[V]")
      .def_ro("current", &BatteryState::current, "[A], positive when discharging")
      .def_ro("charge", &BatteryState::charge, "the fraction left, 0 to 1")
      .def("__repr__", [](const BatteryState& battery) {
        return fmt::format("BatteryState({:.0f} %, {:.2f} V, {:.2f} A)", 100.0 * battery.charge, battery.voltage,
                           battery.current);
      });

  nb::class_<RangeData>(m, "RangeData",
                        "One reading of a sensor that tells the distance to something within a cone, not where in it.")
      .def(Value())
      .def(nb::init<double, double, double, double>(), "field_of_view"_a, "range_min"_a, "range_max"_a, "range"_a)
      .def_ro("field_of_view", &RangeData::field_of_view, "[rad] from edge to edge of the cone")
      .def_ro("range_min", &RangeData::range_min, "[m]")
      .def_ro("range_max", &RangeData::range_max, "[m]")
      .def_ro("range", &RangeData::range, "[m]; no return = range_max, invalid = 0.0")
      .def("__repr__", [](const RangeData& echo) {
        return fmt::format("RangeData({:.3f} m, range_max={:.1f} m)", echo.range, echo.range_max);
      });

  bind_images(m);

  NamedEnum<SensorType>(m, "SensorType", "The kinds of sensor that the contract knows.")
      .value("lidar", SensorType::lidar)
      .value("imu", SensorType::imu)
      .value("odometry", SensorType::odometry)
      .value("battery", SensorType::battery)
      .value("ultrasonic", SensorType::ultrasonic)
      .value("camera", SensorType::camera);

  nb::class_<Sample>(m, "Sample", "A reading with its stamps.")
      .def(Value())
      .def(
          "__init__",
          [](Sample* self, std::uint16_t sensor, std::uint64_t sequence, Time measured, SampleData data) {
            new (self) Sample{sensor, sequence, measured, Time{}, std::move(data)};
          },
          "sensor"_a, "sequence"_a, "measured"_a, "data"_a)
      .def_ro("sensor", &Sample::sensor, "Index into `Features.sensors`.")
      .def_ro("sequence", &Sample::sequence, "Counts each sensor's samples from 0, without gaps.")
      .def_ro("measured", &Sample::measured, "[s] of robot time; for a scan, of beam 0 of the array")
      .def_ro("received", &Sample::received, "[s] of robot time")
      .def_ro("data", &Sample::data)
      .def("__repr__", [](const Sample& sample) {
        constexpr std::array kTypes = {"LaserScan", "IMUData", "Odometry", "BatteryState", "RangeData", "RGBDImage"};
        return fmt::format("Sample({} {} of sensor {}, measured {:.3f} s, received {:.3f} s)",
                           kTypes[sample.data.index()], sample.sequence, sample.sensor, to_seconds(sample.measured),
                           to_seconds(sample.received));
      });
}

void bind_targets(nb::module_& m) {
  m.def("active_target", &active_target, "The vector instructions in use, such as AVX2. Results do not depend on it.");
  m.def("available_targets", &available_targets, "Those that this machine can run, fastest first.");
  m.def("force_target", &force_target, "name"_a, "Uses one of them, or the fastest again when `name` is empty.");
}

void bind_assets(nb::module_& m) {
  m.def("add_asset_directory", &add_asset_directory, "directory"_a,
        nb::sig("def add_asset_directory(directory: str | pathlib.Path) -> None"),
        "Adds a folder with `scenes/`, `objects/`, `robots/` or `localization/` to those searched, as THREEWE_PATH "
        "does.");
  m.def("asset_directories", &asset_directories,
        "The folders that are searched: the installed one, those in THREEWE_PATH, then those added.");
  m.def("unknown_name", &unknown, "kind"_a, "name"_a, "candidates"_a,
        "\"unknown scene 'ofice_v2'; did you mean 'office_v2'?\"");
}

}  // namespace

void init_core(nb::module_& m) {
  bind_poses(m);
  bind_scans(m);
  bind_samples(m);
  bind_targets(m);
  bind_assets(m);
}
