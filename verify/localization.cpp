// A robot in a map that another drew: does it find itself, and does it notice when somebody carries it away?
// `map SCENE SEED FILE` explores a scene and saves the map; `truth SCENE SEED FILE` does so with a mind that is told
// where it is; `find SCENE SEED FILE` puts a robot somewhere into a map.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/LU>

#include "number.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/map/ros_map.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/scene.hpp"

namespace {

using namespace threewe;

constexpr double kRight = 0.3;       // [m] a claim farther off is false
constexpr double kPatience = 10.0;   // [s] to find itself
constexpr double kKidnapped = 30.0;  // [s] to find itself again
constexpr double kDrive = 20.0;      // [s] of a drive before it is carried away

void draw_map(const std::string& scene, std::uint64_t seed, const std::string& file, const std::string& localization) {
  Robot robot({.scene = scene, .seed = seed, .autonomy = autonomy_with(localization)});
  const ExploreResult result = robot.wait(robot.explore(600.0));
  robot.save_map(file);
  std::printf("explored %s %.0f %.1f\n", std::string(to_string(result.reason)).c_str(), result.duration,
              result.explored_area);
}

// What a robot claims, tick by tick. The maps were begun at the scene's own start pose, so that the frames agree.
class Claims {
 public:
  explicit Claims(Robot& robot) : robot_(robot) {
    robot.runtime().observe([this](const TickView& tick) { look(tick); });
  }

  void look(const TickView& tick) {
    const Pose2D truth = robot_.simulation()->true_pose();
    const Pose2D off = inverse(truth) * tick.pose.map_from_base();
    error = norm(off.position());
    heading_error = std::fabs(off.theta);
    if (tick.pose.lost()) {
      ++lost;
      was_lost = true;
      return;
    }
    if (error > kRight) {
      if (was_lost) ++wrong;
      return;
    }
    ++right;
    worst = std::max(worst, error);
    if (carried) return;
    ++kept;
    doubted += tick.pose.state == slam::LocalizationState::doubting ? 1 : 0;
    if (++looked_ % 25 != 0) return;
    // normalised estimation error squared, about 3 where the covariance is honest
    const Pose2D believed = tick.pose.map_from_base();
    const Eigen::Vector3d e(believed.x - truth.x, believed.y - truth.y, wrap_angle(believed.theta - truth.theta));
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> covariance(tick.pose.covariance.data());
    nees += e.dot(covariance.inverse() * e);
    ++counted;
  }

  bool is_right() const { return !robot_.lost() && error <= kRight; }

  double error = 0.0;
  double heading_error = 0.0;
  bool was_lost = true;  // claims count
  bool carried = false;  // covariances do not, for nobody told the robot
  int lost = 0;          // ticks
  int wrong = 0;
  int right = 0;
  int kept = 0;     // of these, before it was carried away ...
  int doubted = 0;  // ... and of these in doubt
  double worst = 0.0;
  double nees = 0.0;
  int counted = 0;

 private:
  Robot& robot_;
  int looked_ = 0;
};

// Waits until something holds; for how long [s], or -1.
double wait_until(Robot& robot, double limit, const std::function<bool()>& holds) {
  const int ticks = static_cast<int>(50.0 * limit);
  for (int tick = 0; tick <= ticks; ++tick) {
    if (holds()) return 0.02 * tick;
    robot.sleep(0.02);
  }
  return -1.0;
}

// A pose in the explored part of a map: the first one of a seed's.
std::optional<Pose2D> place_in(const map::OccupancyGrid& grid, Simulation& simulation, std::uint64_t seed) {
  constexpr double kAround = 1.0;  // [m]
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Pose2D pose = simulation.sample_free_pose(1000 * seed + i);
    bool known = true;
    for (int way = 0; way < 32; ++way) {
      const Vec2 around = rotate({kAround, 0.0}, 0.196 * way);
      known = known && grid.at(grid.cell(pose.position() + around)) != map::OccupancyGrid::kUnknown;
    }
    if (known) return pose;
  }
  return {};
}

void find(const std::string& scene, std::uint64_t seed, const std::string& file) {
  const auto grid = std::make_shared<const map::OccupancyGrid>(map::load_ros_map(file));
  std::optional<Pose2D> start, other, goal;
  {
    Robot scout({.scene = scene, .noise = NoiseLevel::ideal});
    start = place_in(*grid, *scout.simulation(), 3 * seed);
    other = place_in(*grid, *scout.simulation(), 3 * seed + 1);
    goal = place_in(*grid, *scout.simulation(), 3 * seed + 2);
  }
  if (!start || !other || !goal) return;

  Robot robot({.scene = scene, .seed = seed, .map = grid, .start_pose = start});
  Claims claims(robot);
  const double found = wait_until(robot, kPatience, [&] { return !robot.lost(); });
  std::printf("found %.2f\nfound_error %.4f\nfound_heading %.4f\n", found, claims.error, claims.heading_error);

  const MotionHandle drive = robot.move_to(goal->x, goal->y);
  (void)wait_until(robot, kDrive, [&] { return drive->done(); });
  std::printf("drive %s\n", drive->done() ? std::string(to_string(drive->result().reason)).c_str() : "running");
  const int wrong_before = claims.wrong;
  const bool knew = claims.is_right();
  std::printf("wrong %d\nknew %d\nworst %.4f\nkept %d\ndoubted %d\n", wrong_before, knew ? 1 : 0, claims.worst,
              claims.kept, claims.doubted);

  // carried away
  try {
    robot.simulation()->teleport(*other);
  } catch (const ThreeweError& error) {
    std::printf("not_carried %s\n", error.what());
    return;
  }
  robot.stop();
  claims.was_lost = false;
  claims.carried = true;
  robot.sleep(0.02);
  double noticed = -1.0;
  const double recovered = wait_until(robot, kKidnapped, [&, t = 0.0]() mutable {
    t += 0.02;
    if (noticed < 0.0 && (robot.lost() || claims.is_right())) noticed = t;
    return claims.is_right();
  });
  robot.sleep(5.0);
  std::printf("noticed %.2f\nrecovered %.2f\nwrong_after %d\nright_at_last %d\nnees %.3f %d\n", noticed, recovered,
              claims.wrong - wrong_before, claims.is_right() ? 1 : 0, claims.nees, claims.counted);
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = threewe::parse_number(argc == 5 ? argv[3] : "");
  const std::string_view what = argc == 5 ? argv[1] : "";
  if (!seed || (what != "map" && what != "truth" && what != "find")) {
    std::fputs("usage: verify_localization (map | truth | find) SCENE SEED FILE\n", stderr);
    return 2;
  }
  if (what != "find") {
    draw_map(argv[2], *seed, argv[4], what == "map" ? "slam" : "truth");
  } else {
    find(argv[2], *seed, argv[4]);
  }
  return 0;
}
