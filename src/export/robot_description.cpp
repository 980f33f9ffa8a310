#include "export/robot_description.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::exports {
namespace {

constexpr Color kShell{0.91, 0.48, 0.17};
constexpr Color kKeel{0.13, 0.14, 0.16};
constexpr Color kHub{0.45, 0.46, 0.48};
constexpr Color kRubber{0.16, 0.16, 0.17};
constexpr double kKeelGap = 0.01;  // [m] between the keel and the wheels, both sides together

// The ellipsoid of a mecanum wheel's roller. At 45 degrees to the axle it is as long as the wheel is wide. Of all
// ellipsoids on the ring of their middles, the one with half_length^2 = radius^2 + 2 radius ring is round along the
// wheel's rim to the third order.
struct Roller {
  double half_length = 0.0;  // [m] along its axle
  double radius = 0.0;       // [m]
  double ring = 0.0;         // [m] from the wheel's axle to its own
};

Roller roller_of(const WheelGeometry& wheels) {
  const double half_length = wheels.width / std::numbers::sqrt2;
  const double ring = exact::sqrt(wheels.radius * wheels.radius - half_length * half_length);
  return {half_length, wheels.radius - ring, ring};
}

struct WheelPlace {
  const char* name;
  Vec2 position;
};

std::vector<WheelPlace> wheel_places(const WheelGeometry& wheels) {
  const double x = wheels.half_length;
  const double y = wheels.half_width;
  if (wheels.kinematics == Kinematics::differential) return {{"left_wheel", {0, y}}, {"right_wheel", {0, -y}}};
  return {{"front_left_wheel", {x, y}},
          {"front_right_wheel", {x, -y}},
          {"rear_left_wheel", {-x, y}},
          {"rear_right_wheel", {-x, -y}}};
}

// Half of a mecanum wheel's mass is in its rollers.
constexpr double kRollerShare = 0.5;

Vec3 moments_of_cylinder_along_y(double mass, double radius, double length) {
  const double across = mass / 12 * (3 * radius * radius + length * length);
  return {across, mass / 2 * radius * radius, across};
}

// What is seen of a wheel.
Shape disc(const std::string& name, double radius, double width, const Color& color) {
  const Transform across{{}, about_x(-exact::kPi / 2)};
  return {name, Shape::Kind::cylinder, across, {radius, radius, width}, color, true, false};
}

// What is felt of a wheel: its tread is round, so that it touches the floor in one point and turns on it without
// scrubbing over its edges.
Shape tyre(const WheelGeometry& wheels, const std::string& name) {
  const Vec3 semi_axes{wheels.radius, 0.5 * wheels.width, wheels.radius};
  return {name + "_tyre", Shape::Kind::ellipsoid, {}, semi_axes, kRubber, false, true};
}

Link wheel_link(const WheelGeometry& wheels, const std::string& name) {
  const bool mecanum = wheels.kinematics == Kinematics::holonomic;
  const double mass = mecanum ? (1 - kRollerShare) * wheels.mass : wheels.mass;
  const double radius = mecanum ? roller_of(wheels).ring : wheels.radius;
  const double width = mecanum ? 0.5 * wheels.width : wheels.width;
  Link link{name, {mass, {}, moments_of_cylinder_along_y(mass, radius, wheels.width)}, {}};
  link.shapes.push_back(disc(name, radius, width, mecanum ? kHub : kRubber));
  if (!mecanum) link.shapes.push_back(tyre(wheels, name));
  return link;
}

Link roller_link(const WheelGeometry& wheels, const std::string& name) {
  const Roller roller = roller_of(wheels);
  const double mass = kRollerShare * wheels.mass / wheels.rollers;
  const double a2 = roller.half_length * roller.half_length;
  const double b2 = roller.radius * roller.radius;
  const Shape shape{name, Shape::Kind::ellipsoid, {}, {roller.half_length, roller.radius, roller.radius}, kRubber};
  return {name, {mass, {}, {mass / 5 * 2 * b2, mass / 5 * (a2 + b2), mass / 5 * (a2 + b2)}}, {shape}};
}

// The rollers of a wheel in turn, the first one lowest; x is along their axle.
Joint roller_joint(const WheelGeometry& wheels, std::size_t wheel, const std::string& parent, int number) {
  const Quaternion turn = about_y(2 * exact::kPi * number / wheels.rollers);
  const Vec3 friction = friction_direction(wheel);
  const Quaternion along = about_z(exact::atan2(friction.y, friction.x));
  const std::string name = fmt::format("{}_roller_{}", parent, number);
  const Vec3 place = rotated(turn, {0.0, 0.0, -roller_of(wheels).ring});
  return {name + "_joint", Joint::Kind::roller, parent, name, {place, turn * along}, {1.0, 0.0, 0.0}};
}

void add_wheels(RobotDescription& robot) {
  const WheelGeometry& wheels = robot.profile.body.wheels;
  std::vector<Link> rollers;
  std::vector<Joint> roller_joints;
  for (const auto& [name, place] : wheel_places(wheels)) {
    const std::size_t wheel = robot.joints.size();
    robot.links.push_back(wheel_link(wheels, name));
    robot.joints.push_back({fmt::format("{}_joint", name),
                            Joint::Kind::wheel,
                            robot.base().name,
                            name,
                            {{place.x, place.y, wheels.radius}, {}},
                            {0.0, 1.0, 0.0}});
    for (int i = 0; i < wheels.rollers; ++i) {
      roller_joints.push_back(roller_joint(wheels, wheel, name, i));
      rollers.push_back(roller_link(wheels, roller_joints.back().child));
    }
  }
  robot.links.insert(robot.links.end(), rollers.begin(), rollers.end());
  robot.joints.insert(robot.joints.end(), roller_joints.begin(), roller_joints.end());
}

// The rectangle around the footprint.
std::pair<Vec2, Vec2> extent(const Footprint& footprint) {
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  for (const Vec2 corner : footprint.corners()) {
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
  }
  return {low, high};
}

// A shell that fills the footprint's rectangle above the wheels, a keel between them, and casters.
Link base_link(const Body& body) {
  const auto [low, high] = extent(body.footprint);
  const Vec2 middle = 0.5 * (low + high);
  const Vec2 size = high - low;
  const double deck = std::min(2 * body.wheels.radius, 0.6 * body.height);
  const double bottom = 0.4 * body.wheels.radius;
  Link link{.name = "base_link", .inertia = {}, .shapes = {}};
  const auto add_box = [&](const char* name, double length, double width, double from, double to, Color color) {
    const Transform pose{{middle.x, middle.y, 0.5 * (from + to)}, {}};
    link.shapes.push_back({name, Shape::Kind::box, pose, {length, width, to - from}, color});
  };
  add_box("shell", size.x, size.y, deck, body.height, kShell);
  const double between = 2 * body.wheels.half_width - body.wheels.width - kKeelGap;
  if (between > 0 && deck > bottom) add_box("keel", 0.94 * size.x, between, bottom, deck, kKeel);
  for (std::size_t i = 0; i < body.casters.size(); ++i) {
    const auto& [at, r] = body.casters[i];
    link.shapes.push_back(
        {fmt::format("caster_{}", i), Shape::Kind::sphere, {{at.x, at.y, r}, {}}, {r, r, r}, kRubber});
  }
  return link;
}

Vec3 squares_off_axes(const Vec3& v) { return {v.y * v.y + v.z * v.z, v.x * v.x + v.z * v.z, v.x * v.x + v.y * v.y}; }

// Principal moments as seen in a frame that is turned: the diagonal of the tensor there.
Vec3 turned_moments(const Quaternion& rotation, const Vec3& moments) {
  const Vec3 x = rotated(rotation, {1, 0, 0});
  const Vec3 y = rotated(rotation, {0, 1, 0});
  const Vec3 z = rotated(rotation, {0, 0, 1});
  return {x.x * x.x * moments.x + y.x * y.x * moments.y + z.x * z.x * moments.z,
          x.y * x.y * moments.x + y.y * y.y * moments.y + z.y * z.y * moments.z,
          x.z * x.z * moments.x + y.z * y.z * moments.y + z.z * z.z * moments.z};
}

struct PlacedInertia {
  Transform pose;
  Inertia inertia;
};

// What parts amount to together. Products of inertia are left out: there are none where parts are placed evenly about
// the axes, as wheels on a robot and rollers on a wheel are.
Inertia combined(const std::vector<PlacedInertia>& parts) {
  Inertia sum;
  for (const auto& [pose, part] : parts) {
    sum.mass += part.mass;
    sum.center = sum.center + part.mass * (pose * part.center);
  }
  sum.center = (1 / sum.mass) * sum.center;
  for (const auto& [pose, part] : parts) {
    const Vec3 offset = pose * part.center - sum.center;
    sum.moments = sum.moments + turned_moments(pose.rotation, part.moments) + part.mass * squares_off_axes(offset);
  }
  return sum;
}

// Where every link is while all joints stand at zero.
std::vector<PlacedInertia> placed(const RobotDescription& robot) {
  std::vector<PlacedInertia> parts = {{{}, robot.base().inertia}};
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const auto parent = std::ranges::find(robot.links, joint.parent, &Link::name) - robot.links.begin();
    parts.push_back(
        {parts[static_cast<std::size_t>(parent)].pose * joint.parent_from_child, robot.links[i + 1].inertia});
  }
  return parts;
}

// What the wheels leave of the profile's mass and inertia, spread as in a box. The profile states its inertia about
// the base; on a differential base, which stands on its casters too, the mass is in the middle of the footprint.
Inertia base_inertia(const RobotDescription& robot) {
  const Body& body = robot.profile.body;
  std::vector<PlacedInertia> wheels = placed(robot);
  wheels.erase(wheels.begin());
  const auto [low, high] = extent(body.footprint);
  const double bottom = 0.4 * body.wheels.radius;
  Inertia base{body.mass, {0.0, 0.0, 0.5 * (bottom + body.height)}, {}};
  if (!body.casters.empty()) base.center.x = 0.5 * (low.x + high.x);
  base.moments.z = body.inertia;
  for (const auto& [pose, inertia] : wheels) {
    base.mass -= inertia.mass;
    base.moments.z -=
        turned_moments(pose.rotation, inertia.moments).z + inertia.mass * squares_off_axes(pose.position).z;
  }
  base.moments.z -= base.mass * base.center.x * base.center.x;
  if (base.moments.z <= 0.0) {
    throw ConfigError(fmt::format("{}: body.inertia: {} kg m^2 is less than the wheels alone have where they are",
                                  robot.profile.name, body.inertia));
  }

  const double height = body.height - bottom;
  base.moments.x = base.mass / 12 * ((high.y - low.y) * (high.y - low.y) + height * height);
  base.moments.y = base.mass / 12 * ((high.x - low.x) * (high.x - low.x) + height * height);
  // no body has a moment larger than the two others together
  const double enough = std::max(1.0, base.moments.z / (base.moments.x + base.moments.y));
  base.moments.x = std::min(enough * base.moments.x, enough * base.moments.y + base.moments.z);
  base.moments.y = std::min(enough * base.moments.y, base.moments.x + base.moments.z);
  return base;
}

WheelDrive wheel_drive(const RobotDescription& robot) {
  const Body& body = robot.profile.body;
  const double spin = without_rollers(robot).links[1].inertia.moments.y;
  const double share = body.mass * body.wheels.radius * body.wheels.radius / body.wheels.wheel_count();
  return {(spin + share) / to_seconds(body.motor_lag), body.stall_torque, body.stall_torque / body.no_load_speed};
}

std::vector<SensorMount> mounts_of(const RobotProfile& profile) {
  const auto at = [](const Pose2D& pose, double height) {
    return Transform{{pose.x, pose.y, height}, about_z(pose.theta)};
  };
  std::vector<SensorMount> mounts;
  if (const auto& lidar = profile.lidar) {
    mounts.push_back({SensorType::lidar, "lidar", at(lidar->base_from_lidar, lidar->height)});
  }
  if (profile.imu) mounts.push_back({SensorType::imu, "imu", at({}, 0.5 * profile.body.height)});
  if (const auto& camera = profile.camera) {
    mounts.push_back({SensorType::camera, "camera", at(camera->base_from_camera, camera->mount_height)});
  }
  if (const auto& ultrasonics = profile.ultrasonics) {
    for (const auto& [name, pose] : ultrasonics->mounts) {
      mounts.push_back({SensorType::ultrasonic, name, at(pose, ultrasonics->height)});
    }
  }
  return mounts;
}

}  // namespace

RobotDescription describe(const RobotProfile& profile) {
  RobotDescription robot{.profile = profile, .links = {}, .joints = {}, .sensors = {}, .drive = {}};
  robot.links.push_back(base_link(profile.body));
  add_wheels(robot);
  robot.links.front().inertia = base_inertia(robot);
  robot.drive = wheel_drive(robot);
  robot.sensors = mounts_of(profile);
  return robot;
}

RobotDescription without_rollers(RobotDescription robot) {
  const WheelGeometry& wheels = robot.profile.body.wheels;
  if (wheels.rollers == 0) return robot;
  const auto count = static_cast<std::size_t>(wheels.wheel_count());
  for (std::size_t wheel = 1; wheel <= count; ++wheel) {
    Link& link = robot.links[wheel];
    std::vector<PlacedInertia> parts = {{{}, link.inertia}};
    for (std::size_t i = count; i < robot.joints.size(); ++i) {
      const Joint& joint = robot.joints[i];
      if (joint.parent == link.name) parts.push_back({joint.parent_from_child, robot.links[i + 1].inertia});
    }
    link.inertia = combined(parts);
    link.shapes = {disc(link.name, wheels.radius, wheels.width, kRubber), tyre(wheels, link.name)};
  }
  robot.links.resize(1 + count);
  robot.joints.resize(count);
  return robot;
}

Vec3 friction_direction(std::size_t wheel) {
  const double diagonal = 1 / std::numbers::sqrt2;
  const bool front_left_or_rear_right = wheel == 0 || wheel == 3;
  return {diagonal, front_left_or_rear_right ? -diagonal : diagonal, 0.0};
}

Inertia total_inertia(const RobotDescription& robot) { return combined(placed(robot)); }

}  // namespace threewe::exports
