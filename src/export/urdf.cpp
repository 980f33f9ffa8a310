// URDF: the robot for ROS 2, with ros2_control and sensors, and the scene as one fixed link for programs that read
// URDF.
#include <algorithm>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "sdf_sensors.hpp"
#include "writers.hpp"
#include "xml.hpp"

namespace threewe::exports {
namespace {

void add_origin(pugi::xml_node parent, const Transform& pose) {
  add(parent, "origin", {{"xyz", text(pose.position)}, {"rpy", text(roll_pitch_yaw(pose.rotation))}});
}

void add_geometry(pugi::xml_node parent, const Shape& shape) {
  pugi::xml_node geometry = add(parent, "geometry");
  switch (shape.kind) {
    case Shape::Kind::box: add(geometry, "box", {{"size", text(shape.size)}}); return;
    case Shape::Kind::cylinder:
      add(geometry, "cylinder", {{"radius", text(shape.size.x)}, {"length", text(shape.size.z)}});
      return;
    case Shape::Kind::sphere:
    case Shape::Kind::ellipsoid: add(geometry, "sphere", {{"radius", text(shape.size.x)}}); return;
  }
}

// URDF knows no ellipsoids: a tyre becomes the cylinder around it.
Shape cylinder_around(Shape tyre) {
  tyre.kind = Shape::Kind::cylinder;
  tyre.pose.rotation = tyre.pose.rotation * about_x(-exact::kPi / 2);
  tyre.size = {tyre.size.x, tyre.size.x, 2 * tyre.size.y};
  return tyre;
}

void add_shape(pugi::xml_node link, const Shape& shape) {
  if (shape.kind == Shape::Kind::ellipsoid) return add_shape(link, cylinder_around(shape));
  if (shape.visible) {
    pugi::xml_node visual = add(link, "visual", {{"name", shape.name}});
    add_origin(visual, shape.pose);
    add_geometry(visual, shape);
    add(add(visual, "material", {{"name", shape.name + "_color"}}), "color", {{"rgba", text(shape.color)}});
  }
  if (!shape.collides) return;
  pugi::xml_node collision = add(link, "collision", {{"name", shape.name}});
  add_origin(collision, shape.pose);
  add_geometry(collision, shape);
}

void add_link(pugi::xml_node robot, const Link& part) {
  pugi::xml_node link = add(robot, "link", {{"name", part.name}});
  pugi::xml_node inertial = add(link, "inertial");
  add_origin(inertial, {part.inertia.center, {}});
  add(inertial, "mass", {{"value", text(part.inertia.mass)}});
  const auto& [xx, yy, zz] = part.inertia.moments;
  add(inertial, "inertia",
      {{"ixx", text(xx)}, {"ixy", "0"}, {"ixz", "0"}, {"iyy", text(yy)}, {"iyz", "0"}, {"izz", text(zz)}});
  for (const Shape& shape : part.shapes) add_shape(link, shape);
}

void add_fixed_frame(pugi::xml_node robot, const std::string& parent, const std::string& child, const Transform& pose) {
  add(robot, "link", {{"name", child}});
  pugi::xml_node joint = add(robot, "joint", {{"name", child + "_joint"}, {"type", "fixed"}});
  add(joint, "parent", {{"link", parent}});
  add(joint, "child", {{"link", child}});
  add_origin(joint, pose);
}

void add_wheel_joint(pugi::xml_node robot, const Joint& part, const WheelDrive& drive) {
  pugi::xml_node joint = add(robot, "joint", {{"name", part.name}, {"type", "continuous"}});
  add(joint, "parent", {{"link", part.parent}});
  add(joint, "child", {{"link", part.child}});
  add_origin(joint, part.parent_from_child);
  add(joint, "axis", {{"xyz", text(part.axis)}});
  const double no_load_speed = drive.stall_torque / drive.damping;
  add(joint, "limit", {{"effort", text(drive.stall_torque)}, {"velocity", text(no_load_speed)}});
}

// What URDF itself knows of sensors; the frame is the link of the sensor's name.
void add_sensor(pugi::xml_node root, const SensorMount& mount, const RobotProfile& profile) {
  if (mount.type == SensorType::imu || mount.type == SensorType::ultrasonic) return;
  const double period = to_seconds(mount.type == SensorType::lidar ? profile.lidar->turn : profile.camera->period);
  pugi::xml_node sensor = add(root, "sensor", {{"name", mount.name}, {"update_rate", text(1 / period)}});
  add(sensor, "parent", {{"link", mount.name}});
  add_origin(sensor, {});
  if (mount.type == SensorType::lidar) {
    const Lidar scan = lidar_of(*profile.lidar);
    pugi::xml_node horizontal = add(add(sensor, "ray"), "horizontal");
    for (const auto& [key, value] : {std::pair{"samples", text(scan.samples)},
                                     {"resolution", std::string("1")},
                                     {"min_angle", text(scan.min_angle)},
                                     {"max_angle", text(scan.max_angle)}}) {
      horizontal.append_attribute(key).set_value(value.c_str());
    }
    return;
  }
  const CameraSpec& camera = *profile.camera;
  add(add(sensor, "camera"), "image",
      {{"width", text(camera.width)},
       {"height", text(camera.height)},
       {"format", "BGR8"},
       {"hfov", text(camera.horizontal_fov)},
       {"near", text(camera.depth ? camera.depth->range_min : kCameraNear)},
       {"far", text(camera.depth ? camera.depth->range_max : kCameraFar)}});
}

// The wheels for ros2_control; the plugin is that of its Gazebo, another machine's launch file names its own.
void add_control(pugi::xml_node root, const RobotDescription& robot) {
  pugi::xml_node control = add(root, "ros2_control", {{"name", "wheels"}, {"type", "system"}});
  add_text(add(control, "hardware"), "plugin", "gz_ros2_control/GazeboSimSystem");
  const double no_load_speed = robot.drive.stall_torque / robot.drive.damping;
  for (const Joint& part : robot.joints) {
    pugi::xml_node joint = add(control, "joint", {{"name", part.name}});
    pugi::xml_node command = add(joint, "command_interface", {{"name", "velocity"}});
    for (const auto& [key, limit] : {std::pair{"min", -no_load_speed}, {"max", no_load_speed}}) {
      add(command, "param", {{"name", key}}).text().set(text(limit).c_str());
    }
    for (const char* state : {"position", "velocity"}) add(joint, "state_interface", {{"name", state}});
  }
}

void add_gazebo(pugi::xml_node root, const RobotDescription& robot) {
  for (std::size_t wheel = 0; wheel < robot.joints.size(); ++wheel) {
    pugi::xml_node reference = add(root, "gazebo", {{"reference", robot.joints[wheel].child}});
    const bool mecanum = robot.profile.kinematics() == Kinematics::holonomic;
    const double friction = robot.profile.body.friction;
    add_text(reference, "mu1", friction);
    add_text(reference, "mu2", mecanum ? 0.0 : friction);
    if (!mecanum) continue;
    pugi::xml_node direction = add(reference, "fdir1", {{"gz:expressed_in", robot.base().name}});
    direction.text().set(text(friction_direction(wheel)).c_str());
  }
  for (const SensorMount& mount : robot.sensors) {
    add_sdf_sensor(add(root, "gazebo", {{"reference", mount.name}}), mount, robot.profile, {});
  }
}

std::string robot_urdf(const RobotDescription& robot) {
  pugi::xml_document document;
  pugi::xml_node root = add(document, "robot", {{"name", robot.profile.name}});
  root.append_attribute("xmlns:gz").set_value("http://gazebosim.org/schema");
  // ROS asks for a first link without mass; it is the base, too
  add(root, "link", {{"name", "base_footprint"}});
  add_link(root, robot.base());
  pugi::xml_node joint = add(root, "joint", {{"name", "base_joint"}, {"type", "fixed"}});
  add(joint, "parent", {{"link", "base_footprint"}});
  add(joint, "child", {{"link", robot.base().name}});
  add_origin(joint, {});
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    add_link(root, robot.links[i + 1]);
    add_wheel_joint(root, robot.joints[i], robot.drive);
  }
  for (const SensorMount& mount : robot.sensors) {
    add_fixed_frame(root, robot.base().name, mount.name, mount.base_from_sensor);
    if (mount.type ==
        SensorType::camera) {  // REP 103: an optical frame looks along its z axis, its x axis to the right
      add_fixed_frame(root, mount.name, mount.name + "_optical_frame",
                      {{}, about_z(-exact::kPi / 2) * about_x(-exact::kPi / 2)});
    }
  }
  for (const SensorMount& mount : robot.sensors) add_sensor(root, mount, robot.profile);
  add_control(root, robot);
  add_gazebo(root, robot);
  return to_string(document);
}

std::string scene_urdf(const scene::Scene& scene) {
  const SceneBlocks blocks = blocks_of(scene);
  pugi::xml_document document;
  pugi::xml_node root = add(document, "robot", {{"name", scene.name}});
  pugi::xml_node link = add(root, "link", {{"name", "scene"}});
  for (const FloorTile& tile : blocks.floor_looks) add_shape(link, floor_box(tile));
  for (const Shape& wall : blocks.walls) add_shape(link, wall);
  for (const Shape& shape : blocks.furniture) add_shape(link, shape);
  return to_string(document);
}

}  // namespace

std::vector<File> urdf_files(const scene::Scene& scene, const RobotDescription& robot) {
  return {{"robot.urdf", robot_urdf(robot)}, {"scene.urdf", scene_urdf(scene)}};
}

}  // namespace threewe::exports
