#include "threewe/hardware/profile.hpp"

#include <utility>

#include <fmt/format.h>

#include "core/config.hpp"
#include "core/names.hpp"
#include "hardware/link.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

constexpr double kGravity = 9.80665;  // [m/s^2]

// Bounds that no robot of this kind leaves: they catch wrong units, such as millimetres or degrees.
constexpr double kMaxLength = 5.0;          // [m]
constexpr double kMaxMass = 1000.0;         // [kg]
constexpr double kMaxSpeed = 20.0;          // [m/s] and [rad/s]
constexpr double kMaxAcceleration = 200.0;  // [m/s^2] and [rad/s^2]
constexpr double kSmall = 1e-6;             // stands for "more than zero"
constexpr double kMaxParameter = 1e6;       // of the autonomy stack, in any unit
constexpr double kAnyIncidence = 1.57;      // [rad], all but grazing

Duration duration_in(ConfigNode& node, std::string_view field, double low, double high) {
  return from_seconds(node.number_in(field, low, high));
}

Footprint read_footprint(ConfigNode node) {
  try {
    if (node.has("corners")) {
      std::vector<Vec2> corners;
      for (const ConfigNode& corner : node.at("corners").items()) corners.push_back(corner.vec2(kMaxLength));
      node.finish();
      return Footprint(std::move(corners));
    }
    const double length = node.number_in("length", kSmall, kMaxLength);
    const double width = node.number_in("width", kSmall, kMaxLength);
    node.finish();
    return Footprint::rectangle(length, width);
  } catch (const ConfigError& error) {
    // what the footprint itself refuses does not know its file yet
    if (std::string_view(error.what()).starts_with("footprint")) node.fail(error.what());
    throw;
  }
}

WheelGeometry read_wheels(ConfigNode node) {
  WheelGeometry wheels;
  const bool holonomic = node.choice("kinematics", {"holonomic", "differential"}) == "holonomic";
  wheels.kinematics = holonomic ? Kinematics::holonomic : Kinematics::differential;
  wheels.radius = node.number_in("radius", 0.001, 1.0);
  wheels.half_length =
      holonomic ? node.number_in("half_length", 0.001, kMaxLength) : node.number_in("half_length", 0.0, 0.0);
  wheels.half_width = node.number_in("half_width", 0.001, kMaxLength);
  wheels.width = node.number_in("width", 0.001, 1.0);
  wheels.mass = node.number_in("mass", 0.0001, kMaxMass);
  if (holonomic) wheels.rollers = node.integer_in("rollers", 4, 64);
  node.finish();
  if (holonomic && wheels.width >= wheels.radius)
    node.at("width").fail("must be less than the radius of a mecanum wheel");
  return wheels;
}

std::vector<Caster> read_casters(const ConfigNode& node) {
  constexpr std::size_t kMostCasters = 8;
  std::vector<Caster> casters;
  for (ConfigNode item : node.items(kMostCasters)) {
    Caster& caster = casters.emplace_back();
    caster.position = item.at("position").vec2(kMaxLength);
    caster.radius = item.number_in("radius", 0.001, 1.0);
    item.finish();
  }
  if (casters.empty()) node.fail("two wheels alone do not stand: expected a list of {position: [x, y], radius}");
  return casters;
}

// The wheels must not weigh more than the robot, nor make it harder to turn.
void check_wheels(const Body& body, ConfigNode node) {
  const WheelGeometry& wheels = body.wheels;
  const double mass = wheels.wheel_count() * wheels.mass;
  if (mass >= body.mass) {
    node.at("mass").fail(fmt::format("{} wheels of {} kg leave nothing of the robot's {} kg", wheels.wheel_count(),
                                     wheels.mass, body.mass));
  }
  const double inertia = mass * (wheels.half_length * wheels.half_length + wheels.half_width * wheels.half_width);
  if (inertia >= body.inertia) {
    node.at("mass").fail(
        fmt::format("the wheels alone have {:.5f} of the robot's {} kg m^2 of inertia", inertia, body.inertia));
  }
}

TractionSpec read_traction(ConfigNode node, Kinematics kinematics) {
  TractionSpec traction;
  traction.ahead = node.number_in("ahead", 0.5, 1.5);
  traction.turning = node.number_in("turning", 0.5, 1.5);
  traction.turning_lag = duration_in(node, "turning_lag", 0.0001, 1.0);
  traction.load = node.number_in("load", 0.1, 1.0);
  traction.mass_height = node.number_in("mass_height", 0.0, kMaxLength);
  if (kinematics == Kinematics::holonomic) {
    traction.sideways = node.number_in("sideways", 0.5, 1.5);
    traction.shift = node.number_in("shift", 0.0, 1.0);
    traction.shift_speed = node.number_in("shift_speed", 0.001, kMaxSpeed);
  }
  node.finish();
  return traction;
}

Body read_body(ConfigNode node) {
  Body body;
  body.footprint = read_footprint(node.at("footprint"));
  body.height = node.number_in("height", 0.01, kMaxLength);
  body.mass = node.number_in("mass", 0.01, kMaxMass);
  body.inertia = node.number_in("inertia", kSmall, kMaxMass);
  body.wheels = read_wheels(node.at("wheels"));
  check_wheels(body, node.at("wheels"));
  if (body.wheels.kinematics == Kinematics::differential) body.casters = read_casters(node.at("casters"));
  body.friction = node.number_in("friction", 0.01, 5.0);
  body.rolling_resistance = node.number_in("rolling_resistance", 0.0, 1.0);
  body.stall_torque = node.number_in("stall_torque", 0.001, 1000.0);
  body.no_load_speed = node.number_in("no_load_speed", 0.1, 1000.0);
  body.motor_lag = duration_in(node, "motor_lag", 0.001, 1.0);
  if (node.has("traction")) body.traction = read_traction(node.at("traction"), body.wheels.kinematics);
  node.finish();
  return body;
}

Limits read_limits(ConfigNode node) {
  Limits limits;
  limits.linear = node.number_in("linear", 0.01, kMaxSpeed);
  limits.angular = node.number_in("angular", 0.01, kMaxSpeed);
  limits.linear_acceleration = node.number_in("linear_acceleration", 0.01, kMaxAcceleration);
  limits.linear_braking = node.number_in("linear_braking", 0.01, kMaxAcceleration);
  limits.angular_acceleration = node.number_in("angular_acceleration", 0.01, kMaxAcceleration);
  node.finish();
  return limits;
}

LidarSpec read_lidar(ConfigNode node) {
  LidarSpec lidar;
  lidar.base_from_lidar = node.at("base_from_lidar").pose(kMaxLength);
  lidar.height = node.number_in("height", 0.0, kMaxLength);
  lidar.points_per_turn = node.integer_in("points_per_turn", 4, 100'000);
  lidar.clockwise = node.at("clockwise").boolean();
  lidar.beams = node.integer_in("beams", 4, 100'000);
  lidar.turn = duration_in(node, "turn", 0.001, 10.0);
  lidar.range_min = node.number_in("range_min", 0.0, 1000.0);
  lidar.range_max = node.number_in("range_max", 0.1, 1000.0);
  lidar.sigma = node.number_in("sigma", 0.0, 1.0);
  lidar.bias = node.number_in("bias", 0.0, 1.0);
  lidar.dropout = node.number_in("dropout", 0.0, 1.0);
  lidar.latency = duration_in(node, "latency", 0.0, 1.0);
  node.finish();
  if (lidar.beams > lidar.points_per_turn) {
    node.at("beams").fail(
        fmt::format("{} beams cannot be made of {} points a turn", lidar.beams, lidar.points_per_turn));
  }
  if (lidar.range_min >= lidar.range_max) node.at("range_min").fail("must be below range_max");
  return lidar;
}

IMUSpec read_imu(ConfigNode node) {
  IMUSpec imu;
  imu.period = duration_in(node, "period", 0.001, 1.0);
  imu.gyro_sigma = node.number_in("gyro_sigma", 0.0, 1.0);
  imu.gyro_bias = node.number_in("gyro_bias", 0.0, 1.0);
  imu.gyro_bias_walk = node.number_in("gyro_bias_walk", 0.0, 1.0);
  imu.accelerometer_sigma = node.number_in("accelerometer_sigma", 0.0, 10.0);
  imu.accelerometer_bias = node.number_in("accelerometer_bias", 0.0, 10.0);
  imu.latency = duration_in(node, "latency", 0.0, 1.0);
  node.finish();
  return imu;
}

DepthSpec read_depth(ConfigNode node) {
  DepthSpec depth;
  depth.range_min = node.number_in("range_min", 0.0, 100.0);
  depth.range_max = node.number_in("range_max", 0.1, 1000.0);
  depth.sigma = node.number_in("sigma", 0.0, 1.0);
  node.finish();
  if (depth.range_min >= depth.range_max) node.at("range_min").fail("must be below range_max");
  return depth;
}

CameraSpec read_camera(ConfigNode node) {
  constexpr int kMaxPixels = 8192;  // along either side
  CameraSpec camera;
  camera.base_from_camera = node.at("base_from_camera").pose(kMaxLength);
  camera.mount_height = node.number_in("mount_height", 0.001, kMaxLength);
  camera.width = node.integer_in("width", 1, kMaxPixels);
  camera.height = node.integer_in("height", 1, kMaxPixels);
  camera.horizontal_fov = node.number_in("horizontal_fov", 0.01, 3.0);
  camera.period = duration_in(node, "period", 0.001, 10.0);
  camera.sigma = node.number_in("sigma", 0.0, 255.0);
  camera.latency = duration_in(node, "latency", 0.0, 1.0);
  if (node.has("depth")) camera.depth = read_depth(node.at("depth"));
  node.finish();
  return camera;
}

UltrasonicSpec read_ultrasonics(ConfigNode node) {
  constexpr std::size_t kMaxMounts = 16;
  UltrasonicSpec ultrasonic;
  const ConfigNode mounts = node.at("mounts");
  for (const auto& [name, mount] : mounts.fields()) {
    ultrasonic.mounts.push_back({"ultrasonic_" + name, mount.pose(kMaxLength)});
  }
  if (ultrasonic.mounts.empty() || ultrasonic.mounts.size() > kMaxMounts) {
    mounts.fail(fmt::format("expected 1 to {} sensors, each a name and its pose [x, y, theta]", kMaxMounts));
  }
  ultrasonic.height = node.number_in("height", 0.0, kMaxLength);
  ultrasonic.interval = duration_in(node, "interval", 0.001, 10.0);
  ultrasonic.field_of_view = node.number_in("field_of_view", 0.001, 3.0);
  ultrasonic.max_incidence = node.number_in("max_incidence", 0.001, kAnyIncidence);
  ultrasonic.range_min = node.number_in("range_min", 0.0, 100.0);
  ultrasonic.range_max = node.number_in("range_max", 0.1, 100.0);
  ultrasonic.sigma = node.number_in("sigma", 0.0, 1.0);
  ultrasonic.latency = duration_in(node, "latency", 0.0, 1.0);
  node.finish();
  if (ultrasonic.range_min >= ultrasonic.range_max) node.at("range_min").fail("must be below range_max");
  return ultrasonic;
}

OdometrySpec read_odometry(ConfigNode node) {
  OdometrySpec odometry;
  odometry.period = duration_in(node, "period", 0.001, 1.0);
  odometry.wheel_scale = node.number_in("wheel_scale", 0.0, 0.5);
  const ConfigNode scale = node.at("lateral_scale");
  const Vec2 range = scale.vec2();
  const bool ordered = range.x > 0.0 && range.x <= range.y && range.y <= 1.0;
  if (!ordered) scale.fail("expected [low, high] within (0, 1]");
  odometry.lateral_scale_min = range.x;
  odometry.lateral_scale_max = range.y;
  odometry.ticks_per_turn = node.integer_in("ticks_per_turn", 4, 10'000'000);
  odometry.latency = duration_in(node, "latency", 0.0, 1.0);
  node.finish();
  return odometry;
}

BatterySpec read_battery(ConfigNode node) {
  BatterySpec battery;
  battery.capacity = node.number_in("capacity", 0.1, 1e5);
  battery.voltage_full = node.number_in("voltage_full", 1.0, 1000.0);
  battery.voltage_empty = node.number_in("voltage_empty", 1.0, 1000.0);
  battery.resistance = node.number_in("resistance", 0.0, 10.0);
  battery.idle_power = node.number_in("idle_power", 0.0, 1e5);
  battery.drive_efficiency = node.number_in("drive_efficiency", 0.01, 1.0);
  battery.period = duration_in(node, "period", 0.01, 3600.0);
  node.finish();
  if (battery.voltage_empty > battery.voltage_full) node.at("voltage_empty").fail("must not exceed voltage_full");
  return battery;
}

// The numbers of a module's parameters, whose groups may be nested: {recovery: {same_place: 0.5}}.
void read_overrides(const ConfigNode& node, std::string_view module, const std::string& group,
                    std::vector<ParameterOverride>& overrides) {
  for (const auto& [field, value] : node.fields()) {
    const std::string name = group.empty() ? field : fmt::format("{}.{}", group, field);
    if (value.is_map()) {
      read_overrides(value, module, name, overrides);
    } else {
      overrides.push_back({std::string(module), name, value.number_in(-kMaxParameter, kMaxParameter), value.place()});
    }
  }
}

std::vector<ParameterOverride> read_autonomy(ConfigNode node) {
  std::vector<ParameterOverride> overrides;
  for (const std::string_view module : {"nav", "slam", "health", "safety"}) {
    if (node.has(module)) read_overrides(node.at(module), module, "", overrides);
  }
  node.finish();
  return overrides;
}

// What is asked of the robot must be within what its drive can do.
void check_limits(const RobotProfile& profile, ConfigNode limits) {
  const Body& body = profile.body;
  const Limits& hardware = profile.hardware_limits;
  const Limits& operating = profile.operating_limits;
  const double top_speed = body.no_load_speed * body.wheels.radius;
  if (hardware.linear > top_speed) {
    limits.at("hardware")
        .at("linear")
        .fail(fmt::format("{} m/s is beyond the motors' {:.3f} m/s without load", hardware.linear, top_speed));
  }
  const double grip = body.friction * kGravity;
  if (hardware.linear_braking > grip) {
    limits.at("hardware")
        .at("linear_braking")
        .fail(fmt::format("{} m/s^2 is beyond the {:.2f} m/s^2 that friction gives", hardware.linear_braking, grip));
  }
  const auto within = [&](std::string_view field, double asked, double possible) {
    if (asked <= possible) return;
    limits.at("operating").at(field).fail(fmt::format("{} is beyond the hardware limit of {}", asked, possible));
  };
  within("linear", operating.linear, hardware.linear);
  within("angular", operating.angular, hardware.angular);
  within("linear_acceleration", operating.linear_acceleration, hardware.linear_acceleration);
  within("linear_braking", operating.linear_braking, hardware.linear_braking);
  within("angular_acceleration", operating.angular_acceleration, hardware.angular_acceleration);
}

}  // namespace

bool RobotProfile::has(SensorType type) const {
  switch (type) {
    case SensorType::lidar: return lidar.has_value();
    case SensorType::imu: return imu.has_value();
    case SensorType::odometry: return true;
    case SensorType::battery: return battery.has_value();
    case SensorType::ultrasonic: return ultrasonics.has_value();
    case SensorType::camera: return camera.has_value();
  }
  return false;
}

Pose2D RobotProfile::base_from_sensor(SensorType type, std::string_view sensor) const {
  if (type == SensorType::lidar && lidar) return lidar->base_from_lidar;
  if (type == SensorType::camera && camera) return camera->base_from_camera;
  if (type == SensorType::ultrasonic && ultrasonics) {
    for (const UltrasonicSpec::Mount& mount : ultrasonics->mounts) {
      if (sensor == mount.name) return mount.base_from_ultrasonic;
    }
  }
  return {};
}

RobotProfile load_profile(std::string_view name) {
  const auto file = find_asset("robots", name);
  return parse_profile(ConfigNode::read(file), file);
}

RobotProfile parse_profile(std::string yaml, const std::filesystem::path& file) {
  ConfigNode root = ConfigNode::parse(yaml, file.string());

  RobotProfile profile;
  profile.name = file.stem().string();
  profile.yaml = std::move(yaml);
  profile.description = root.text("description");
  profile.body = read_body(root.at("body"));

  ConfigNode limits = root.at("limits");
  profile.hardware_limits = read_limits(limits.at("hardware"));
  profile.operating_limits = read_limits(limits.at("operating"));
  limits.finish();
  check_limits(profile, limits);
  profile.command_latency = duration_in(root, "command_latency", 0.0, 0.5);

  ConfigNode sensors = root.at("sensors");
  if (sensors.has("lidar")) profile.lidar = read_lidar(sensors.at("lidar"));
  if (sensors.has("imu")) profile.imu = read_imu(sensors.at("imu"));
  if (sensors.has("camera")) profile.camera = read_camera(sensors.at("camera"));
  if (sensors.has("ultrasonics")) profile.ultrasonics = read_ultrasonics(sensors.at("ultrasonics"));
  profile.odometry = read_odometry(sensors.at("odometry"));
  sensors.finish();
  if (root.has("battery")) profile.battery = read_battery(root.at("battery"));
  if (root.has("link")) profile.link = read_link(root.at("link"), profile);
  if (root.has("autonomy")) profile.autonomy = read_autonomy(root.at("autonomy"));
  root.finish();
  return profile;
}

std::vector<std::string> profile_names() { return asset_names("robots"); }

NoiseLevel noise_level(std::string_view name) {
  if (name == "realistic") return NoiseLevel::realistic;
  if (name == "ideal") return NoiseLevel::ideal;
  const std::vector<std::string> levels = {"realistic", "ideal"};
  throw ConfigError(unknown_name("noise", name, levels));
}

RobotProfile with_noise(RobotProfile profile, NoiseLevel noise) {
  if (noise == NoiseLevel::realistic) return profile;

  profile.command_latency = Duration::zero();
  if (profile.lidar) {
    LidarSpec& lidar = *profile.lidar;
    lidar.points_per_turn = lidar.beams;  // one point in the middle of each beam
    lidar.sigma = lidar.bias = lidar.dropout = 0.0;
    lidar.latency = Duration::zero();
    lidar.rolling = false;
  }
  if (profile.imu) *profile.imu = {.period = profile.imu->period};
  if (profile.camera) {
    profile.camera->sigma = 0.0;
    profile.camera->latency = Duration::zero();
    if (profile.camera->depth) profile.camera->depth->sigma = 0.0;
  }
  if (profile.ultrasonics) {
    profile.ultrasonics->max_incidence = kAnyIncidence;
    profile.ultrasonics->sigma = 0.0;
    profile.ultrasonics->latency = Duration::zero();
  }
  profile.odometry = {.period = profile.odometry.period};
  if (profile.battery) profile.battery->resistance = 0.0;
  return profile;
}

}  // namespace threewe
