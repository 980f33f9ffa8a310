#include "world_file.hpp"

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>
#include <sdf/sdf.hh>

using namespace threewe;

namespace {

Duration whole_milliseconds(double rate) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(1.0 / rate));
}

SensorFile read_sensor(const sdf::Sensor& sensor) {
  SensorFile file;
  file.topic = fmt::format("/{}", sensor.Topic().empty() ? sensor.Name() : sensor.Topic());
  if (sensor.UpdateRate() > 0) file.period = whole_milliseconds(sensor.UpdateRate());
  const auto& pose = sensor.RawPose();
  file.mount = {pose.Pos().X(), pose.Pos().Y(), pose.Rot().Yaw()};
  file.height = pose.Pos().Z();
  switch (sensor.Type()) {
    case sdf::SensorType::GPU_LIDAR: {
      const sdf::Lidar& lidar = *sensor.LidarSensor();
      file.kind = SensorFile::Kind::lidar;
      file.beams = lidar.HorizontalScanSamples();
      file.angle_min = lidar.HorizontalScanMinAngle().Radian();
      file.angle_max = lidar.HorizontalScanMaxAngle().Radian();
      file.range_min = lidar.RangeMin();
      file.range_max = lidar.RangeMax();
      file.sigma = lidar.LidarNoise().StdDev();
      break;
    }
    case sdf::SensorType::IMU:
      file.kind = SensorFile::Kind::imu;
      file.sigma = sensor.ImuSensor()->AngularVelocityZNoise().StdDev();
      file.accelerometer_sigma = sensor.ImuSensor()->LinearAccelerationXNoise().StdDev();
      break;
    case sdf::SensorType::CAMERA:
    case sdf::SensorType::RGBD_CAMERA: {
      const sdf::Camera& camera = *sensor.CameraSensor();
      file.kind = sensor.Type() == sdf::SensorType::CAMERA ? SensorFile::Kind::camera : SensorFile::Kind::rgbd;
      file.width = static_cast<int>(camera.ImageWidth());
      file.height_in_pixels = static_cast<int>(camera.ImageHeight());
      file.fov = camera.HorizontalFov().Radian();
      file.range_min = camera.NearClip();
      file.range_max = camera.FarClip();
      break;
    }
    case sdf::SensorType::CONTACT:
      file.kind = SensorFile::Kind::contact;
      file.topic = fmt::format("/{}", sensor.Element()->GetElement("contact")->Get<std::string>("topic"));
      break;
    default: throw std::runtime_error("a sensor of type " + sensor.TypeStr());
  }
  return file;
}

void read_plugin(const sdf::ElementPtr& element, WorldFile& file) {
  const auto full_name = element->Get<std::string>("name");
  const std::string name = full_name.substr(full_name.rfind(':') + 1);
  const bool drive = name == "MecanumDrive" || name == "DiffDrive";
  if (drive) file.command_topic = fmt::format("/{}", element->Get<std::string>("topic"));
  if (!drive && name != "OdometryPublisher") return;
  OdometryFile odometry;
  odometry.topic = fmt::format("/{}", element->Get<std::string>("odom_topic"));
  odometry.period = std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(1.0 / element->Get<double>("odom_publish_frequency", 50.0).first));
  odometry.of_wheels = drive;
  file.odometries.push_back(odometry);
}

}  // namespace

WorldFile read_world_file(const std::string& file) {
  sdf::ParserConfig config = sdf::ParserConfig::GlobalConfig();
  config.AddURIPath("model://", (std::filesystem::path(file).parent_path() / "models").string());
  sdf::Root root;
  const sdf::Errors errors = root.Load(file, config);
  if (!errors.empty()) throw std::runtime_error(errors.front().Message());
  if (root.WorldCount() != 1) throw std::runtime_error(file + ": no world");
  const sdf::World& world = *root.WorldByIndex(0);
  WorldFile found;
  found.name = world.Name();
  found.step = std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::round(1e9 * world.PhysicsDefault()->MaxStepSize()) * 1e-9));
  found.real_time_factor = world.PhysicsDefault()->RealTimeFactor();
  for (std::uint64_t i = 0; i < world.ModelCount(); ++i) {
    const sdf::Model& model = *world.ModelByIndex(i);
    if (model.Static()) continue;
    found.model = model.Name();
    for (std::uint64_t k = 0; k < model.LinkCount(); ++k) {
      const sdf::Link& link = *model.LinkByIndex(k);
      for (std::uint64_t s = 0; s < link.SensorCount(); ++s)
        found.sensors.push_back(read_sensor(*link.SensorByIndex(s)));
    }
    for (auto plugin = model.Element()->FindElement("plugin"); plugin; plugin = plugin->GetNextElement("plugin")) {
      read_plugin(plugin, found);
    }
  }
  if (found.model.empty()) throw std::runtime_error(file + ": no model that moves");
  return found;
}
