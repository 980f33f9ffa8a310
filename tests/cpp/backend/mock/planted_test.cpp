// What strangers get wrong, planted in the embedded simulator: a check names each in words that lead to it.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "backend/small_room.hpp"
#include "backend/twins.hpp"
#include "threewe/backend/conformance.hpp"

namespace threewe::backend {
namespace {

using testing::Fault;

struct Planted {
  std::string bug;
  std::string check;
  std::string words;
  Fault fault;
};

void turn_beams(LaserScan& scan, std::ptrdiff_t quarters) {
  const auto quarter = static_cast<std::ptrdiff_t>(scan.ranges.size() / 4);
  std::rotate(scan.ranges.begin(), scan.ranges.begin() + quarters * quarter, scan.ranges.end());
}

void flip_rows(RGBDImage& image) {
  const auto row = static_cast<std::ptrdiff_t>(3 * image.intrinsics.width);
  for (auto top = image.color.begin(), bottom = image.color.end() - row; top < bottom; top += row, bottom -= row) {
    std::swap_ranges(top, top + row, bottom);
  }
}

void swap_red_and_blue(RGBDImage& image) {
  for (std::size_t i = 0; i < image.color.size(); i += 3) std::swap(image.color[i], image.color[i + 2]);
}

std::vector<Planted> planted() {
  using testing::each, testing::each_image, testing::late, testing::repeated, testing::replace_points;
  return {
      {"odometry 0.3 s late, against commands", "odometry_answers_the_command_in_time", "Is odometry late, yet stamped",
       late<Odometry>(300ms)},
      {"odometry 0.3 s late, against the gyro", "imu_and_odometry_are_of_one_time", "Is odometry late",
       late<Odometry>(300ms)},
      {"the IMU 0.3 s late", "imu_and_odometry_are_of_one_time", "Is the IMU late", late<IMUData>(300ms)},
      {"scans 0.3 s late", "lidar_and_odometry_are_of_one_time", "Is the lidar late", late<LaserScan>(300ms)},
      {"each scan twice",
       "each_sample_is_new",
       "delivered again under a new stamp",
       {.samples = each<LaserScan>(repeated<LaserScan>())}},
      {"odometry twice", "each_sample_is_new", "sensor 'odometry'", {.samples = each<Odometry>(repeated<Odometry>())}},
      {"a lidar that sees a post of its robot",
       "the_lidar_does_not_hit_the_robot",
       "Does the lidar see its own robot?",
       {.samples = each<LaserScan>([](LaserScan& scan) { std::fill_n(scan.ranges.begin(), 9, 0.13F); })}},
      {"a lidar that sees its robot all around",
       "the_lidar_does_not_hit_the_robot",
       "360 of 360 beams end at the robot",
       {.samples = each<LaserScan>([](LaserScan& scan) { std::ranges::fill(scan.ranges, 0.09F); })}},
      {"a lidar mount with the wrong sign",
       "the_lidar_is_where_the_profile_says",
       "Is a sign wrong",
       {.samples = each<LaserScan>(
            [](LaserScan& scan) { replace_points(scan, [](Vec2 p) { return p + Vec2{0.08, 0.0}; }); })}},
      {"a lidar mounted to the side",
       "the_lidar_is_where_the_profile_says",
       "by scans before and after a turn",
       {.samples =
            each<LaserScan>([](LaserScan& scan) { replace_points(scan, [](Vec2 p) { return p + Vec2{0.0, 0.1}; }); })}},
      {"beams turned by 90 degrees",
       "lidar_sees_the_robot_drive_forward",
       "are they turned by",
       {.samples = each<LaserScan>([](LaserScan& scan) { turn_beams(scan, 1); })}},
      {"beams turned by -90 degrees",
       "lidar_sees_the_robot_drive_forward",
       "are they turned by",
       {.samples = each<LaserScan>([](LaserScan& scan) { turn_beams(scan, 3); })}},
      {"beams clockwise",
       "lidar_sees_the_robot_turn_left",
       "do beams come clockwise",
       {.samples = each<LaserScan>([](LaserScan& scan) { std::ranges::reverse(scan.ranges); })}},
      {"a camera mount with the wrong sign",
       "depth_agrees_with_lidar",
       "from a mount with the other sign",
       {.samples = each_image([](RGBDImage& image) {
          for (float& depth : image.depth) depth += depth > 0.0F ? 0.21F : 0.0F;
        })}},
      {"a reset that ignores its pose",
       "reset_puts_the_robot_at_its_pose",
       "the robot's true start is",
       {.reset = [](World& world, const ResetOptions& options) { world.reset({.seed = options.seed, .poses = {}}); }}},
      {"a start pose that is not read",
       "the_robot_starts_at_the_commanded_pose",
       "made to start at",
       {.options = [](WorldOptions& options) { options.poses.clear(); }}},
      {"truth in another frame",
       "truth_is_in_the_frame_of_the_scene",
       "poses must be in the scene's frame",
       {.true_pose = [](Pose2D pose) { return Pose2D{pose.x + 1.0, pose.y - 1.0, pose.theta + 0.5}; }}},
      {"truth with y to the right",
       "truth_is_in_the_frame_of_the_scene",
       "as seen from its pose with y flipped",
       {.true_pose = [](Pose2D pose) { return Pose2D{pose.x, -pose.y, -pose.theta}; }}},
      {"red and blue exchanged",
       "images_are_blue_green_red",
       "with red and blue exchanged",
       {.samples = each_image(swap_red_and_blue)}},
      {"odometry with y to the right",
       "odometry_drives_where_it_heads",
       "y, or the heading, has the wrong sign",
       {.samples = each<Odometry>([](Odometry& o) { o.pose.y *= -1.0; })}},
      {"mirrored images",
       "images_turn_with_the_robot",
       "Are columns in reverse",
       {.samples = each_image(testing::mirror)}},
      {"images upside down", "images_show_what_is_there", "read upside down", {.samples = each_image(flip_rows)}},
      {"depth of a mirrored image",
       "depth_shows_what_is_there",
       "read left for right",
       {.samples = each_image(testing::mirror)}},
  };
}

TEST_CASE("planted bugs are named in words that lead to them") {
  const WorldOptions options = testing::in_small_room("3we_depth_v2");
  const WorldFactory mock = [](const WorldOptions& with) { return make_world("mock", with); };
  const std::vector<Planted> bugs = planted();
  CHECK(bugs.size() >= 22);
  for (const Planted& bug : bugs) {
    const CheckResult found = check_backend(testing::with_fault(mock, bug.fault), options, bug.check);
    CAPTURE(bug.bug);
    CHECK_MESSAGE(found.outcome == Outcome::failed, to_string(found.outcome));
    CHECK_MESSAGE(found.detail.find(bug.words) != std::string::npos, found.detail);
  }
}

}  // namespace
}  // namespace threewe::backend
