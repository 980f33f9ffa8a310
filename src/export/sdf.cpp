// SDF for Gazebo Harmonic: a model of the robot and a world that includes it.
#include <fmt/format.h>

#include "sdf_sensors.hpp"
#include "writers.hpp"
#include "xml.hpp"

namespace threewe::exports {
namespace {

constexpr const char* kVersion = "1.9";
constexpr double kStep = 0.002;  // [s] of the physics

pugi::xml_node add_root(pugi::xml_document& document) {
  pugi::xml_node root = add(document, "sdf", {{"version", kVersion}});
  root.append_attribute("xmlns:gz").set_value("http://gazebosim.org/schema");
  return root;
}

void add_geometry(pugi::xml_node parent, const Shape& shape) {
  pugi::xml_node geometry = add(parent, "geometry");
  switch (shape.kind) {
    case Shape::Kind::box: add_text(add(geometry, "box"), "size", text(shape.size)); return;
    case Shape::Kind::cylinder: {
      pugi::xml_node cylinder = add(geometry, "cylinder");
      add_text(cylinder, "radius", shape.size.x);
      add_text(cylinder, "length", shape.size.z);
      return;
    }
    case Shape::Kind::sphere: add_text(add(geometry, "sphere"), "radius", shape.size.x); return;
    case Shape::Kind::ellipsoid: add_text(add(geometry, "ellipsoid"), "radii", text(shape.size)); return;
  }
}

void add_visual(pugi::xml_node link, const Shape& shape) {
  pugi::xml_node visual = add(link, "visual", {{"name", shape.name}});
  add_text(visual, "pose", sdf_pose(shape.pose));
  add_geometry(visual, shape);
  pugi::xml_node material = add(visual, "material");
  add_text(material, "ambient", text(shape.color));
  add_text(material, "diffuse", text(shape.color));
}

pugi::xml_node add_collision(pugi::xml_node link, const Shape& shape) {
  pugi::xml_node collision = add(link, "collision", {{"name", shape.name}});
  add_text(collision, "pose", sdf_pose(shape.pose));
  add_geometry(collision, shape);
  return collision;
}

// Friction with the floor; a mecanum wheel holds along one direction alone.
void add_friction(pugi::xml_node collision, double friction, double across, const Vec3* direction,
                  const std::string& frame) {
  pugi::xml_node ode = add(add(add(collision, "surface"), "friction"), "ode");
  add_text(ode, "mu", friction);
  add_text(ode, "mu2", across);
  if (direction == nullptr) return;
  add(ode, "fdir1", {{"gz:expressed_in", frame}}).text().set(text(*direction).c_str());
}

void add_inertial(pugi::xml_node link, const Inertia& part) {
  pugi::xml_node inertial = add(link, "inertial");
  add_text(inertial, "pose", sdf_pose({part.center, {}}));
  add_text(inertial, "mass", part.mass);
  pugi::xml_node inertia = add(inertial, "inertia");
  const auto& [xx, yy, zz] = part.moments;
  for (const auto& [name, value] :
       {std::pair{"ixx", xx}, {"ixy", 0.0}, {"ixz", 0.0}, {"iyy", yy}, {"iyz", 0.0}, {"izz", zz}}) {
    add_text(inertia, name, value);
  }
}

// Of the body with anything; casters roll on the floor.
void add_contact_sensor(pugi::xml_node link, const Link& base) {
  pugi::xml_node sensor = add(link, "sensor", {{"name", "contacts"}, {"type", "contact"}});
  add_text(sensor, "always_on", "true");
  pugi::xml_node contact = add(sensor, "contact");
  for (const Shape& shape : base.shapes) {
    if (shape.kind != Shape::Kind::sphere) add_text(contact, "collision", shape.name);
  }
  add_text(contact, "topic", "contacts");
}

void add_base(pugi::xml_node model, const RobotDescription& robot) {
  pugi::xml_node link = add(model, "link", {{"name", robot.base().name}});
  add_inertial(link, robot.base().inertia);
  for (const Shape& shape : robot.base().shapes) {
    add_visual(link, shape);
    pugi::xml_node collision = add_collision(link, shape);
    if (shape.kind == Shape::Kind::sphere) add_friction(collision, 0.0, 0.0, nullptr, {});
  }
  for (const SensorMount& mount : robot.sensors) add_sdf_sensor(link, mount, robot.profile, mount.base_from_sensor);
  add_contact_sensor(link, robot.base());
}

// In Gazebo, a mecanum wheel touches the floor in one point below its axle; how it slides is stated by its friction.
void add_wheel(pugi::xml_node model, const RobotDescription& robot, std::size_t wheel) {
  const Link& part = robot.links[wheel + 1];
  const double friction = robot.profile.body.friction;
  pugi::xml_node link = add(model, "link", {{"name", part.name}});
  add_text(link, "pose", sdf_pose(robot.joints[wheel].parent_from_child));
  add_inertial(link, part.inertia);
  for (const Shape& shape : part.shapes) {
    if (shape.visible) add_visual(link, shape);
    if (!shape.collides) continue;
    if (robot.profile.kinematics() == Kinematics::differential) {
      add_friction(add_collision(link, shape), friction, friction, nullptr, {});
    } else {
      const Vec3 direction = friction_direction(wheel);
      add_friction(add_collision(link, shape), friction, 0.0, &direction, robot.base().name);
    }
  }
}

void add_joint(pugi::xml_node model, const Joint& part, const WheelDrive& drive) {
  pugi::xml_node joint = add(model, "joint", {{"name", part.name}, {"type", "revolute"}});
  add_text(joint, "parent", part.parent);
  add_text(joint, "child", part.child);
  pugi::xml_node axis = add(joint, "axis");
  add_text(axis, "xyz", text(part.axis));
  pugi::xml_node limit = add(axis, "limit");
  add_text(limit, "lower", "-inf");
  add_text(limit, "upper", "inf");
  add_text(limit, "effort", drive.stall_torque);
  add_text(limit, "velocity", drive.stall_torque / drive.damping);
}

pugi::xml_node add_plugin(pugi::xml_node parent, const char* file, const char* name) {
  return add(
      parent, "plugin",
      {{"filename", fmt::format("gz-sim-{}-system", file)}, {"name", fmt::format("gz::sim::systems::{}", name)}});
}

// Where the model is in the world, as odometry.
void add_true_motion(pugi::xml_node model, const RobotDescription& robot, const char* topic, const char* transforms,
                     double rate) {
  pugi::xml_node truth = add_plugin(model, "odometry-publisher", "OdometryPublisher");
  add_text(truth, "odom_topic", topic);
  add_text(truth, "tf_topic", transforms);
  add_text(truth, "odom_publish_frequency", rate);
  add_text(truth, "odom_frame", "odom");
  add_text(truth, "robot_base_frame", robot.base().name);
}

void add_drive(pugi::xml_node model, const RobotDescription& robot) {
  const WheelGeometry& wheels = robot.profile.body.wheels;
  const Limits& limits = robot.profile.hardware_limits;
  const bool mecanum = wheels.kinematics == Kinematics::holonomic;
  pugi::xml_node drive =
      mecanum ? add_plugin(model, "mecanum-drive", "MecanumDrive") : add_plugin(model, "diff-drive", "DiffDrive");
  const std::vector<const char*> joints =
      mecanum ? std::vector{"front_left_joint", "front_right_joint", "back_left_joint", "back_right_joint"}
              : std::vector{"left_joint", "right_joint"};
  for (std::size_t i = 0; i < joints.size(); ++i) add_text(drive, joints[i], robot.joints[i].name);
  add_text(drive, "wheel_separation", 2 * wheels.half_width);
  if (mecanum) add_text(drive, "wheelbase", 2 * wheels.half_length);
  add_text(drive, "wheel_radius", wheels.radius);
  add_text(drive, "min_linear_velocity", -limits.linear);
  add_text(drive, "max_linear_velocity", limits.linear);
  add_text(drive, "min_angular_velocity", -limits.angular);
  add_text(drive, "max_angular_velocity", limits.angular);
  add_text(drive, "min_linear_acceleration", -limits.linear_braking);
  add_text(drive, "max_linear_acceleration", limits.linear_acceleration);
  add_text(drive, "min_angular_acceleration", -limits.angular_acceleration);
  add_text(drive, "max_angular_acceleration", limits.angular_acceleration);
  add_text(drive, "odom_publish_frequency", 1 / to_seconds(robot.profile.odometry.period));
  add_text(drive, "topic", "cmd_vel");
  // Gazebo's mecanum drive computes as if wheels never moved sideways, so that the true motion is its odometry instead
  add_text(drive, "odom_topic", mecanum ? "wheel_odom" : "odom");
  add_text(drive, "tf_topic", mecanum ? "wheel_tf" : "tf");
  add_text(drive, "frame_id", "odom");
  add_text(drive, "child_frame_id", robot.base().name);

  if (mecanum) add_true_motion(model, robot, "odom", "tf", 1 / to_seconds(robot.profile.odometry.period));
  add_true_motion(model, robot, "true_odom", "true_tf", 1 / kStep);
  add_plugin(model, "joint-state-publisher", "JointStatePublisher");
}

std::string model_sdf(const RobotDescription& robot) {
  pugi::xml_document document;
  pugi::xml_node model = add(add_root(document), "model", {{"name", robot.profile.name}});
  model.append_attribute("canonical_link").set_value(robot.base().name.c_str());
  for (const SensorMount& mount : robot.sensors) {
    pugi::xml_node frame = add(model, "frame", {{"name", mount.name}, {"attached_to", robot.base().name}});
    add_text(frame, "pose", sdf_pose(mount.base_from_sensor));
  }
  add_base(model, robot);
  for (std::size_t wheel = 0; wheel < robot.joints.size(); ++wheel) {
    add_wheel(model, robot, wheel);
    add_joint(model, robot.joints[wheel], robot.drive);
  }
  add_drive(model, robot);
  return to_string(document);
}

std::string model_config(const RobotDescription& robot) {
  pugi::xml_document document;
  pugi::xml_node model = add(document, "model");
  add_text(model, "name", robot.profile.name);
  add(model, "sdf", {{"version", kVersion}}).text().set("model.sdf");
  add_text(model, "description", robot.profile.description);
  return to_string(document);
}

pugi::xml_node add_static_model(pugi::xml_node world, const std::string& name) {
  pugi::xml_node model = add(world, "model", {{"name", name}});
  add_text(model, "static", "true");
  return add(model, "link", {{"name", "link"}});
}

void add_static_models(pugi::xml_node world, const SceneBlocks& blocks, double friction) {
  pugi::xml_node floor = add_static_model(world, "floor");
  for (const FloorTile& tile : blocks.floor_looks) add_visual(floor, floor_box(tile));
  for (const FloorTile& tile : blocks.floor_friction) {
    const double of_tile = friction * tile.friction;
    add_friction(add_collision(floor, floor_box(tile)), of_tile, of_tile, nullptr, {});
  }
  pugi::xml_node walls = add_static_model(world, "walls");
  for (const Shape& wall : blocks.walls) {
    add_visual(walls, wall);
    add_collision(walls, wall);
  }
  pugi::xml_node furniture = add_static_model(world, "furniture");
  for (const Shape& shape : blocks.furniture) {
    add_visual(furniture, shape);
    add_collision(furniture, shape);
  }
  for (const Shape& ceiling : blocks.ceiling) add_visual(add_static_model(world, "ceiling"), ceiling);
  for (Shape person : blocks.people) {
    const std::string name = "person_" + person.name;
    pugi::xml_node link = add_static_model(world, name);
    add_text(link, "pose", sdf_pose({{person.pose.position.x, person.pose.position.y, 0.0}, {}}));
    person.pose.position = {0.0, 0.0, person.pose.position.z};
    add_visual(link, person);
    add_collision(link, person);
  }
}

std::string world_sdf(const scene::Scene& scene, const RobotDescription& robot) {
  pugi::xml_document document;
  pugi::xml_node world = add(add_root(document), "world", {{"name", scene.name}});
  pugi::xml_node physics = add(world, "physics", {{"name", "2ms"}, {"type", "dart"}});
  add_text(physics, "max_step_size", kStep);
  add_text(physics, "real_time_factor", 1.0);
  add_plugin(world, "physics", "Physics");
  add_text(add_plugin(world, "sensors", "Sensors"), "render_engine", "ogre2");
  add_plugin(world, "imu", "Imu");
  add_plugin(world, "contact", "Contact");
  add_plugin(world, "scene-broadcaster", "SceneBroadcaster");
  add_plugin(world, "user-commands", "UserCommands");
  pugi::xml_node sun = add(world, "light", {{"name", "sun"}, {"type", "directional"}});
  add_text(sun, "cast_shadows", "false");
  add_text(sun, "direction", "0.3 0.2 -1");
  add_static_models(world, blocks_of(scene), robot.profile.body.friction);
  add_text(add(world, "include"), "uri", "model://" + robot.profile.name);
  return to_string(document);
}

}  // namespace

std::vector<File> sdf_files(const scene::Scene& scene, const RobotDescription& robot) {
  const std::filesystem::path model = std::filesystem::path("models") / robot.profile.name;
  return {{"world.sdf", world_sdf(scene, robot)},
          {model / "model.sdf", model_sdf(robot)},
          {model / "model.config", model_config(robot)}};
}

}  // namespace threewe::exports
