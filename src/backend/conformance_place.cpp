// Whether a simulated robot is at its start pose, and where its truth says, by what the lidar sees there.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "backend/conformance_bench.hpp"
#include "core/exact.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::conformance {

namespace {

constexpr double kStandsThere = 0.02;  // [m] and [rad] that a robot may be off from where it was put

const scene::TruthView& truth_of(Bench& bench) {
  const scene::TruthView* truth = bench.truth();
  if (truth == nullptr) throw NotApplicable("the world is not simulated: it has no truth");
  return *truth;
}

bool has_lidar(Bench& bench) { return bench.has(SensorType::lidar) && bench.profile().lidar.has_value(); }

/// The share of a scan's beams that end where those of a perfect lidar would, were the robot at `pose` in the scene;
/// empty where too few hit anything.
std::optional<double> share_explained(Bench& bench, const LaserScan& scan, const Pose2D& pose) {
  const scene::TruthView& truth = truth_of(bench);
  const LidarSpec& spec = *bench.profile().lidar;
  const Pose2D lidar = pose * spec.base_from_lidar;
  int hit = 0;
  int explained = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); i += 2) {
    if (!hits_something(scan, i)) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const double expected = truth.range({lidar.x, lidar.y, lidar.theta + angle}, spec.height);
    const double tolerance = 0.06 + 0.03 * expected;
    ++hit;
    explained += std::abs(static_cast<double>(scan.ranges[i]) - expected) < tolerance ? 1 : 0;
  }
  if (hit < 20) return std::nullopt;
  return static_cast<double>(explained) / hit;
}

/// The largest share that a scan would have whose beams come clockwise, or are counted from another side.
double share_misread(Bench& bench, const LaserScan& scan, const Pose2D& pose) {
  std::vector<LaserScan> misread;
  LaserScan turned = scan;
  for (const double quarters : {1.0, 2.0, 3.0}) {
    turned.angle_min = scan.angle_min + quarters * 0.5 * exact::kPi;
    misread.push_back(turned);
  }
  turned.angle_min = -scan.angle_min;
  turned.angle_increment = -scan.angle_increment;
  misread.push_back(turned);
  double best = 0.0;
  for (const LaserScan& other : misread) best = std::max(best, share_explained(bench, other, pose).value_or(0.0));
  return best;
}

/// A way to misplace a robot in its scene.
struct Frame {
  const char* what = "";
  Pose2D pose;
};

/// Where the robot would be if `said`, its true pose, were meant in another frame.
std::vector<Frame> other_frames(const Pose2D& said, const Pose2D& start) {
  return {{"its pose counted from its start", start * said},
          {"its pose in a frame that begins at its start", inverse(start) * said},
          {"its start pose", start},
          {"the scene's origin", {}},
          {"its pose with y flipped", {said.x, -said.y, -said.theta}},
          {"its pose with the heading flipped", {said.x, said.y, -said.theta}},
          {"its pose with x and y swapped", {said.y, said.x, said.theta}}};
}

/// Fails where the lidar sees the scene from somewhere else than from `pose`; `whose` says what that pose is.
void expect_seen_from(Bench& bench, const Pose2D& pose, const Pose2D& start, const char* whose) {
  constexpr double kLeast = 0.3;  // of the beams: a simulator may lack furniture, or have more of it
  constexpr double kBetter = 0.2;
  if (!has_lidar(bench)) return;
  const LaserScan scan = bench.next_scan();
  const std::optional<double> share = share_explained(bench, scan, pose);
  if (!share) return;
  std::pair<double, const char*> best{0.0, ""};
  for (const Frame& other : other_frames(pose, start)) {
    best = std::max(best, std::pair(share_explained(bench, scan, other.pose).value_or(0.0), other.what),
                    [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  const double misread = share_misread(bench, scan, pose);
  applies_if(
      misread <= *share + kBetter || misread < best.first,
      "beams come in another order than the profile says: see lidar_sees_the_robot_drive_forward and ..._turn_left");
  expect(best.first <= *share + kBetter,
         "of the scan's beams {:.0f} % fit the scene as seen from {} ({:.2f}, {:.2f}, {:.2f}), but {:.0f} % as seen "
         "from {}: poses must be in the scene's frame",
         100.0 * *share, whose, pose.x, pose.y, pose.theta, 100.0 * best.first, best.second);
  expect(*share >= kLeast,
         "of the scan's beams {:.0f} % fit the scene as seen from {} ({:.2f}, {:.2f}, {:.2f}): is it in the scene's "
         "frame, and is `scene` the place that is simulated?",
         100.0 * *share, whose, pose.x, pose.y, pose.theta);
}

void truth_is_in_the_frame_of_the_scene(const Context& context) {
  Bench bench = context.connected();
  const scene::TruthView& truth = truth_of(bench);
  applies_if(has_lidar(bench), "the robot has no lidar that could tell where it is");
  expect_seen_from(bench, truth.true_pose(), truth.start_pose(), "the true pose");
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(0.8 / bench.turning()));
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(0.5 / bench.cruise()));
  expect_seen_from(bench, truth.true_pose(), truth.start_pose(), "the true pose");
}

/// Fails unless the robot stands at `pose`, by its truth and by what it sees there.
void expect_stands_at(Bench& bench, const Pose2D& pose, const char* how) {
  const scene::TruthView& truth = truth_of(bench);
  for (const auto& [whose, found] : {std::pair("start", truth.start_pose()), {"pose", truth.true_pose()}}) {
    const Pose2D off = inverse(pose) * found;
    expect(norm(off.position()) < kStandsThere && std::abs(off.theta) < kStandsThere,
           "{} at ({:.2f}, {:.2f}, {:.2f}) in the scene, the robot's true {} is ({:.2f}, {:.2f}, {:.2f})", how, pose.x,
           pose.y, pose.theta, whose, found.x, found.y, found.theta);
  }
  bench.drive({}, 200ms);
  const Pose2D odom = bench.odometry().pose;
  expect(norm(odom.position()) < kStandsThere && std::abs(odom.theta) < kStandsThere,
         "{} at ({:.2f}, {:.2f}, {:.2f}) in the scene, odometry begins at ({:.2f}, {:.2f}, {:.2f}), not at its origin",
         how, pose.x, pose.y, pose.theta, odom.x, odom.y, odom.theta);
  expect_seen_from(bench, pose, {}, "where it was put");
}

void the_robot_starts_at_the_commanded_pose(const Context& context) {
  Pose2D pose;
  {
    Bench bench = context.connected();
    pose = truth_of(bench).sample_free_pose(3);
  }
  WorldOptions options = context.options;
  options.poses = {pose};
  Bench bench(context.make(options));
  bench.port().connect();
  expect_stands_at(bench, pose, "made to start");
}

/// Without a truth, two resets must differ in what the lidar sees by what their poses differ.
void expect_moved_by_reset(Bench& bench) {
  const Pose2D moved{0.4, 0.2, 0.5};
  const auto seen_from = [&bench](const Pose2D& pose) {
    bench.world().reset({.seed = 7, .poses = {pose}});
    bench.forget();
    return hits(bench.next_scan(), bench.profile().lidar->base_from_lidar);
  };
  const std::vector<Vec2> before = seen_from({});
  const std::vector<Vec2> after = seen_from(moved);
  applies_if(std::min(before.size(), after.size()) >= 20, "fewer than 20 beams hit something here");
  const double as_told = misfit(before, after, moved);
  const double not_at_all = misfit(before, after, {});
  expect(as_told < not_at_all,
         "reset() to a pose 0.45 m and 0.5 rad from the one before: scans fit within {:.3f} m if the robot was put "
         "there, within {:.3f} m if reset() did not move it",
         as_told, not_at_all);
}

void reset_puts_the_robot_at_its_pose(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().can_reset, "the backend does not claim that it can be reset");
  if (bench.truth() == nullptr) {
    applies_if(has_lidar(bench), "the world has no truth, and the robot no lidar that could tell where it is");
    return expect_moved_by_reset(bench);
  }
  for (const std::uint64_t seed : {4U, 5U}) {
    const Pose2D pose = truth_of(bench).sample_free_pose(seed);
    bench.world().reset({.seed = seed, .poses = {pose}});
    bench.forget();
    expect_stands_at(bench, pose, "reset to start");
  }
}

constexpr Check kPlaceChecks[] = {
    {"the_robot_starts_at_the_commanded_pose", the_robot_starts_at_the_commanded_pose},
    {"reset_puts_the_robot_at_its_pose", reset_puts_the_robot_at_its_pose},
    {"truth_is_in_the_frame_of_the_scene", truth_is_in_the_frame_of_the_scene},
};

}  // namespace

std::span<const Check> place_checks() { return kPlaceChecks; }

}  // namespace threewe::backend::conformance
