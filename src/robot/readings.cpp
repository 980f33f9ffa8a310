// What a robot tells when it is asked.
#include <map>
#include <string>
#include <vector>

#include "core/names.hpp"
#include "robot/runtime_state.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/warning.hpp"

namespace threewe {
namespace {

constexpr int kManyReads = 1000;  // at one stamp: a program waits for time to go by

}  // namespace

const LaserScan& Runtime::lidar_scan() const { return std::get<LaserScan>(sample(SensorType::lidar).data); }
const IMUData& Runtime::imu() const { return std::get<IMUData>(sample(SensorType::imu).data); }
const Odometry& Runtime::odometry() const { return std::get<Odometry>(sample(SensorType::odometry).data); }
const BatteryState& Runtime::battery() const { return std::get<BatteryState>(sample(SensorType::battery).data); }

const RGBDImage& Runtime::image(std::string_view camera) const {
  if (camera == "fisheye") {
    throw HardwareError("'fisheye' is the raw image of a real robot's lens; 'camera' is its rectified view");
  }
  if (camera != to_string(SensorType::camera)) {
    const std::vector<std::string> cameras = {"camera", "fisheye"};
    throw ContractError(unknown_name("camera", camera, cameras));
  }
  return std::get<Picture>(sample(SensorType::camera).data).image();
}

const RGBDImage& Runtime::rgbd_image() const {
  const RGBDImage& image = this->image();
  if (!image.depth.empty()) return image;
  throw HardwareError("the camera of robot '" + profile().name + "' measures no depth; that of '3we_depth_v2' does");
}

std::map<std::string, RangeData> Runtime::ultrasonic_ranges() const {
  const Senses& senses = impl_->reading().senses;
  std::map<std::string, RangeData> ranges;
  for (const std::size_t sensor : sensors_of(features(), profile(), SensorType::ultrasonic)) {
    ranges[features().sensors[sensor].name] = std::get<RangeData>(senses.newest(features(), sensor).data);
  }
  return ranges;
}

const Sample& Runtime::sample(SensorType type) const {
  return impl_->reading().senses.newest(features(), sensors_of(features(), profile(), type).front());
}

const slam::PoseEstimate& Runtime::pose() const { return impl_->reading().estimate; }

const map::OccupancyGrid& Runtime::map() const {
  const State& state = impl_->reading();
  if (features().has(SensorType::lidar)) return state.localizer->map();
  throw HardwareError("robot '" + profile().name + "' has no sensor 'lidar', which a map needs");
}

std::uint64_t Runtime::map_version() const { return impl_->reading().localizer->map_version(); }

std::span<const Vec2> Runtime::path() const {
  return impl_->motion && impl_->motion->goal ? impl_->state->navigator->path() : std::span<const Vec2>();
}

std::optional<nav::SampledPlan> Runtime::plan() const {
  return impl_->motion && impl_->motion->goal ? impl_->state->navigator->plan() : std::nullopt;
}

std::span<const Vec2> Runtime::obstacles() const { return impl_->obstacles_in_odom(); }
std::span<const perception::TrackedPerson> Runtime::people() const {
  const State& state = impl_->reading();
  if (features().has(SensorType::lidar)) return state.perception.people();
  throw HardwareError("robot '" + profile().name + "' has no sensor 'lidar', by which people are seen");
}

const std::vector<SensorHealth>& Runtime::health() const {
  const State& state = *impl_->state;
  return state.health.empty() ? state.perception.health().sensors() : state.health;
}
const Velocity& Runtime::requested() const { return impl_->state->requested; }
const safety::GateOutput& Runtime::commanded() const { return impl_->state->commanded; }

Pose2D Runtime::transform(std::string_view target, std::string_view source) const {
  const slam::PoseEstimate& estimate = impl_->reading().estimate;
  const auto odom_from = [&](std::string_view frame) -> Pose2D {
    if (frame == "map") return inverse(estimate.map_from_odom);
    if (frame == "odom") return {};
    if (frame == "base") return estimate.odom_from_base;
    std::vector<std::string> frames = {"map", "odom", "base"};
    for (const SensorInfo& sensor : features().sensors) {
      if (sensor.name != frame) {
        frames.push_back(sensor.name);
      } else {
        return estimate.odom_from_base * profile().base_from_sensor(sensor.type, sensor.name);
      }
    }
    throw ContractError(unknown_name("frame", frame, frames));
  };
  const Pose2D odom_from_target = odom_from(target);
  if (target == source) return {};  // exactly
  return inverse(odom_from_target) * odom_from(source);
}

// In lockstep a loop that only reads would never see anything new.
const Runtime::State& Runtime::Impl::reading() const {
  require_healthy();
  if (reads_stamp != now()) reads = 0;
  reads_stamp = now();
  if (++reads >= kManyReads && !warned_of_reads && !world.realtime()) {
    warned_of_reads = true;
    warn("1,000 readings at one time: reading does not let time go by; wait with robot.sleep(...) in between");
  }
  return *state;
}

}  // namespace threewe
