// What a robot second on MuJoCo costs through our backend, over MuJoCo's own loop with the same model, the same
// commands and the same rays: by turns, second by second, in one run. Target: at most 1.10.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "backend/mujoco/mujoco.hpp"
#include "backend/mujoco/world/library.hpp"
#include "core/exact.hpp"
#include "export/mjcf.hpp"
#include "models/lidar.hpp"
#include "threewe/backend/registry.hpp"

using namespace threewe;
using backend::mujoco::Library;

namespace {

constexpr const char* kScene = "apartment_v1";
constexpr Duration kSlice = 1s;
constexpr Duration kStep = 2ms;  // of the exported model
constexpr mjtByte kOwnGroup = 5;

// Back and forth on a figure of eight around the start.
Velocity figure_of_eight(Time now) { return {0.1, 0.0, now / 8s % 2 == 0 ? 0.785 : -0.785}; }

// MuJoCo as one would use it by itself: control, step, and rays where our sensors cast theirs.
class OwnLoop {
 public:
  explicit OwnLoop(const std::string& robot)
      : mj_(backend::mujoco::library()), profile_(with_noise(load_profile(robot), NoiseLevel::realistic)) {
    const scene::Scene scene = scene::Scene::load(kScene);
    const exports::PlacedRobot placed{"robot", exports::describe(profile_), scene.starts.front()};
    std::array<char, 1000> error{};
    mjSpec* spec =
        mj_.mj_parseXMLString(exports::mjcf(scene, {&placed, 1}).c_str(), nullptr, error.data(), error.size());
    std::vector<mjsElement*> rangefinders;  // rays are cast below, as often as our sensors ping
    for (mjsElement* sensor = mj_.mjs_firstElement(spec, mjOBJ_SENSOR); sensor != nullptr;
         sensor = mj_.mjs_nextElement(spec, sensor)) {
      if (mj_.mjs_asSensor(sensor)->type == mjSENS_RANGEFINDER) rangefinders.push_back(sensor);
    }
    for (mjsElement* sensor : rangefinders) mj_.mjs_delete(spec, sensor);
    model_ = mj_.mj_compile(spec, nullptr);
    mj_.mj_deleteSpec(spec);
    data_ = mj_.mj_makeData(model_);
    const int base = mj_.mj_name2id(model_, mjOBJ_BODY, "robot/base_link");
    qpos_ = model_->jnt_qposadr[model_->body_jntadr[base]];
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      if (model_->body_rootid[model_->geom_bodyid[geom]] == base) model_->geom_group[geom] = kOwnGroup;
    }
    groups_.fill(1);
    groups_[kOwnGroup] = 0;
  }
  OwnLoop(const OwnLoop&) = delete;
  OwnLoop& operator=(const OwnLoop&) = delete;
  ~OwnLoop() {
    mj_.mj_deleteData(data_);
    mj_.mj_deleteModel(model_);
  }

  void run(Duration time) {
    const LidarSpec& lidar = *profile_.lidar;
    for (const Time end = now_ + time; now_ < end; now_ += kStep) {
      if (now_ % kControlPeriod == Duration::zero()) {
        const WheelSpeeds speeds = wheel_speeds(profile_.body.wheels, figure_of_eight(now_));
        for (int wheel = 0; wheel < model_->nu; ++wheel) data_->ctrl[wheel] = speeds[static_cast<std::size_t>(wheel)];
      }
      mj_.mj_step1(model_, data_);
      mj_.mj_step2(model_, data_);
      const auto left_by = [&](Time t) { return t * lidar.points_per_turn / lidar.turn; };
      cast(left_by(now_ + kStep) - left_by(now_), lidar.base_from_lidar.position(), lidar.height,
           2.0 * exact::kPi / lidar.points_per_turn);
      if (profile_.ultrasonics && now_ % profile_.ultrasonics->interval == Duration::zero()) {
        const double between = 0.25 * exact::kPi / 180.0;
        cast(1 + static_cast<std::int64_t>(profile_.ultrasonics->field_of_view / between), {0.125, 0.07},
             profile_.ultrasonics->height, between);
      }
    }
  }

 private:
  void cast(std::int64_t rays, Vec2 mount, double height, double between) {
    const double* q = data_->qpos + qpos_;
    const double theta = exact::atan2(2.0 * (q[3] * q[6] + q[4] * q[5]), 1.0 - 2.0 * (q[5] * q[5] + q[6] * q[6]));
    const Vec2 from = Pose2D{q[0], q[1], theta} * mount;
    const std::array<double, 3> point{from.x, from.y, q[2] + height};
    for (std::int64_t ray = 0; ray < rays; ++ray) {
      const auto [sin, cos] = exact::sincos(theta + between * static_cast<double>(cast_++));
      const std::array<double, 3> along{cos, sin, 0.0};
      std::array<double, 3> normal{};
      int geom = -1;
      benchmark::DoNotOptimize(
          mj_.mj_ray(model_, data_, point.data(), along.data(), groups_.data(), true, -1, &geom, normal.data()));
    }
  }

  const Library& mj_;
  RobotProfile profile_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  int qpos_ = 0;
  std::array<mjtByte, mjNGROUP> groups_{};
  Time now_{};
  std::int64_t cast_ = 0;  // rays so far, each turned on from the one before
};

// [s] of this thread's CPU time.
double cost_of(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

void over_mujocos_own_loop(benchmark::State& state, const std::string& robot) {
  backend::mujoco::use_library(MUJOCO_LIBRARY);
  const auto world = backend::make_world("mujoco", {.scene = kScene, .robots = {robot}});
  backend::RobotPort& port = world->robot(0);
  port.connect();
  OwnLoop own(robot);
  const auto through_ours = [&] {
    for (Duration t{}; t < kSlice; t += kControlPeriod) {
      const Time now = world->now();
      port.command(figure_of_eight(now), now + 200ms);
      world->advance_to(now + kControlPeriod);
      benchmark::DoNotOptimize(port.poll());
    }
  };
  std::vector<double> ours;
  std::vector<double> ratios;  // of one second to the next: what else runs slows both
  for (auto _ : state) {
    ours.push_back(cost_of(through_ours));
    ratios.push_back(ours.back() / cost_of([&] { own.run(kSlice); }));
    state.SetIterationTime(ours.back());
  }
  state.counters["ours_over_own_loop"] = median(ratios);
  state.counters["times_real_time"] = to_seconds(kSlice) / median(ours);
}

}  // namespace

BENCHMARK_CAPTURE(over_mujocos_own_loop, 3we_standard_v2, "3we_standard_v2")->UseManualTime()->Iterations(60);
BENCHMARK_CAPTURE(over_mujocos_own_loop, turtlebot_like, "turtlebot_like")->UseManualTime()->Iterations(200);
