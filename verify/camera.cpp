// Whether the camera agrees with the lidar and with a ray tracer: verify_camera SCENE SEED.
//
// A robot stands somewhere in the scene while people walk. Each beam of its scan is compared with the depth in that
// direction, each pixel of a picture with what the ray through it meets first.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "models/lidar.hpp"
#include "number.hpp"
#include "scene/scene_tables.hpp"
#include "sim/actor_geometry.hpp"
#include "sim/comparison.hpp"
#include "sim/step.hpp"

using namespace threewe;

namespace {

constexpr double kAgree = 0.01;  // [m]

struct Place {
  std::shared_ptr<const sim::Model> model;
  std::vector<sim::RobotState> robots;
  std::vector<sim::PersonState> people;
  std::vector<sim::VisibleSolid> figures;  // all but the robot itself
};

// A robot without noise at a place of the seed's choice, a turn of its lidar after people have set out.
Place stand_in(const std::string& name, std::uint64_t seed) {
  const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(name));
  const RobotProfile profile = with_noise(load_profile("3we_depth_v2"), NoiseLevel::ideal);
  const scene::SceneTables tables(scene, profile.body.footprint, profile.body.height);
  Place place{sim::make_model(scene, {profile}), {}, {}, {}};
  place.robots.push_back(sim::begin(*place.model, 0, tables.sample_free_pose(seed), seed));
  place.people = sim::begin_people(*place.model, place.robots, seed);
  const Velocity still;
  do {
    sim::step(*place.model, place.robots, {&still, 1}, place.people);
  } while (!sim::scan_ready(place.model->robots[0], place.robots[0]) || place.robots[0].time() < 1s);
  sim::find_actors(*place.model, std::vector{place.robots[0].pose}, 0, place.people, seed, 0, place.figures);
  return place;
}

// Beams whose range is not the depth in their direction, to within 1 cm.
int beams_off(const Place& place, const sim::Renderer& renderer) {
  const sim::RobotModel& robot = place.model->robots[0];
  const LidarSpec& lidar = *robot.profile.lidar;
  const LaserScan scan = models::make_scan(lidar, sim::scan_points(robot, place.robots[0]));
  const Pose2D eye = place.robots[0].pose * lidar.base_from_lidar;
  const CameraIntrinsics pixel{1, 1, 100.0, 100.0, 0.5, 0.5};
  const sim::Shading shading{0, 0};
  int off = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const sim::CameraPose view{{eye.x, eye.y, wrap_angle(eye.theta + angle)}, lidar.height};
    const auto depth = static_cast<double>(sim::take(renderer, pixel, view, shading, place.figures).depth[0]);
    const double seen = depth > 0.0 ? std::min(depth, lidar.range_max) : lidar.range_max;
    off += std::fabs(seen - static_cast<double>(scan.ranges[i])) > kAgree ? 1 : 0;
  }
  return off;
}

sim::Comparison compare_picture(const Place& place, const sim::Renderer& renderer, std::uint64_t seed) {
  const CameraSpec& camera = *place.model->robots[0].profile.camera;
  const CameraIntrinsics intrinsics = make_intrinsics(80, 60, camera.horizontal_fov);
  const sim::CameraPose view{place.robots[0].pose * camera.base_from_camera, camera.mount_height};
  const sim::Shading shading{seed, 0};
  sim::Comparison comparison;
  comparison.compare({*place.model->scene, intrinsics, view, shading, place.figures}, intrinsics,
                     sim::take(renderer, intrinsics, view, shading, place.figures));
  return comparison;
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 3 ? argv[2] : "");
  if (!seed) {
    std::fputs("usage: verify_camera SCENE SEED\n", stderr);
    return 2;
  }
  const Place place = stand_in(argv[1], *seed);
  const sim::Renderer renderer(*place.model->scene);
  const sim::Comparison comparison = compare_picture(place, renderer, *seed);
  std::printf("beams %d\nbeams_off %d\n", place.model->robots[0].profile.lidar->beams, beams_off(place, renderer));
  std::printf("pixels %d\npixels_at_edges %d\npixels_wrong %d\npixels_of_another_colour %d\n", comparison.pixels,
              comparison.grazing, comparison.wrong - comparison.colour_alone, comparison.colour_alone);
}
