#include "export/mjcf.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "export/scene_blocks.hpp"
#include "xml.hpp"

namespace threewe::exports {
namespace {

// What touches what: two geoms do where a bit of `contype` of one is in `conaffinity` of the other. Surroundings touch
// robots, the bodies of robots touch one another, and nothing touches a part of the same robot.
struct Touch {
  const char* type;
  const char* affinity;
};
constexpr Touch kSurroundings{"1", "2"};
constexpr Touch kRobotBody{"6", "5"};
constexpr Touch kRobotWheel{"2", "1"};
constexpr Touch kNothing{"0", "0"};

// Groups that viewers can switch off: what is only felt, and the ceiling, are hidden in MuJoCo's own.
constexpr const char* kSeen = "0";
constexpr const char* kFelt = "3";
constexpr const char* kOverhead = "4";

constexpr const char* kInvisible = "0 0 0 0";

constexpr double kTimestep = 0.002;      // [s]
constexpr double kFloorPriority = 1;     // its friction counts, not that of wheels
constexpr double kSlidingPriority = 2;   // that of casters counts: they have none
constexpr double kBodyFriction = 0.3;    // plastic against walls and furniture (estimate)
constexpr double kRollerDamping = 1e-6;  // [N m s/rad] (estimate)

Vec3 half(const Vec3& edges) { return 0.5 * edges; }

// Adds a geom; sizes are half of ours.
pugi::xml_node add_geom(pugi::xml_node parent, const std::string& name, const Shape& shape, const Touch& touch,
                        const char* group) {
  if (!shape.visible) group = kFelt;
  const char* type = "box";
  std::string size = text(half(shape.size));
  switch (shape.kind) {
    case Shape::Kind::box: break;
    case Shape::Kind::cylinder:
      type = "cylinder";
      size = fmt::format("{} {}", text(shape.size.x), text(0.5 * shape.size.z));
      break;
    case Shape::Kind::sphere:
      type = "sphere";
      size = text(shape.size.x);
      break;
    case Shape::Kind::ellipsoid:
      type = "ellipsoid";
      size = text(shape.size);
      break;
  }
  return add(parent, "geom",
             {{"name", name},
              {"type", type},
              {"size", size},
              {"pos", text(shape.pose.position)},
              {"quat", text(shape.pose.rotation)},
              {"rgba", shape.visible ? text(shape.color) : kInvisible},
              {"contype", touch.type},
              {"conaffinity", touch.affinity},
              {"group", group}});
}

void add_settings(pugi::xml_node model) {
  add(model, "compiler", {{"angle", "radian"}, {"autolimits", "true"}});
  // elliptic cones and a large impratio keep wheels from creeping (MuJoCo's modelling guide), and so does a tolerance
  // far below how deep rollers sink: a floor of several patches is boxes, whose contacts are found by iteration
  add(model, "option",
      {{"timestep", text(kTimestep)},
       {"integrator", "implicitfast"},
       {"cone", "elliptic"},
       {"impratio", "10"},
       {"ccd_tolerance", "1e-10"}});
  add(add(model, "visual"), "map", {{"znear", "0.001"}, {"zfar", "10"}});
  // contacts as stiff as the step allows: a softer floor swallows the corners of rollers, and 8 % of the speed with
  // them
  add(add(model, "default"), "geom",
      {{"friction", fmt::format("{} 0.005 0.0001", kBodyFriction)}, {"solref", fmt::format("{} 1", 2 * kTimestep)}});
}

void add_floor(pugi::xml_node world, const SceneBlocks& blocks, double friction) {
  for (const FloorTile& tile : blocks.floor_looks) {
    add_geom(world, tile.name, floor_box(tile), kNothing, kSeen);
  }
  for (const FloorTile& tile : blocks.floor_friction) {
    Shape ground = floor_box(tile);
    ground.visible = false;  // to rays, too: the looks above stop them
    pugi::xml_node geom = add_geom(world, tile.name, ground, kSurroundings, kFelt);
    if (blocks.floor_friction.size() == 1) {
      geom.attribute("type").set_value("plane");
      geom.attribute("size").set_value(fmt::format("0 0 {}", kFloorThickness).c_str());
      geom.attribute("pos").set_value("0 0 0");
    }
    geom.append_attribute("friction").set_value(fmt::format("{} 0.005 0.0001", text(friction * tile.friction)).c_str());
    geom.append_attribute("priority").set_value(text(kFloorPriority).c_str());
  }
}

void add_scene(pugi::xml_node world, const SceneBlocks& blocks, double friction) {
  add(world, "light",
      {{"name", "sun"}, {"pos", "0 0 10"}, {"dir", "0.3 0.2 -1"}, {"type", "directional"}, {"castshadow", "false"}});
  add_floor(world, blocks, friction);
  for (const Shape& wall : blocks.walls) add_geom(world, wall.name, wall, kSurroundings, kSeen);
  for (const Shape& shape : blocks.furniture) add_geom(world, shape.name, shape, kSurroundings, kSeen);
  for (const Shape& ceiling : blocks.ceiling) add_geom(world, ceiling.name, ceiling, kNothing, kOverhead);
  for (Shape person : blocks.people) {
    const std::string name = "person/" + person.name;
    const Vec3 place{person.pose.position.x, person.pose.position.y, 0.0};
    pugi::xml_node body = add(world, "body", {{"name", name}, {"mocap", "true"}, {"pos", text(place)}});
    person.pose.position = person.pose.position - place;
    add_geom(body, name, person, kSurroundings, kSeen);
  }
}

void add_inertia(pugi::xml_node body, const Inertia& inertia) {
  add(body, "inertial",
      {{"mass", text(inertia.mass)}, {"pos", text(inertia.center)}, {"diaginertia", text(inertia.moments)}});
}

void add_shapes(pugi::xml_node body, const Link& link, const std::string& prefix) {
  for (const Shape& shape : link.shapes) {
    const bool is_wheel = shape.kind == Shape::Kind::ellipsoid || shape.kind == Shape::Kind::cylinder;
    const Touch touch = !shape.collides ? kNothing : is_wheel ? kRobotWheel : kRobotBody;
    pugi::xml_node geom = add_geom(body, prefix + shape.name, shape, touch, kSeen);
    if (shape.kind == Shape::Kind::sphere) {  // a caster
      geom.append_attribute("priority").set_value(text(kSlidingPriority).c_str());
      geom.append_attribute("condim").set_value("1");
    }
  }
}

void add_sensor_mounts(pugi::xml_node body, const RobotDescription& robot, const std::string& prefix) {
  for (const SensorMount& mount : robot.sensors) {
    Transform pose = mount.base_from_sensor;
    if (mount.type == SensorType::camera) {
      const CameraIntrinsics view = robot.profile.camera->intrinsics();
      // MuJoCo's cameras look along their -z axis, their y axis up
      pose.rotation = pose.rotation * about_z(-exact::kPi / 2) * about_x(exact::kPi / 2);
      const double fovy = 2 * exact::atan2(0.5 * view.height, view.fy) * 180 / exact::kPi;
      add(body, "camera",
          {{"name", prefix + mount.name},
           {"pos", text(pose.position)},
           {"quat", text(pose.rotation)},
           {"fovy", text(fovy)},
           {"resolution", fmt::format("{} {}", view.width, view.height)}});
      continue;
    }
    // rangefinders look along their site's z axis
    if (mount.type == SensorType::ultrasonic) pose.rotation = pose.rotation * about_y(exact::kPi / 2);
    add(body, "site",
        {{"name", prefix + mount.name},
         {"pos", text(pose.position)},
         {"quat", text(pose.rotation)},
         {"size", "0.005"}});
  }
}

void add_joint(pugi::xml_node body, const Joint& joint, double damping, const std::string& prefix) {
  add(body, "joint", {{"name", prefix + joint.child}, {"axis", text(joint.axis)}, {"damping", text(damping)}});
}

// The links below one, each a body within its parent's.
void add_children(pugi::xml_node parent_body, const std::string& parent, const RobotDescription& robot,
                  const std::string& prefix) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    if (joint.parent != parent) continue;
    const Link& link = robot.links[i + 1];
    pugi::xml_node body = add(parent_body, "body",
                              {{"name", prefix + link.name},
                               {"pos", text(joint.parent_from_child.position)},
                               {"quat", text(joint.parent_from_child.rotation)}});
    add_joint(body, joint, joint.kind == Joint::Kind::wheel ? robot.drive.damping : kRollerDamping, prefix);
    add_inertia(body, link.inertia);
    add_shapes(body, link, prefix);
    add_children(body, link.name, robot, prefix);
  }
}

void add_robot(pugi::xml_node world, const PlacedRobot& placed) {
  const RobotDescription& robot = placed.description;
  const std::string prefix = placed.name + "/";
  const auto& [x, y, theta] = placed.scene_from_base;
  pugi::xml_node body =
      add(world, "body",
          {{"name", prefix + robot.base().name}, {"pos", text(Vec3{x, y, 0.0})}, {"quat", text(about_z(theta))}});
  add(body, "freejoint", {{"name", prefix + robot.base().name}});
  add_inertia(body, robot.base().inertia);
  add_shapes(body, robot.base(), prefix);
  add_sensor_mounts(body, robot, prefix);
  add_children(body, robot.base().name, robot, prefix);
}

// The motor's own damping is the joint's, and counts always; what the speed loop adds to it is limited to the torque at
// stall. So the sum is `gain` times the error of the speed, and falls from stall torque along the motor's line.
void add_motors(pugi::xml_node actuators, const PlacedRobot& placed) {
  const WheelDrive& drive = placed.description.drive;
  for (const Joint& joint : placed.description.joints) {
    if (joint.kind != Joint::Kind::wheel) continue;
    const std::string name = placed.name + "/" + joint.child;
    add(actuators, "general",
        {{"name", name},
         {"joint", name},
         {"gainprm", text(drive.gain)},
         {"biastype", "affine"},
         {"biasprm", fmt::format("0 0 {}", text(drive.damping - drive.gain))},
         {"forcerange", fmt::format("{} {}", text(-drive.stall_torque), text(drive.stall_torque))}});
  }
}

void add_sensors(pugi::xml_node sensors, const PlacedRobot& placed) {
  const std::string prefix = placed.name + "/";
  for (const Joint& joint : placed.description.joints) {
    if (joint.kind != Joint::Kind::wheel) continue;
    add(sensors, "jointvel", {{"name", prefix + joint.child}, {"joint", prefix + joint.child}});
  }
  for (const SensorMount& mount : placed.description.sensors) {
    const std::string site = prefix + mount.name;
    if (mount.type == SensorType::imu) {
      add(sensors, "gyro", {{"name", prefix + "gyro"}, {"site", site}});
      add(sensors, "accelerometer", {{"name", prefix + "accelerometer"}, {"site", site}});
      add(sensors, "framequat", {{"name", prefix + "orientation"}, {"objtype", "site"}, {"objname", site}});
    }
    if (mount.type == SensorType::ultrasonic) {
      const double farthest = placed.description.profile.ultrasonics->range_max;
      add(sensors, "rangefinder", {{"name", site}, {"site", site}, {"cutoff", text(farthest)}});
    }
  }
}

// What a floor without patches gives wheels: the friction that the profiles state for their wheels on a hard one.
double floor_friction(std::span<const PlacedRobot> robots) {
  constexpr double kRubberOnConcrete = 0.8;
  return robots.empty() ? kRubberOnConcrete : robots.front().description.profile.body.friction;
}

}  // namespace

std::string mjcf(const scene::Scene& scene, std::span<const PlacedRobot> robots) {
  pugi::xml_document document;
  pugi::xml_node model = add(document, "mujoco", {{"model", scene.name}});
  add_settings(model);
  pugi::xml_node world = add(model, "worldbody");
  add_scene(world, blocks_of(scene), floor_friction(robots));
  for (const PlacedRobot& robot : robots) add_robot(world, robot);
  pugi::xml_node actuators = add(model, "actuator");
  for (const PlacedRobot& robot : robots) add_motors(actuators, robot);
  pugi::xml_node sensors = add(model, "sensor");
  for (const PlacedRobot& robot : robots) add_sensors(sensors, robot);
  return to_string(document);
}

}  // namespace threewe::exports
