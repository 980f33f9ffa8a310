// A USD stage with physics (UsdPhysics), for Isaac Sim and others. Not run in Isaac Sim yet.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "sdf_sensors.hpp"
#include "usd_text.hpp"
#include "writers.hpp"

namespace threewe::exports {
namespace {

constexpr double kGravity = 9.80665;   // [m/s^2]
constexpr double kBodyFriction = 0.3;  // plastic against walls and furniture (estimate)
constexpr const char* kRobot = "/World/Robot";

void add_friction(UsdText& usd, const std::string& name, double friction, bool multiplies) {
  usd.open("Material", name, {"PhysicsMaterialAPI", "PhysxMaterialAPI"});
  usd.line("float physics:staticFriction = {}", text(friction));
  usd.line("float physics:dynamicFriction = {}", text(friction));
  usd.line("float physics:restitution = 0");
  if (multiplies) usd.line("uniform token physxMaterial:frictionCombineMode = \"multiply\"");
  usd.close();
}

// A shape; `friction` is the path of a material, empty where nothing touches it.
void add_shape(UsdText& usd, const std::string& name, const Shape& shape, const std::string& friction) {
  std::vector<const char*> schemas;
  if (!friction.empty()) schemas = {"PhysicsCollisionAPI", "MaterialBindingAPI"};
  switch (shape.kind) {
    case Shape::Kind::box:
      usd.open("Cube", name, schemas);
      usd.line("double size = 1");
      usd.line("float3[] extent = [(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)]");
      usd.place(shape.pose, &shape.size);
      break;
    case Shape::Kind::cylinder:
      usd.open("Cylinder", name, schemas);
      usd.line("uniform token axis = \"Z\"");
      usd.line("double radius = {}", text(shape.size.x));
      usd.line("double height = {}", text(shape.size.z));
      usd.extent({shape.size.x, shape.size.y, 0.5 * shape.size.z});
      usd.place(shape.pose);
      break;
    case Shape::Kind::sphere:
      usd.open("Sphere", name, schemas);
      usd.line("double radius = {}", text(shape.size.x));
      usd.extent(shape.size);
      usd.place(shape.pose);
      break;
    case Shape::Kind::ellipsoid:  // USD scales no spheres unevenly where they collide
      schemas.push_back("PhysicsMeshCollisionAPI");
      usd.open("Mesh", name, schemas);
      usd.line("uniform token physics:approximation = \"convexHull\"");
      usd.ellipsoid_mesh(shape.size);
      usd.place(shape.pose);
      break;
  }
  usd.line("color3f[] primvars:displayColor = [{}]",
           usd_tuple(Vec3{shape.color.red, shape.color.green, shape.color.blue}));
  if (!shape.visible) usd.line("token visibility = \"invisible\"");
  if (!friction.empty()) usd.line("rel material:binding:physics = <{}>", friction);
  usd.close();
}

std::string floor_material(const FloorTile& tile) { return "/World/Materials/" + tile.name; }

// What is felt and what is seen of floors are prims of their own: the first are invisible.
void add_floor(UsdText& usd, const SceneBlocks& blocks) {
  usd.open("Xform", "floor");
  for (const FloorTile& tile : blocks.floor_looks) add_shape(usd, tile.name, floor_box(tile), "");
  usd.close();
  usd.open("Xform", "ground");
  usd.line("token visibility = \"invisible\"");
  for (const FloorTile& tile : blocks.floor_friction) add_shape(usd, tile.name, floor_box(tile), floor_material(tile));
  usd.close();
}

void add_group(UsdText& usd, const char* name, const std::vector<Shape>& shapes, const std::string& friction) {
  UsdNames names;
  usd.open("Xform", name);
  for (const Shape& shape : shapes) add_shape(usd, names.of(shape.name), shape, friction);
  usd.close();
}

void add_people(UsdText& usd, const std::vector<Shape>& people) {
  UsdNames names;
  usd.open("Xform", "people");
  for (Shape person : people) {
    usd.open("Xform", names.of(person.name), {"PhysicsRigidBodyAPI"});
    usd.line("bool physics:kinematicEnabled = 1");
    usd.place({{person.pose.position.x, person.pose.position.y, 0.0}, {}});
    person.pose.position = {0.0, 0.0, person.pose.position.z};
    add_shape(usd, "body", person, "/World/Materials/body");
    usd.close();
  }
  usd.close();
}

void add_scene(UsdText& usd, const SceneBlocks& blocks) {
  usd.open("Xform", "Scene");
  add_floor(usd, blocks);
  add_group(usd, "walls", blocks.walls, "/World/Materials/body");
  add_group(usd, "furniture", blocks.furniture, "/World/Materials/body");
  if (!blocks.ceiling.empty()) add_group(usd, "ceiling", blocks.ceiling, "");
  if (!blocks.people.empty()) add_people(usd, blocks.people);
  usd.close();
}

// Wheels' friction times the floor's grip is what holds them, in simulators that combine frictions as PhysX does.
void add_materials(UsdText& usd, const SceneBlocks& blocks, const Body& body) {
  usd.open("Scope", "Materials");
  for (const FloorTile& tile : blocks.floor_friction) add_friction(usd, tile.name, tile.friction, true);
  add_friction(usd, "wheel", body.friction, true);
  add_friction(usd, "body", kBodyFriction, false);
  if (!body.casters.empty()) add_friction(usd, "caster", 0.0, true);
  usd.close();
}

void add_camera(UsdText& usd, const SensorMount& mount, const CameraSpec& camera) {
  constexpr double kAperture = 20.955;  // [mm], USD's own; only its ratio to the focal length counts
  const CameraIntrinsics view = camera.intrinsics();
  usd.open("Camera", mount.name);
  usd.line("float horizontalAperture = {}", text(kAperture));
  usd.line("float verticalAperture = {}", text(kAperture * view.height / view.width));
  usd.line("float focalLength = {}", text(kAperture * view.fx / view.width));
  usd.line("float2 clippingRange = ({}, {})", text(camera.depth ? camera.depth->range_min : kCameraNear),
           text(camera.depth ? camera.depth->range_max : kCameraFar));
  // it looks along -z, its y axis up
  Transform pose = mount.base_from_sensor;
  pose.rotation = pose.rotation * about_z(-exact::kPi / 2) * about_x(exact::kPi / 2);
  usd.place(pose);
  usd.close();
}

// USD itself knows no lidar: frames with what it takes to make a sensor of one's simulator there.
void add_sensor_frame(UsdText& usd, const SensorMount& mount, const RobotProfile& profile) {
  usd.open("Xform", mount.name);
  usd.line("custom string threewe:sensor = \"{}\"", to_string(mount.type));
  if (mount.type == SensorType::lidar) {
    const Lidar lidar = lidar_of(*profile.lidar);
    usd.line("custom int threewe:beams = {}", lidar.samples);
    usd.line("custom double2 threewe:angles = ({}, {})", text(lidar.min_angle), text(lidar.max_angle));
    usd.line("custom double2 threewe:range = ({}, {})", text(profile.lidar->range_min), text(profile.lidar->range_max));
    usd.line("custom double threewe:period = {}", text(to_seconds(profile.lidar->turn)));
  } else if (mount.type == SensorType::imu) {
    usd.line("custom double threewe:period = {}", text(to_seconds(profile.imu->period)));
  } else {
    const UltrasonicSpec& sound = *profile.ultrasonics;
    usd.line("custom double threewe:field_of_view = {}", text(sound.field_of_view));
    usd.line("custom double2 threewe:range = ({}, {})", text(sound.range_min), text(sound.range_max));
    usd.line("custom double threewe:period = {}", text(to_seconds(sound.period())));
  }
  usd.place(mount.base_from_sensor);
  usd.close();
}

const char* material_of(const Shape& shape) {
  if (!shape.collides) return "";
  switch (shape.kind) {
    case Shape::Kind::box: return "/World/Materials/body";
    case Shape::Kind::sphere: return "/World/Materials/caster";
    default: return "/World/Materials/wheel";
  }
}

void open_link(UsdText& usd, const Link& link, const Transform& pose) {
  usd.open("Xform", link.name, {"PhysicsRigidBodyAPI", "PhysicsMassAPI"});
  usd.line("float physics:mass = {}", text(link.inertia.mass));
  usd.line("point3f physics:centerOfMass = {}", usd_tuple(link.inertia.center));
  usd.line("float3 physics:diagonalInertia = {}", usd_tuple(link.inertia.moments));
  usd.line("quatf physics:principalAxes = (1, 0, 0, 0)");
  usd.place(pose);
  for (const Shape& shape : link.shapes) add_shape(usd, shape.name + "_shape", shape, material_of(shape));
}

void add_joint(UsdText& usd, const Joint& joint, const WheelDrive& drive) {
  const bool driven = joint.kind == Joint::Kind::wheel;
  usd.open("PhysicsRevoluteJoint", joint.name,
           driven ? std::vector<const char*>{"PhysicsDriveAPI:angular"} : std::vector<const char*>{});
  usd.line("rel physics:body0 = <{}/{}>", kRobot, joint.parent);
  usd.line("rel physics:body1 = <{}/{}>", kRobot, joint.child);
  usd.line("point3f physics:localPos0 = {}", usd_tuple(joint.parent_from_child.position));
  usd.line("quatf physics:localRot0 = {}", usd_tuple(joint.parent_from_child.rotation));
  usd.line("point3f physics:localPos1 = (0, 0, 0)");
  usd.line("quatf physics:localRot1 = (1, 0, 0, 0)");
  usd.line("uniform token physics:axis = \"{}\"", joint.axis.x != 0.0 ? "X" : "Y");
  if (driven) {  // UsdPhysics turns in degrees
    usd.line("uniform token drive:angular:physics:type = \"force\"");
    usd.line("float drive:angular:physics:damping = {}", text(drive.gain * exact::kPi / 180));
    usd.line("float drive:angular:physics:stiffness = 0");
    usd.line("float drive:angular:physics:maxForce = {}", text(drive.stall_torque));
    usd.line("float drive:angular:physics:targetVelocity = 0");
  }
  usd.close();
}

void add_robot(UsdText& usd, const RobotDescription& robot) {
  usd.open("Xform", "Robot", {"PhysicsArticulationRootAPI"});
  usd.line("custom string threewe:profile = \"{}\"", robot.profile.name);
  open_link(usd, robot.base(), {});
  for (const SensorMount& mount : robot.sensors) {
    if (mount.type == SensorType::camera) {
      add_camera(usd, mount, *robot.profile.camera);
    } else {
      add_sensor_frame(usd, mount, robot.profile);
    }
  }
  usd.close();
  std::vector<Transform> poses = {{}};  // all links are side by side: nested bodies would not be free
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const auto parent = std::ranges::find(robot.links, robot.joints[i].parent, &Link::name) - robot.links.begin();
    poses.push_back(poses[static_cast<std::size_t>(parent)] * robot.joints[i].parent_from_child);
    open_link(usd, robot.links[i + 1], poses.back());
    usd.close();
  }
  for (const Joint& joint : robot.joints) add_joint(usd, joint, robot.drive);
  usd.close();
}

// No part of the robot touches another.
void add_filter(UsdText& usd) {
  usd.open("PhysicsCollisionGroup", "RobotParts", {"CollectionAPI:colliders"});
  usd.line("rel collection:colliders:includes = <{}>", kRobot);
  usd.line("rel physics:filteredGroups = </World/RobotParts>");
  usd.close();
}

}  // namespace

std::vector<File> usd_files(const scene::Scene& scene, const RobotDescription& robot) {
  const SceneBlocks blocks = blocks_of(scene);
  UsdText usd;
  usd.open("Xform", "World");
  usd.open("PhysicsScene", "PhysicsScene");
  usd.line("vector3f physics:gravityDirection = (0, 0, -1)");
  usd.line("float physics:gravityMagnitude = {}", text(kGravity));
  usd.close();
  usd.open("DistantLight", "Sun");
  usd.line("float inputs:intensity = 1000");
  usd.close();
  add_materials(usd, blocks, robot.profile.body);
  add_scene(usd, blocks);
  add_robot(usd, robot);
  add_filter(usd);
  usd.close();
  return {{"stage.usda", usd.finish()}};
}

}  // namespace threewe::exports
