// Robot description for physics engines: links with masses and shapes, joints, and where its sensors are. Made of its
// profile alone; every format is written from this.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "export/shape.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::exports {

/// How mass is spread. The axes of the link are its principal axes.
struct Inertia {
  double mass = 0.0;  ///< [kg]
  Vec3 center;        ///< [m] of mass, in the link's frame
  Vec3 moments;       ///< [kg m^2] about x, y and z through the centre of mass
};

/// A rigid part.
struct Link {
  std::string name;
  Inertia inertia;
  std::vector<Shape> shapes;
};

/// A hinge between two links, whose frames are the same but for `parent_from_child` while it stands at zero.
struct Joint {
  enum class Kind : std::uint8_t { wheel, roller };
  std::string name;
  Kind kind{};
  std::string parent;
  std::string child;
  Transform parent_from_child;
  Vec3 axis;  ///< in the child's frame
};

/// Where a sensor is. What it measures is in the profile.
struct SensorMount {
  SensorType type{};
  std::string name;
  Transform base_from_sensor;
};

/// What drives each wheel: a torque of `gain` times the error of its speed, never more than a motor on nominal voltage
/// gives, which falls from `stall_torque` at rest by `damping` for each rad/s.
struct WheelDrive {
  double gain = 0.0;  ///< [N m s/rad], so that the speed follows with the motor's lag while the body moves along
  double stall_torque = 0.0;  ///< [N m]
  double damping = 0.0;       ///< [N m s/rad]
};

/// A robot. The frame of its first link, `base_link`, is the base: on the floor, amid the wheels.
struct RobotDescription {
  RobotProfile profile;
  std::vector<Link> links;    ///< the base, then the wheels in the order of `WheelSpeeds`, then all rollers
  std::vector<Joint> joints;  ///< one for each link but the base, in the same order
  std::vector<SensorMount> sensors;
  WheelDrive drive;

  const Link& base() const { return links.front(); }
};

/// The robot of a profile. Mecanum wheels have their rollers: ellipsoids at 45 degrees that make the wheel a circle as
/// seen along its axle. Mass, and inertia about the vertical axis through the base, are the profile's.
RobotDescription describe(const RobotProfile& profile);
/// The same robot, its rollers made one with their wheels: for formats and programs that state by friction alone how
/// mecanum wheels slide. A wheel keeps its mass and its inertia, and touches the floor as a tyre does.
RobotDescription without_rollers(RobotDescription robot);

/// The direction along the floor, in the base frame, in which a mecanum wheel holds: its lowest roller's axle.
Vec3 friction_direction(std::size_t wheel);

/// What the whole robot has while its joints stand at zero: mass, centre of mass in the base frame, and moments about
/// axes through it that are parallel to the base's.
Inertia total_inertia(const RobotDescription& robot);

}  // namespace threewe::exports
