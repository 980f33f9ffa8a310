#include "backend/mock/mock_port.hpp"

#include <utility>

#include "threewe/models/lidar.hpp"
#include "threewe/models/ultrasonic.hpp"
#include "threewe/sim/camera.hpp"
#include "threewe/sim/step.hpp"

namespace threewe::backend::mock {

MockPort::MockPort(const MockWorld& world, std::size_t index, const RobotProfile& profile)
    : SimulatedPort(world, profile, simulated_features(profile, true)),
      world_(world),
      index_(index),
      truth_(world.model_, index, world.states_, world.people_) {}

void MockPort::finish(Sample& sample, std::optional<sim::Shot>& shot) const {
  if (!shot) return;
  sample.data = Picture([model = world_.model_, taken = std::move(*shot)] { return sim::draw_picture(*model, taken); });
}

void MockPort::collect() {
  if (!connected()) return;
  const sim::RobotState& state = world_.states_[index_];
  const sim::RobotModel& robot = world_.model_->robots[index_];
  const RobotProfile& simulated = robot.profile;
  const auto pinged = sim::ping_ready(robot, state);
  std::size_t ultrasonic = 0;  // sensors of that kind so far
  for (std::size_t i = 0; i < features().sensors.size(); ++i) {
    switch (features().sensors[i].type) {
      case SensorType::lidar: {
        if (!sim::scan_ready(robot, state)) break;
        const LidarSpec& lidar = *simulated.lidar;
        send(i, models::scan_time(lidar, state.time() - lidar.turn),
             state.time() + sim::varied_latency(lidar.latency, state.variation),
             models::make_scan(lidar, sim::scan_points(robot, state)));
        break;
      }
      case SensorType::imu:
        if (sim::imu_ready(robot, state)) send(i, state.time(), state.time() + simulated.imu->latency, state.imu);
        break;
      case SensorType::odometry:
        if (sim::odometry_ready(robot, state)) {
          send(i, state.time(), state.time() + simulated.odometry.latency, state.odometry.reading);
        }
        break;
      case SensorType::battery:
        if (sim::battery_ready(robot, state)) send(i, state.time(), state.time(), state.battery);
        break;
      case SensorType::ultrasonic:
        if (pinged == ultrasonic++) {
          const UltrasonicSpec& spec = *simulated.ultrasonics;
          send(i, state.time(), state.time() + spec.latency, models::range_data(spec, state.ultrasonic_range));
        }
        break;
      case SensorType::camera:
        if (sim::picture_ready(robot, state)) {
          send(i, state.time(), state.time() + sim::varied_latency(simulated.camera->latency, state.variation),
               Picture(), sim::take_shot(world_.states_, world_.people_, index_));
        }
        break;
    }
  }
}

void MockPort::put(ByteWriter& bytes, const std::optional<sim::Shot>& shot) const {
  if (!shot) return;
  bytes.put(shot->key.seed);
  bytes.put(shot->key.episode);
  bytes.put(shot->key.robot);
  bytes.put(shot->step);
  bytes.put(shot->variation);
  bytes.put(shot->robots);
  bytes.put(shot->people);
}

void MockPort::get(ByteReader& bytes, const Sample& sample, std::optional<sim::Shot>& shot) const {
  if (!std::holds_alternative<Picture>(sample.data)) return;
  shot.emplace();
  shot->key.stream = Stream::camera;
  bytes.get(shot->key.seed);
  bytes.get(shot->key.episode);
  bytes.get(shot->key.robot);
  bytes.get(shot->step);
  bytes.get(shot->variation);
  bytes.get(shot->robots);
  bytes.get(shot->people);
}

}  // namespace threewe::backend::mock
