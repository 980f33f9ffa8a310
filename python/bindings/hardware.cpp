// Robot profiles.
#include "threewe/hardware/profile.hpp"

#include "bindings.hpp"
#include "named_enum.hpp"
#include "robot/parameters.hpp"
#include "value.hpp"

namespace {

using namespace threewe;

void bind_sensors(nb::module_& m) {
  nb::class_<LidarSpec>(m, "LidarSpec", "A lidar that turns, and the scan that is made of its turn.")
      .def(Value())
      .def_ro("base_from_lidar", &LidarSpec::base_from_lidar)
      .def_ro("height", &LidarSpec::height, "[m] of the scan plane above the floor")
      .def_ro("points_per_turn", &LidarSpec::points_per_turn, "measured by the device")
      .def_ro("clockwise", &LidarSpec::clockwise, "how the device turns; scans are always counter-clockwise")
      .def_ro("beams", &LidarSpec::beams, "in the scan that is delivered")
      .def_ro("turn", &LidarSpec::turn, "[s] of one revolution")
      .def_ro("range_min", &LidarSpec::range_min, "[m]")
      .def_ro("range_max", &LidarSpec::range_max, "[m]")
      .def_ro("sigma", &LidarSpec::sigma, "[m] of each range")
      .def_ro("latency", &LidarSpec::latency, "[s] from the end of a turn to its arrival");
  nb::class_<UltrasonicSpec>(m, "UltrasonicSpec", "Ultrasonic sensors of one kind, pinged in turn.")
      .def(Value())
      .def_prop_ro(
          "mounts",
          [](const UltrasonicSpec& spec) {
            nb::typed<nb::dict, std::string, Pose2D> mounts;
            for (const auto& [name, pose] : spec.mounts) mounts[name.c_str()] = pose;
            return mounts;
          },
          "Where each sensor is, by its name, in the order in which they are pinged.")
      .def_ro("height", &UltrasonicSpec::height, "[m] of all of them above the floor")
      .def_ro("interval", &UltrasonicSpec::interval, "[s] from one ping to the next, of another sensor")
      .def_ro("field_of_view", &UltrasonicSpec::field_of_view, "[rad] of the cone of sound, from edge to edge")
      .def_ro("max_incidence", &UltrasonicSpec::max_incidence,
              "[rad] off a surface's normal, beyond which no sound comes back")
      .def_ro("range_min", &UltrasonicSpec::range_min, "[m]")
      .def_ro("range_max", &UltrasonicSpec::range_max, "[m]")
      .def_ro("sigma", &UltrasonicSpec::sigma, "[m] of each range")
      .def_ro("latency", &UltrasonicSpec::latency, "[s] from a ping to the arrival of its range");
  nb::class_<DepthSpec>(m, "DepthSpec", "How well a camera measures depth along its optical axis.")
      .def(Value())
      .def_ro("range_min", &DepthSpec::range_min, "[m], nearer is invalid")
      .def_ro("range_max", &DepthSpec::range_max, "[m], farther is invalid")
      .def_ro("sigma", &DepthSpec::sigma, "[m] at 1 m; it grows with the square of the depth");
  nb::class_<CameraSpec>(m, "CameraSpec", "A camera: what its level, rectified pinhole view shows, and how well.")
      .def(Value())
      .def_ro("base_from_camera", &CameraSpec::base_from_camera, "It looks along its x axis.")
      .def_ro("mount_height", &CameraSpec::mount_height, "[m] of its optical axis above the floor")
      .def_prop_ro("intrinsics", &CameraSpec::intrinsics)
      .def_ro("period", &CameraSpec::period, "[s] from image to image")
      .def_ro("sigma", &CameraSpec::sigma, "[levels of 255] of each pixel's colours")
      .def_ro("latency", &CameraSpec::latency, "[s] from an image to its arrival")
      .def_ro("depth", &CameraSpec::depth);
  nb::class_<IMUSpec>(m, "IMUSpec", "An inertial unit.")
      .def(Value())
      .def_ro("period", &IMUSpec::period, "[s]")
      .def_ro("gyro_sigma", &IMUSpec::gyro_sigma, "[rad/s] of each sample")
      .def_ro("gyro_bias", &IMUSpec::gyro_bias, "[rad/s] at most, at the start")
      .def_ro("accelerometer_sigma", &IMUSpec::accelerometer_sigma, "[m/s^2]")
      .def_ro("latency", &IMUSpec::latency, "[s]");
  nb::class_<BatterySpec>(m, "BatterySpec", "A battery.")
      .def(Value())
      .def_ro("capacity", &BatterySpec::capacity, "[Wh]")
      .def_ro("voltage_full", &BatterySpec::voltage_full, "[V]")
      .def_ro("voltage_empty", &BatterySpec::voltage_empty, "[V]")
      .def_ro("period", &BatterySpec::period, "[s]");
}

void bind_parameters(nb::module_& m) {
  nb::class_<AutonomyParameter>(m, "AutonomyParameter", "A tuned number of the autonomy stack, as a robot has it.")
      .def(Value())
      .def_ro("name", &AutonomyParameter::name, "With its module, such as `nav.recovery.same_place`.")
      .def_ro("value", &AutonomyParameter::value, "In `unit`; times in seconds.")
      .def_ro("unit", &AutonomyParameter::unit, "Such as `m`; empty for a share or a count.")
      .def_ro("reference", &AutonomyParameter::reference,
              "The value of the reference robot, `3we_standard_v2`, in the profile's unit [`unit`].")
      .def_prop_ro(
          "scale", [](const AutonomyParameter& p) { return std::string(to_string(p.scale)); },
          "What it grows with from robot to robot, such as `size`; `none` where it is the same for all.")
      .def_ro("origin", &AutonomyParameter::origin,
              "`default`, the scale and its factor, or where in the profile it is overridden.")
      .def_ro("meaning", &AutonomyParameter::meaning, "What it does, in a line.")
      .def_ro("is_count", &AutonomyParameter::is_count, "A whole number.")
      .def("__repr__", [](const AutonomyParameter& p) {
        return fmt::format("AutonomyParameter('{}', {:g}{}{}, {})", p.name, p.value, p.unit.empty() ? "" : " ", p.unit,
                           p.origin);
      });
}

}  // namespace

void init_hardware(nb::module_& m) {
  NamedEnum<Kinematics>(m, "Kinematics", "How the wheels move the body.")
      .value("holonomic", Kinematics::holonomic, "any direction")
      .value("differential", Kinematics::differential, "ahead and turning, never sideways");

  nb::class_<Limits>(m, "Limits", "Bounds on a body velocity and on how fast it may change.")
      .def(Value())
      .def_ro("linear", &Limits::linear, "[m/s], of the vector (vx, vy)")
      .def_ro("angular", &Limits::angular, "[rad/s]")
      .def_ro("linear_acceleration", &Limits::linear_acceleration, "[m/s^2], speeding up")
      .def_ro("linear_braking", &Limits::linear_braking, "[m/s^2], slowing down")
      .def_ro("angular_acceleration", &Limits::angular_acceleration, "[rad/s^2]")
      .def("__repr__",
           [](const Limits& l) { return fmt::format("Limits({:.2f} m/s, {:.2f} rad/s)", l.linear, l.angular); });

  bind_sensors(m);
  bind_parameters(m);

  nb::class_<RobotProfile>(m, "RobotProfile",
                           "What a robot is: its body, its limits, its sensors. Sensors it lacks are None.")
      .def(Value())
      .def_static("load", &load_profile, "name"_a,
                  "Reads a profile by name, or from a file that ends in .yaml. Raises ConfigError naming the nearest "
                  "right name.")
      .def_static(
          "parse",
          [](std::string yaml, const std::string& name) { return parse_profile(std::move(yaml), name + ".yaml"); },
          "yaml"_a, "name"_a, "Reads a profile from the text of such a file, as `yaml` has it.")
      .def(
          "__deepcopy__", [](nb::object self, const nb::handle&) { return self; }, "memo"_a,
          "Itself: a profile never changes.")
      .def(
          "with_image_size",
          [](const RobotProfile& profile, int height, int width) { return with_image_size(profile, {width, height}); },
          "height"_a, "width"_a,
          "The same robot, whose camera delivers pictures of another size: with the same horizontal field of view and "
          "square pixels.")
      .def_ro("name", &RobotProfile::name)
      .def_ro("description", &RobotProfile::description)
      .def_ro("yaml", &RobotProfile::yaml, "The text that it was read from.")
      .def_prop_ro("kinematics", &RobotProfile::kinematics)
      .def_prop_ro(
          "footprint", [](const RobotProfile& p) { return p.body.footprint.corners(); },
          "The corners of the outline around the base, counter-clockwise [m].")
      .def_prop_ro(
          "footprint_radius", [](const RobotProfile& p) { return p.body.footprint.circumscribed_radius(); },
          "[m], of the smallest disc around the base that holds the outline")
      .def_prop_ro(
          "height", [](const RobotProfile& p) { return p.body.height; }, "[m]")
      .def_prop_ro(
          "mass", [](const RobotProfile& p) { return p.body.mass; }, "[kg]")
      .def(
          "parameters", [](const RobotProfile& p) { return autonomy_parameters(p); },
          "Every parameter of the autonomy stack for this robot, module by module. Raises ConfigError where the "
          "profile's `autonomy:` section is wrong.")
      .def_ro("hardware_limits", &RobotProfile::hardware_limits, "What the drive can do.")
      .def_ro("operating_limits", &RobotProfile::operating_limits, "What it is asked to do.")
      .def_ro("lidar", &RobotProfile::lidar)
      .def_ro("imu", &RobotProfile::imu)
      .def_ro("ultrasonics", &RobotProfile::ultrasonics)
      .def_ro("camera", &RobotProfile::camera)
      .def_ro("battery", &RobotProfile::battery)
      .def("__repr__", [](const RobotProfile& p) {
        const char* kinematics = p.kinematics() == Kinematics::holonomic ? "holonomic" : "differential";
        return fmt::format("RobotProfile('{}', {}, {:.2f} m/s, {:.2f} rad/s)", p.name, kinematics,
                           p.operating_limits.linear, p.operating_limits.angular);
      });
  m.def("profile_names", &profile_names, "The names of all robot profiles.");
}
