// Whether MuJoCo's sensors see what the embedded simulator's do: verify_backends LIBMUJOCO SCENE SEED POSES.
//
// A robot without noise stands somewhere, amid people who stand still. First its sensors are exactly where the embedded
// ones are; then MuJoCo's robot has settled on its wheels; then it drives, and tilts as it speeds up and brakes.
#include <cstdio>

#include "number.hpp"

#if THREEWE_WITH_MUJOCO

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/mujoco/mujoco.hpp"
#include "backend/mujoco/world/engine.hpp"
#include "backend/mujoco/world/senses.hpp"
#include "core/exact.hpp"
#include "models/lidar.hpp"
#include "scene/scene_tables.hpp"
#include "sim/step.hpp"

using namespace threewe;
using backend::mujoco::MujocoEngine;
using backend::mujoco::Physics;
using exports::Vec3;

namespace {

struct Counts {
  long beams = 0;
  long beams_off = 0;  // more than 1 cm from one another
  long pixels = 0;
  long edges = 0;      // of these, beside an edge of depth
  long depth_off = 0;  // of the rest, more than 2 cm and 1 % from one another
  long ids_off = 0;
};

// One simulator's robot as it is, and how it is.
struct Body {
  Counts counts;
  double tilt = 0.0;  // [rad] the most
  double sunk = 0.0;  // [m] likewise
};

void count_beams(std::span<const float> ours, std::span<const float> expected, Counts& counts) {
  constexpr float kAgree = 0.01F;  // [m]
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ++counts.beams;
    if (std::fabs(ours[i] - expected[i]) > kAgree) ++counts.beams_off;
  }
}

// Along a line of pixels the inverse depth of a plane is a straight line. Where it bends, or where only one of two
// neighbours shows anything, there is an edge.
class Edges {
 public:
  Edges(const CameraIntrinsics& camera, std::span<const float> depth) : camera_(camera) {
    for (const float d : depth) inverse_.push_back(d > 0.0F ? 1.0F / d : 0.0F);
    for (int row = 0; row < camera.height; ++row) {
      for (int column = 0; column < camera.width; ++column) {
        bent_.push_back(bends(row, column, 0, 1) || bends(row, column, 1, 0));
      }
    }
  }

  // Whether a pixel or one of its eight neighbours is on an edge.
  bool beside(int row, int column) const {
    for (int r = row - 1; r <= row + 1; ++r) {
      for (int c = column - 1; c <= column + 1; ++c) {
        if (bent_[index(r, c)]) return true;
      }
    }
    return false;
  }

 private:
  bool bends(int row, int column, int down, int right) const {
    constexpr float kBend = 0.02F;  // of the inverse depth
    const float before = inverse_[index(row - down, column - right)];
    const float here = inverse_[index(row, column)];
    const float after = inverse_[index(row + down, column + right)];
    return std::fabs(before + after - 2.0F * here) > kBend * std::max({before, here, after});
  }
  // Of a pixel, or of the nearest in the picture.
  std::size_t index(int row, int column) const {
    row = std::clamp(row, 0, camera_.height - 1);
    column = std::clamp(column, 0, camera_.width - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(column);
  }

  CameraIntrinsics camera_;
  std::vector<float> inverse_;
  std::vector<bool> bent_;
};

// Ids are compared where there are any.
void count_pixels(const RGBDImage& ours, const RGBDImage& expected, std::span<const std::int16_t> our_ids,
                  std::span<const std::int16_t> expected_ids, Counts& counts) {
  const CameraIntrinsics& camera = expected.intrinsics;
  const Edges edges(camera, expected.depth);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      ++counts.pixels;
      if (edges.beside(row, column)) {
        ++counts.edges;
        continue;
      }
      const std::size_t i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(column);
      const float off = std::fabs(ours.depth[i] - expected.depth[i]);
      if (off > std::max(0.02F, 0.01F * expected.depth[i])) ++counts.depth_off;
      if (!our_ids.empty() && our_ids[i] != expected_ids[i]) ++counts.ids_off;
    }
  }
}

// A robot that stands somewhere, and the people around it.
struct Stand {
  const sim::Model* model = nullptr;
  std::vector<sim::RobotState> robots;
  std::vector<sim::PersonState> people;
};

constexpr int kTurns = 3;  // of the lidar, until people have come somewhere and the robot has settled

Stand stand_at(const sim::Model& model, const Pose2D& pose, std::uint64_t seed) {
  Stand stand{&model, {sim::begin(model, 0, pose, seed)}, {}};
  stand.people = sim::begin_people(model, stand.robots, seed);
  return stand;
}

void compare_exact(Stand stand, Physics& physics, const MujocoEngine& engine, Counts& counts) {
  const sim::Model& model = *stand.model;
  const Velocity still;
  for (int i = 0; i < kTurns * model.robots[0].turn; ++i) {
    sim::step(model, stand.robots, {&still, 1}, stand.people);
  }
  const sim::RobotState& state = stand.robots[0];
  const RobotProfile& profile = model.robots[0].profile;
  const LidarSpec& lidar = *profile.lidar;

  physics.place({&state.pose, 1}, stand.people);
  physics.look_for(0);
  const Pose2D eye = state.pose * lidar.base_from_lidar;
  std::vector<float> points;
  for (const Vec3& beam : backend::mujoco::beams_of(lidar)) {
    const Vec3 direction = rotated(exports::about_z(state.pose.theta), beam);
    const double hit = physics.cast({eye.x, eye.y, lidar.height}, direction).distance;
    points.push_back(static_cast<float>(hit < 0.0 ? lidar.range_max : std::min(hit, lidar.range_max)));
  }
  count_beams(models::make_scan(lidar, points).ranges,
              models::make_scan(lidar, sim::scan_points(model.robots[0], state)).ranges, counts);

  const CameraSpec& camera = *profile.camera;
  const sim::CameraPose view{state.pose * camera.base_from_camera, camera.mount_height};
  const backend::simulated::WorldCapture capture{sim::capture_pose(stand.robots, stand.people, 0), physics.state()};
  const SemanticImage ours = engine.look(capture, camera.intrinsics(), view, false);
  const SemanticImage expected = sim::draw_truth(model, capture.state, camera.intrinsics(), view, false);
  count_pixels(ours.image, expected.image, ours.ids, expected.ids, counts);
}

// What it is told: another velocity every 0.2 s, or nothing.
Velocity command_at(int step, bool drives, std::uint64_t seed) {
  const RngKey key{.seed = seed};
  const auto draw = static_cast<std::uint64_t>(step / 20);
  if (!drives) return {};
  return {uniform(key, draw, 0, -0.5, 0.5), uniform(key, draw, 1, -0.3, 0.3), uniform(key, draw, 2, -1.0, 1.0)};
}

void compare_body(Stand stand, MujocoEngine& engine, bool drives, std::uint64_t seed, Body& body) {
  const sim::Model& model = *stand.model;
  const sim::RobotModel& robot = model.robots[0];
  engine.place(stand.robots, stand.people);
  Stand before = stand;
  for (int i = 0; i < kTurns * robot.turn; ++i) {
    before = stand;
    const Velocity command = command_at(i, drives, seed);
    engine.step(stand.robots, {&command, 1}, stand.people);
  }

  // the embedded robot takes its scan where MuJoCo's is, as the same people take their last step
  const Velocity still;
  sim::RobotState& twin = before.robots[0];
  twin.pose = stand.robots[0].pose;
  twin.velocity = {};
  twin.wheel_speeds = {};
  twin.commands = {};
  sim::step(model, before.robots, {&still, 1}, before.people);
  const LidarSpec& lidar = *robot.profile.lidar;
  count_beams(models::make_scan(lidar, sim::scan_points(robot, stand.robots[0])).ranges,
              models::make_scan(lidar, sim::scan_points(robot, twin)).ranges, body.counts);

  const backend::simulated::WorldCapture capture{sim::capture_pose(stand.robots, stand.people, 0), engine.state()};
  const Picture ours = engine.picture(capture);
  count_pixels(ours.image(), sim::draw_picture(model, capture.state), {}, {}, body.counts);

  const exports::Transform base = engine.physics().track(0).back();
  const Vec3 up = rotated(base.rotation, {0.0, 0.0, 1.0});
  body.tilt = std::max(body.tilt, exact::hypot(up.x, up.y));
  body.sunk = std::max(body.sunk, std::fabs(base.position.z));
}

void print(const char* table, const Counts& counts) {
  std::printf("%s_beams %ld\n%s_beams_off %ld\n", table, counts.beams, table, counts.beams_off);
  std::printf("%s_pixels %ld\n%s_edges %ld\n", table, counts.pixels, table, counts.edges);
  std::printf("%s_compared %ld\n%s_depth_off %ld\n", table, counts.pixels - counts.edges, table, counts.depth_off);
  std::printf("%s_ids_off %ld\n", table, counts.ids_off);
}

void print(const char* table, const Body& body) {
  print(table, body.counts);
  std::printf("%s_tilt_mrad %.6f\n%s_sunk_mm %.6f\n", table, 1e3 * body.tilt, table, 1e3 * body.sunk);
}

int run(const char* library, const char* name, std::uint64_t seed, std::uint64_t poses) {
  backend::mujoco::use_library(library);
  const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(name));
  const RobotProfile profile = with_noise(load_profile("3we_depth_v2"), NoiseLevel::ideal);
  const scene::SceneTables places(scene, profile.body.footprint, profile.body.height);
  const auto model = sim::make_model(scene, {profile});
  MujocoEngine engine(model);
  Physics physics(model);
  Counts exact;
  Body settled;
  Body driving;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const std::uint64_t draw = seed + (i << 32U);
    const Stand stand = stand_at(*model, places.sample_free_pose(draw), draw);
    compare_exact(stand, physics, engine, exact);
    compare_body(stand, engine, false, draw, settled);
    compare_body(stand, engine, true, draw, driving);
  }
  print("exact", exact);
  print("settled", settled);
  print("driving", driving);
  return 0;
}

}  // namespace

#else

namespace {

int run(const char*, const char*, std::uint64_t, std::uint64_t) {
  std::fputs("this build has no MuJoCo backend\n", stderr);
  return 3;
}

}  // namespace

#endif

int main(int argc, char** argv) {
  const auto seed = threewe::parse_number(argc == 5 ? argv[3] : "");
  const auto poses = threewe::parse_number(argc == 5 ? argv[4] : "");
  if (!seed || !poses) {
    std::fputs("usage: verify_backends LIBMUJOCO SCENE SEED POSES\n", stderr);
    return 2;
  }
  return run(argv[1], argv[2], *seed, *poses);
}
