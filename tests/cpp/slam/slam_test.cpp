// Mapping on its own: drives through drawn places with the scanners and odometers of old robots.
#include "threewe/slam/slam.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/bounds.hpp"
#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/tour.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

using testing::building;
using testing::Fan;
using testing::look;
using testing::tiny_range;
using testing::TinyWall;
using testing::Tour;
using testing::tour;

TEST_CASE("scans of any field of view find the way that odometry loses") {
  const std::vector<Fan> fans = {{180, -0.5 * exact::kPi, exact::kPi / 180.0},
                                 {181, -0.5 * exact::kPi, exact::kPi / 180.0},
                                 {361, -0.5 * exact::kPi, exact::kPi / 360.0},
                                 {360, -exact::kPi, exact::kPi / 180.0}};
  for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
    for (const Fan& fan : fans) {
      CAPTURE(seed);
      CAPTURE(fan.beams);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      const Tour way = tour(draw, 30.0);
      const Pose2D base_from_lidar{draw(-0.1, 0.3), draw(-0.1, 0.1), draw(-0.2, 0.2)};
      Slam slam({.base_from_lidar = base_from_lidar});
      double worst = 0.0;
      double worst_odometry = 0.0;
      for (std::size_t i = 0; i < way.truth.size(); ++i) {
        const LaserScan scan = look(walls, way.truth[i] * base_from_lidar, fan, draw);
        const Pose2D found = slam.add(from_seconds(static_cast<double>(i)), scan, way.odometry[i]);
        const Pose2D reckoned = inverse(way.odometry[0]) * way.odometry[i];
        worst = std::max(worst, distance(found.position(), way.truth[i].position()));
        worst_odometry = std::max(worst_odometry, distance(reckoned.position(), way.truth[i].position()));
      }
      CHECK(worst < 0.08);
      CHECK(worst < 0.5 * worst_odometry);
    }
  }
}

TEST_CASE("scans may come at any rate") {
  for (const double stride : {0.02, 0.07, 0.2, 0.8}) {
    for (std::uint64_t seed = 0; seed < cases(4); ++seed) {
      CAPTURE(stride);
      CAPTURE(seed);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      const Tour way = tour(draw, 30.0, stride);
      Slam slam;
      double worst = 0.0;
      for (std::size_t i = 0; i < way.truth.size(); ++i) {
        const Pose2D found =
            slam.add(from_seconds(static_cast<double>(i)), look(walls, way.truth[i], {}, draw), way.odometry[i]);
        worst = std::max(worst, distance(found.position(), way.truth[i].position()));
      }
      CHECK(worst < 0.1);
    }
  }
}

TEST_CASE("far walls, which few beams hit, tell the heading that odometry does not") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::vector<TinyWall> walls;
    testing::add_box(walls, {-14, -15}, {17, 14});  // a hall
    for (const Vec2 corner : {Vec2{-8, -8}, Vec2{8, -9}, Vec2{9, 7}})
      testing::add_box(walls, corner, corner + Vec2{1, 1});
    Tour way{{{-6, 0, 0}}, {{}}};
    for (int i = 1; i < 9; ++i) {
      way.truth.push_back(integrate(way.truth.back(), {1.5, 0.0, 0.0}, 1.0));
      way.odometry.push_back(integrate(way.odometry.back(), {1.5, 0.0, draw(-0.25, 0.25)}, 1.0));
    }
    Slam slam({.range_max = 80.0});
    for (std::size_t i = 0; i < way.truth.size(); ++i) {
      slam.add(from_seconds(static_cast<double>(i)), look(walls, way.truth[i], {}, draw), way.odometry[i]);
    }
    for (const StampedPose& pose : slam.trajectory()) CHECK(std::fabs(pose.map_from_base.theta) < 0.01);
  }
}

// What Slam makes of a tour, seen by a lidar that sees no farther than `range_max`.
Slam mapped(const std::vector<TinyWall>& walls, const Tour& way, double range_max, Draw& draw) {
  Slam slam({.range_max = range_max});
  for (std::size_t i = 0; i < way.truth.size(); ++i) {
    const auto stamp = from_seconds(static_cast<double>(i));
    const Pose2D found = slam.add(stamp, look(walls, way.truth[i], {}, draw), way.odometry[i]);
    CHECK(found == slam.trajectory().back().map_from_base);
  }
  return slam;
}

TEST_CASE("who goes round and round knows where it is, and what it recognised is the same place") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    for (const double range_max : {30.0, 8.0}) {
      CAPTURE(seed);
      CAPTURE(range_max);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      const Tour way = tour(draw, 150.0);
      const Slam slam = mapped(walls, way, range_max, draw);
      double worst = 0.0;
      const std::vector<StampedPose> poses = slam.trajectory();
      for (std::size_t i = 0; i < poses.size(); ++i) {
        worst = std::max(worst, distance(poses[i].map_from_base.position(), way.truth[i].position()));
      }
      CHECK(worst < 0.1);

      const std::vector<LoopClosure> closures = slam.closures();
      CHECK(closures.size() >= 10);
      for (const LoopClosure& c : closures) {
        CHECK(c.earlier < c.later);
        const auto truth_at = [&](Time t) { return way.truth[static_cast<std::size_t>(t / 1s)]; };
        const Pose2D off = inverse(inverse(truth_at(c.earlier)) * truth_at(c.later)) * c.earlier_from_later;
        CHECK(norm(off.position()) < 0.1);
        CHECK(std::fabs(off.theta) < 0.03);
      }
    }
  }
}

std::filesystem::path temporary(std::string_view name) { return std::filesystem::temp_directory_path() / name; }

std::string text_of(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

TEST_CASE("a map that is kept is the same map, to the bit") {
  for (std::uint64_t seed = 0; seed < cases(4); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Slam slam = mapped(building(draw), tour(draw, 60.0), 30.0, draw);
    const auto path = temporary("threewe_slam_test_kept.map");
    slam.save(path);
    const Slam again = Slam::load(path);
    CHECK(again.map() == slam.map());
    CHECK(again.trajectory() == slam.trajectory());
    CHECK(again.closures() == slam.closures());
    CHECK(again.closures().size() > 2);
    const std::string text = text_of(path);
    again.save(path);
    CHECK(text_of(path) == text);
    std::filesystem::remove(path);
  }
}

TEST_CASE("a robot goes on with a map that was kept, though it starts where nobody measured it") {
  for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<TinyWall> walls = building(draw);
    const auto path = temporary("threewe_slam_test_continued.map");
    mapped(walls, tour(draw, 40.0), 30.0, draw).save(path);

    // another day, other odometry; it stands somewhere on the way, and is told about where
    const Tour way = tour(draw, 60.0);
    constexpr std::size_t kFirst = 13;
    const Pose2D start = way.truth[kFirst];
    const Pose2D told{start.x + draw(-0.4, 0.4), start.y + draw(-0.4, 0.4), start.theta + draw(-0.15, 0.15)};
    Slam slam = Slam::load(path, told);
    const std::size_t before = slam.trajectory().size();
    for (std::size_t i = kFirst; i < way.truth.size(); ++i) {
      slam.add(from_seconds(1000.0 + static_cast<double>(i)), look(walls, way.truth[i], {}, draw), way.odometry[i]);
    }
    const std::vector<StampedPose> poses = slam.trajectory();
    REQUIRE(poses.size() == before + way.truth.size() - kFirst);
    for (std::size_t i = kFirst; i < way.truth.size(); ++i) {
      CHECK(distance(poses[before + i - kFirst].map_from_base.position(), way.truth[i].position()) < 0.1);
    }
    std::filesystem::remove(path);
  }
}

TEST_CASE("a file that is no map is one clear error, with file and line") {
  Draw draw(1);
  const auto path = temporary("threewe_slam_test_broken.map");
  mapped(building(draw), tour(draw, 12.0), 30.0, draw).save(path);
  const std::string good = text_of(path);
  const auto error = [&](const std::string& text) -> std::string {
    std::ofstream(path, std::ios::binary) << text;
    try {
      Slam::load(path);
    } catch (const ConfigError& e) {
      const std::string what = e.what();
      CHECK(what.starts_with(path.string() + ":"));
      return what.substr(path.string().size() + 1);
    }
    return "nothing";
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  CHECK(error(good) == "nothing");
  CHECK(error("") == "1: this is no map that Slam.save wrote: the first line must be 'threewe slam 1'");
  CHECK(error(changed("slam 1", "slam 2")) ==
        "1: this is no map that Slam.save wrote: the first line must be 'threewe slam 1'");
  CHECK(error(good.substr(0, good.size() - 4)).ends_with(": the file was cut off: the last line must be 'end'"));
  CHECK(error(changed("\nmap 0.05", "\nmap 5")) == "10: resolution must lie in [0.02, 0.2] m, got 5");
  CHECK(error(changed("\nmap 0.05", "\nmap x")) == "10: resolution must be a finite number, got 'x'");
  CHECK(error(changed("\nmap 0.05", "\nmap")) == "10: a line 'map' ends before resolution");
  CHECK(error(changed("\nmap 0.05", "\nmap 0.05 1")) == "10: a line 'map' has more numbers than it should: ' 1'");
  CHECK(error(changed("\nlidar 0 ", "\nlidar 1e300 ")) ==
        "9: base_from_lidar must lie in [-1000000, 1000000], got 1e+300");
  CHECK(error(changed("\nlidar 0 0 0 30 ", "\nlidar 0 0 0 30 9 ")) == "9: range_bias must lie in [-1, 1], got 9");
  CHECK(error(changed("\nkeyframe", "\nframe")) ==
        "12: 'frame' is none of lidar, map, odometry, keyframe, scan, step, constraint, end");
  CHECK(error(changed("\nkeyframe", "\nstep 0 0 0 0\nkeyframe")) == "12: a line 'step' before the first keyframe");
  CHECK(error("threewe slam 1\nend\n") == "2: a map has one keyframe and one step at least");
  CHECK(error(changed("\nconstraint 0 1 ", "\nconstraint 0 9999 "))
            .find(": a keyframe must be a whole number from 0 to") != std::string::npos);
  CHECK(error(changed("\nconstraint 0 1 ", "\nconstraint 0 0 ")).find(": pose graph, constraint 0: it joins") !=
        std::string::npos);
  std::filesystem::remove(path);
  CHECK_THROWS_WITH_AS(Slam::load(path), (path.string() + ": cannot be read; a map is saved by Slam.save").c_str(),
                       ConfigError);
  CHECK_THROWS_WITH_AS(Slam().save(path), "a map without any scan cannot be saved: add one first", ContractError);

  // any piece that is lost or turned into another character is noticed or does no harm
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw random(seed);
    std::string text = good;
    const auto at = static_cast<std::size_t>(random.whole(0, static_cast<int>(text.size()) - 2));
    if (seed % 2 == 0) {
      text.resize(at);
      CHECK(error(text) != "nothing");
    } else {
      text[at] = static_cast<char>(random.whole(32, 126));
      error(text);
    }
  }
  std::filesystem::remove(path);
}

TEST_CASE("the trajectory has every scan, and the map shows the walls where they are") {
  Draw draw(3);
  const std::vector<TinyWall> walls = building(draw);
  const Tour way = tour(draw, 30.0);
  Slam slam;
  std::vector<Pose2D> returned;
  for (std::size_t i = 0; i < way.truth.size(); ++i) {
    const auto time = from_seconds(2.0 + 0.5 * static_cast<double>(i));
    returned.push_back(slam.add(time, look(walls, way.truth[i], {}, draw), way.odometry[i]));
  }
  const std::vector<StampedPose> poses = slam.trajectory();
  REQUIRE(poses.size() == returned.size());
  CHECK(poses.front().map_from_base == Pose2D{});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(poses[i].stamp == from_seconds(2.0 + 0.5 * static_cast<double>(i)));
    CHECK(distance(poses[i].map_from_base.position(), returned[i].position()) < 0.05);
  }

  const map::OccupancyGrid map = slam.map();
  int occupied = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.at({x, y}) < map::OccupancyGrid::kOccupiedThreshold) continue;
      double nearest = 1e9;
      for (const TinyWall& w : walls) {
        nearest = std::min(nearest, distance_to_segment(map.center({x, y}), w.a, w.b));
      }
      CHECK(nearest < 0.15);
      ++occupied;
    }
  }
  CHECK(occupied > 200);
  CHECK(map.at(map.cell({5.0, 0.0})) <= map::OccupancyGrid::kFreeThreshold);
}

TEST_CASE("a scan that is measured over time is straightened by the odometry") {
  Draw draw(5);
  const std::vector<TinyWall> walls = building(draw);
  Slam slam;
  Pose2D truth;
  double worst = 0.0;
  for (int i = 0; i < 150; ++i) {
    const Velocity v{0.4, 0.0, 1.2 * exact::sin(0.15 * i)};
    LaserScan scan{-exact::kPi, exact::kPi / 180.0, 0.1 / 360.0, 0.0, 80.0, {}};
    for (int beam = 0; beam < 360; ++beam) {
      const Pose2D here = integrate(truth, v, beam * scan.time_increment);
      scan.ranges.push_back(static_cast<float>(
          tiny_range(walls, here.position(), here.theta - exact::kPi + beam * exact::kPi / 180.0, 80.0)));
    }
    const Pose2D found = slam.add(from_seconds(0.1 * i), scan, truth);
    worst = std::max(worst, distance(found.position(), truth.position()));
    truth = integrate(truth, v, 0.1);
  }
  CHECK(worst < 0.05);
}

TEST_CASE("the same input gives the same bits") {
  const auto run = [] {
    Draw draw(9);
    const std::vector<TinyWall> walls = building(draw);
    const Tour way = tour(draw, 60.0);
    Slam slam;
    Pose2D last;
    for (std::size_t i = 0; i < way.truth.size(); ++i) {
      last = slam.add(from_seconds(static_cast<double>(i)), look(walls, way.truth[i], {}, draw), way.odometry[i]);
    }
    return std::tuple(last, slam.map(), slam.trajectory(), slam.closures());
  };
  CHECK(run() == run());
}

TEST_CASE("wrong input is one clear error, and changes nothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const LaserScan good{-1.5, 0.01, 0.0, 0.0, 80.0, std::vector<float>(300, 2.0F)};
  Slam slam;
  slam.add(1s, good, {});
  const auto error = [&](Time stamp, const LaserScan& scan, const Pose2D& odometry) -> std::string {
    try {
      slam.add(stamp, scan, odometry);
    } catch (const ContractError& e) {
      return e.what();
    }
    return "nothing";
  };

  CHECK(error(2s, good, {nan, 0, 0}) == "odometry must be finite and within 1000 km of the origin, got (nan, 0)");
  CHECK(error(1s, good, {}) == "time must go on from scan to scan: 1.000000 s after 1.000000 s");
  LaserScan bad = good;
  bad.ranges[7] = std::numeric_limits<float>::quiet_NaN();
  CHECK(error(2s, bad, {}) == "range 7 of a scan is nan: no return is range_max, invalid is 0");
  bad = good;
  bad.ranges.pop_back();
  CHECK(error(2s, bad, {}) == "a scan of 299 ranges after scans of 300: begin a new Slam for another lidar");
  bad = good;
  bad.angle_increment = 0.0;
  CHECK(error(2s, bad, {}) ==
        "a scan's angles must go up and stay within +-100000 rad, got angle_min -1.5, angle_increment 0");
  bad = good;
  bad.range_max = 0.0;
  CHECK(error(2s, bad, {}) == "a scan needs 0 <= range_min < range_max <= 1e+06, got 0 and 0");
  CHECK(slam.trajectory().size() == 1);
  CHECK_THROWS_WITH_AS(Slam({.resolution = 0.0}), "resolution must lie in [0.02, 0.2] m, got 0", ContractError);
  CHECK_THROWS_WITH_AS(Slam({.base_from_lidar = {0, nan, 0}}),
                       "base_from_lidar must be finite and within 1000 km of the origin, got (0, nan)", ContractError);
}

TEST_CASE("numbers that no map holds are refused, the largest that are not do no harm") {
  const LaserScan good{-1.5, 0.01, 0.0, 0.0, 80.0, std::vector<float>(300, 2.0F)};
  const auto refused = [](const LaserScan& scan, const Pose2D& odometry, const Pose2D& mount) {
    Slam slam({.base_from_lidar = mount});
    slam.add(1s, scan, odometry);
  };
  for (const double huge : {1.1e6, 1e9, 1e18, 1e300, std::numeric_limits<double>::infinity()}) {
    for (const double far : {huge, -huge}) {
      CAPTURE(far);
      CHECK_THROWS_AS(refused(good, {far, 0, 0}, {}), ContractError);
      CHECK_THROWS_AS(refused(good, {0, far, 0}, {}), ContractError);
      CHECK_THROWS_AS(refused(good, {0, 0, far}, {}), ContractError);
      CHECK_THROWS_AS(refused(good, {}, {far, 0, 0}), ContractError);
      CHECK_THROWS_AS(refused(good, {}, {0, 0, far}), ContractError);
      for (double LaserScan::* field :
           {&LaserScan::angle_min, &LaserScan::angle_increment, &LaserScan::time_increment, &LaserScan::range_max}) {
        LaserScan bad = good;
        bad.*field = far;
        CHECK_THROWS_AS(refused(bad, {}, {}), ContractError);
      }
    }
  }
  LaserScan many = good;
  many.ranges.assign(kMaxBeams + 1, 2.0F);
  CHECK_THROWS_AS(refused(many, {}, {}), ContractError);

  // odometry that jumps from one end of the world to the other, a lidar far away from its robot
  Slam slam({.base_from_lidar = {kMaxCoordinate, -kMaxCoordinate, kMaxAngle}});
  for (int i = 1; i < 6; ++i) {
    const double far = i % 2 == 0 ? -kMaxCoordinate : kMaxCoordinate;
    LaserScan scan = good;
    scan.time_increment = far < 0.0 ? 0.03 : -0.03;
    slam.add(Time(i), scan, {far, -far, far / 10.0});
  }
  CHECK(slam.trajectory().size() == 5);
  CHECK(slam.map().data.size() <= 4096U * 4096U);
}

}  // namespace
}  // namespace threewe::slam
