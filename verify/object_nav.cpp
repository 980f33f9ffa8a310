// Whether ObjectNav is true of the renderer's pictures: verify_object_nav SEED SCENE COUNT.
//
// COUNT episodes are drawn in a scene: one of assets/scenes, or one that is generated from the seed. Counted are those
// with 200 pixels of the goal's kind in the picture at the start; those in which a robot at the end of the shortest
// path can turn so that STOP is right, by its pictures; and, of things seen there, those whose silhouette has other
// pixels than in a picture of a scene that holds nothing else.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "number.hpp"
#include "scene/scene_tables.hpp"
#include "sim/renderer.hpp"
#include "task/object_nav.hpp"
#include "task/sight.hpp"
#include "threewe/scene/generator.hpp"

using namespace threewe;

namespace {

constexpr int kHeadings = 36;

// A scene, and what the robot's camera shows of it.
class Camera {
 public:
  Camera(const scene::Scene& scene, const CameraSpec& camera) : camera_(camera), renderer_(scene) {}

  std::span<const std::int16_t> look(const Pose2D& base) {
    const CameraIntrinsics view = camera_.intrinsics();
    ids_.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
    renderer_.render(view, {base * camera_.base_from_camera, camera_.mount_height}, shading_,
                     {.colour = {}, .depth = {}, .ids = ids_}, scratch_);
    return ids_;
  }

 private:
  CameraSpec camera_;
  sim::Renderer renderer_;
  sim::Shading shading_{0, 0};
  sim::RenderScratch scratch_;
  std::vector<std::int16_t> ids_;
};

struct Counts {
  int seen_at_start = 0;
  int right_at_end = 0;
  int silhouettes = 0;
  int silhouettes_off = 0;
};

std::int16_t id_of(std::size_t object) {
  return static_cast<std::int16_t>(sim::kFirstObjectId + static_cast<int>(object));
}

long most_pixels(const scene::Scene& scene, std::string_view category, std::span<const std::int16_t> ids) {
  long most = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].category == category) most = std::max<long>(most, std::ranges::count(ids, id_of(i)));
  }
  return most;
}

// Downhill, 5 cm at a time, as far as it goes.
Vec2 end_of_path(const task::ObjectNav& nav, const task::ObjectNavEpisode& episode) {
  Vec2 place = episode.start.position();
  double left = episode.geodesic;
  for (int turn = 0; turn < 32 && left > 0.02;) {
    const Vec2 next = place + rotate({0.05, 0.0}, wrap_angle(turn * exact::kPi / 16.0));
    const double there = nav.distance(episode.goal, next);
    const bool better = there < left - 0.01;
    turn = better ? 0 : turn + 1;
    if (!better) continue;
    place = next;
    left = there;
  }
  return place;
}

// Compares the silhouettes of what is seen well from a place with pictures of each thing alone.
void compare_silhouettes(const scene::Scene& scene, const CameraSpec& camera, const Pose2D& base,
                         std::span<const std::int16_t> ids, Counts& counts) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (std::ranges::count(ids, id_of(i)) < task::kGoalPixels) continue;
    scene::Scene alone = scene;
    alone.plan.clear();
    alone.build_walls();
    alone.min = scene.min;
    alone.max = scene.max;
    alone.objects = {scene.objects[i]};
    const auto shown = std::ranges::count(Camera(alone, camera).look(base), id_of(0));
    const std::vector<scene::Solid> solids = alone.solids();
    const task::Eye eye{base * camera.base_from_camera, camera.mount_height};
    const int counted = task::visible_pixels(camera.intrinsics(), eye, solids, {});
    ++counts.silhouettes;
    // a ray along an edge may be on either side of it
    counts.silhouettes_off += std::abs(shown - counted) > 2 + counted / 1000 ? 1 : 0;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 4 ? argv[1] : "");
  const auto count = parse_number(argc == 4 ? argv[3] : "");
  if (!seed || !count) {
    std::fputs("usage: verify_object_nav SEED SCENE COUNT\n", stderr);
    return 2;
  }
  const std::string name = argv[2];
  const RobotProfile robot = load_profile("3we_standard_v2");
  const double difficulty = static_cast<double>(*seed % 101) / 100.0;
  const auto scene = std::make_shared<const scene::Scene>(
      name == "generated" ? scene::generate(*seed, {.difficulty = difficulty}) : scene::Scene::load(name));
  const task::ObjectNav nav(std::make_shared<const scene::SceneTables>(scene, robot.body.footprint, robot.body.height),
                            robot);
  Camera camera(*scene, *robot.camera);

  Counts counts;
  for (std::uint32_t i = 0; i < *count; ++i) {
    const task::ObjectNavEpisode episode = nav.sample(*seed, i);
    const std::string_view category = task::kObjectGoals[episode.goal];
    counts.seen_at_start += most_pixels(*scene, category, camera.look(episode.start)) >= task::kGoalPixels ? 1 : 0;

    const Vec2 place = end_of_path(nav, episode);
    for (int k = 0; k < kHeadings; ++k) {
      const Pose2D pose{place.x, place.y, wrap_angle(2.0 * exact::kPi * k / kHeadings)};
      if (!nav.is_success(episode.goal, pose, [&] { return camera.look(pose); })) continue;
      ++counts.right_at_end;
      compare_silhouettes(*scene, *robot.camera, pose, camera.look(pose), counts);
      break;
    }
  }
  std::printf("episodes %llu\nseen_at_start %d\nright_at_end %d\nsilhouettes %d\nsilhouettes_off %d\n",
              static_cast<unsigned long long>(*count), counts.seen_at_start, counts.right_at_end, counts.silhouettes,
              counts.silhouettes_off);
}
