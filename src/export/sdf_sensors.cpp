#include "sdf_sensors.hpp"
#include "core/exact.hpp"

#include <fmt/format.h>

namespace threewe::exports {
namespace {

constexpr const char* kNewer = "newer than SDF 1.9, not run in Gazebo yet";
constexpr int kBeamsOfASound =
    5;  // side by side in the cone of an ultrasonic sensor, of which programs take the nearest

void add_range(pugi::xml_node parent, const char* name, double nearest, double farthest) {
  pugi::xml_node range = add(parent, name);
  add_text(range, "min", nearest);
  add_text(range, "max", farthest);
}

void add_noise(pugi::xml_node parent, double sigma) {
  if (sigma == 0.0) return;
  pugi::xml_node noise = add(parent, "noise");
  add_text(noise, "type", "gaussian");
  add_text(noise, "mean", 0.0);
  add_text(noise, "stddev", sigma);
}

void add_beams(pugi::xml_node sensor, const Lidar& beams, double nearest, double farthest, double sigma) {
  pugi::xml_node lidar = add(sensor, "lidar");
  pugi::xml_node scan = add(lidar, "scan");
  pugi::xml_node horizontal = add(scan, "horizontal");
  add_text(horizontal, "samples", std::to_string(beams.samples));
  add_text(horizontal, "resolution", 1.0);
  add_text(horizontal, "min_angle", beams.min_angle);
  add_text(horizontal, "max_angle", beams.max_angle);
  pugi::xml_node vertical = add(scan, "vertical");
  add_text(vertical, "samples", "1");
  add_text(vertical, "min_angle", 0.0);
  add_text(vertical, "max_angle", 0.0);
  add_range(lidar, "range", nearest, farthest);
  add_noise(lidar, sigma);
}

void add_camera(pugi::xml_node sensor, const CameraSpec& spec, const std::string& frame) {
  pugi::xml_node camera = add(sensor, "camera", {{"name", frame}});
  add_text(camera, "horizontal_fov", spec.horizontal_fov);
  pugi::xml_node image = add(camera, "image");
  add_text(image, "width", std::to_string(spec.width));
  add_text(image, "height", std::to_string(spec.height));
  add_text(image, "format", "R8G8B8");
  pugi::xml_node clip = add(camera, "clip");
  add_text(clip, "near", spec.depth ? spec.depth->range_min : kCameraNear);
  add_text(clip, "far", spec.depth ? spec.depth->range_max : kCameraFar);
  add_noise(camera, spec.sigma / 255);
  add_comment(camera, kNewer);
  add_text(camera, "optical_frame_id", frame + "_optical_frame");
}

void add_axes(pugi::xml_node imu, const char* name, double sigma) {
  pugi::xml_node quantity = add(imu, name);
  for (const char* axis : {"x", "y", "z"}) {  // here, unlike elsewhere, the type is an attribute
    pugi::xml_node noise = add(add(quantity, axis), "noise", {{"type", "gaussian"}});
    add_text(noise, "mean", 0.0);
    add_text(noise, "stddev", sigma);
  }
}

struct GazeboSensor {
  const char* type;
  Duration period;
};

GazeboSensor gazebo_sensor(SensorType type, const RobotProfile& profile) {
  if (type == SensorType::lidar) return {"gpu_lidar", profile.lidar->turn};
  if (type == SensorType::imu) return {"imu", profile.imu->period};
  if (type == SensorType::camera) {
    return {profile.camera->depth ? "rgbd_camera" : "camera", profile.camera->period};
  }
  return {"gpu_lidar", profile.ultrasonics->interval};  // all at once, of which programs take one in turn
}

}  // namespace

Lidar lidar_of(const LidarSpec& spec) {
  const double step = 2 * exact::kPi / spec.beams;
  return {spec.beams, -exact::kPi, exact::kPi - step};
}

void add_sdf_sensor(pugi::xml_node link, const SensorMount& mount, const RobotProfile& profile, const Transform& pose) {
  const auto [type, period] = gazebo_sensor(mount.type, profile);
  pugi::xml_node sensor = add(link, "sensor", {{"name", mount.name}, {"type", type}});
  add_text(sensor, "pose", sdf_pose(pose));
  add_text(sensor, "always_on", "true");
  add_text(sensor, "update_rate", 1 / to_seconds(period));
  add_text(sensor, "topic", mount.name);
  add_comment(sensor, kNewer);
  add_text(sensor, "gz_frame_id", mount.name);
  if (mount.type == SensorType::lidar) {
    const LidarSpec& lidar = *profile.lidar;
    add_beams(sensor, lidar_of(lidar), lidar.range_min, lidar.range_max, lidar.sigma);
  } else if (mount.type == SensorType::camera) {
    add_camera(sensor, *profile.camera, mount.name);
  } else if (mount.type == SensorType::imu) {
    pugi::xml_node imu = add(sensor, "imu");
    add_axes(imu, "angular_velocity", profile.imu->gyro_sigma);
    add_axes(imu, "linear_acceleration", profile.imu->accelerometer_sigma);
  } else {
    const UltrasonicSpec& sound = *profile.ultrasonics;
    add_beams(sensor, {kBeamsOfASound, -0.5 * sound.field_of_view, 0.5 * sound.field_of_view}, sound.range_min,
              sound.range_max, sound.sigma);
  }
}

std::string sdf_pose(const Transform& pose) {
  return fmt::format("{} {}", text(pose.position), text(roll_pitch_yaw(pose.rotation)));
}

}  // namespace threewe::exports
