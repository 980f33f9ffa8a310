// The broken twin of every conformance check: a world that breaks one thing, which the check must catch.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "backend/faulty_world.hpp"
#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::testing {

/// Applies `change` to the data of one kind in what a poll gives.
template <typename Data, typename Change>
auto each(Change change) {
  return [change](std::vector<Sample>& samples, World&) mutable {
    for (Sample& sample : samples) {
      if (auto* data = std::get_if<Data>(&sample.data)) change(*data);
    }
  };
}

/// Applies `change` to every sample of what a poll gives.
template <typename Change>
auto every(Change change) {
  return [change](std::vector<Sample>& samples, World&) mutable {
    for (Sample& sample : samples) change(sample);
  };
}

/// Applies `change` to every image, when somebody looks at it.
template <typename Change>
auto each_image(Change change) {
  return each<Picture>([change](Picture& picture) {
    picture = Picture([honest = picture, change] {
      RGBDImage image = honest.image();
      change(image);
      return image;
    });
  });
}

/// Reports the odometry of a robot that also creeps forward at `speed` [m/s].
inline auto creep(double speed) {
  return [speed](std::vector<Sample>& samples, World& world) {
    for (Sample& sample : samples) {
      if (auto* odometry = std::get_if<Odometry>(&sample.data)) odometry->pose.x += speed * to_seconds(world.now());
    }
  };
}

/// Swaps the left and the right of an image.
inline void mirror(RGBDImage& image) {
  const auto width = static_cast<std::size_t>(image.intrinsics.width);
  const auto height = static_cast<std::size_t>(image.intrinsics.height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width / 2; ++x) {
      const std::size_t a = y * width + x;
      const std::size_t b = y * width + width - 1 - x;
      for (std::size_t c = 0; c < 3; ++c) std::swap(image.color[3 * a + c], image.color[3 * b + c]);
      if (!image.depth.empty()) std::swap(image.depth[a], image.depth[b]);
    }
  }
}

/// Delivers each `Data` as measured `delay` later than it was: what is late, yet stamped as it arrives.
template <typename Data>
Fault late(Duration delay) {
  return {.samples = [held = std::vector<Sample>(), delay](std::vector<Sample>& samples, World& world) mutable {
    std::erase_if(samples, [&held](const Sample& sample) {
      const bool is_late = std::holds_alternative<Data>(sample.data);
      if (is_late) held.push_back(sample);
      return is_late;
    });
    std::erase_if(held, [&](Sample sample) {
      sample.measured += delay;
      sample.received = world.now();
      const bool is_due = sample.measured <= world.now();
      if (is_due) samples.push_back(sample);
      return is_due;
    });
  }};
}

/// Delivers each other `Data` as what the one before held.
template <typename Data>
auto repeated() {
  return [last = Data(), n = 0](Data& data) mutable { ++n % 2 == 0 ? void(data = last) : void(last = data); };
}

/// What a lidar at `base_from_lidar` delivers that thinks that it is at `thought`: its points, moved by the difference.
template <typename Change>
void replace_points(LaserScan& scan, Change change) {
  std::vector<float> ranges(scan.ranges.size(), static_cast<float>(scan.range_max));
  const auto beams = static_cast<double>(ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (range <= 0.0 || range >= scan.range_max) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Vec2 point = change(range * Vec2{exact::cos(angle), exact::sin(angle)});
    const double turned = (exact::atan2(point.y, point.x) - scan.angle_min) / scan.angle_increment;
    const auto beam = static_cast<std::size_t>(std::lround(turned + beams)) % ranges.size();
    ranges[beam] = static_cast<float>(norm(point));
  }
  scan.ranges = std::move(ranges);
}

/// Commands that stay in force for ever.
inline Fault never_expiring() {
  return {.command = [](RobotPort& port, Velocity velocity, Time) { port.command(velocity, 1000000s); }};
}

/// For each check the worlds that it must fail.
inline std::multimap<std::string, Fault> twins() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
  return {
      // connection
      {"features_are_readable_before_connecting",
       {.features =
            [](Features&, bool connected) {
              if (!connected) throw ConnectionError("connect first");
            }}},
      {"features_are_readable_before_connecting",
       {.features =
            [](Features& f, bool connected) {
              if (!connected) f.sensors.clear();
            }}},
      {"features_do_not_change", {.features = [](Features& f, bool connected) { f.sensors[0].rate += connected; }}},
      {"features_do_not_change", {.features = [](Features& f, bool connected) { f.can_reset ^= connected; }}},
      {"features_match_the_profile",
       {.features =
            [](Features& f, bool) {
              f.kinematics = f.kinematics == Kinematics::holonomic ? Kinematics::differential : Kinematics::holonomic;
            }}},
      {"sensor_names_are_unique", {.features = [](Features& f, bool) { f.sensors[1].name = f.sensors[0].name; }}},
      {"sensor_names_are_unique", {.features = [](Features& f, bool) { f.sensors[1].name = ""; }}},
      {"sensor_rates_are_positive", {.features = [](Features& f, bool) { f.sensors[0].rate = 0.0; }}},
      {"sensor_rates_are_positive", {.features = [](Features& f, bool) { f.sensors[0].rate = kNan; }}},
      {"poll_before_connecting_is_refused", {.polls_unconnected = true}},
      {"poll_after_disconnecting_is_refused", {.polls_unconnected = true}},
      {"connecting_twice_does_nothing",
       {.connect =
            [connected = false](RobotPort& port) mutable {
              if (std::exchange(connected, true)) throw ConnectionError("connected already");
              port.connect();
            }}},
      {"disconnecting_twice_does_nothing",
       {.disconnect =
            [connected = true](RobotPort& port) mutable {
              if (!std::exchange(connected, false)) throw ConnectionError("not connected");
              port.disconnect();
            }}},
      {"connecting_again_works",
       {.connect =
            [count = 0](RobotPort& port) mutable {
              if (++count > 1) throw ConnectionError("busy");
              port.connect();
            }}},

      // time
      {"time_starts_at_zero", {.now = [](Time t) { return t + 5s; }}},
      {"advance_is_exact", {.advance = [](World& world, Time t) { world.advance_to((t + 999us) / 1ms * 1ms); }}},
      {"time_never_goes_back", {.now = [n = 0](Time t) mutable { return t - (++n % 50 == 0 ? 1s : 0s); }}},
      {"advance_to_now_does_nothing",
       {.advance = [](World& world, Time t) { world.advance_to(t <= world.now() ? t + 100ms : t); }}},
      {"time_waits_for_advance", {.samples = [](auto&, World& world) { world.advance_to(world.now() + 1ms); }}},
      {"command_returns_at_once", {.now = [n = 0](Time t) mutable { return t + (++n) * 100ms; }}},

      // samples
      {"every_sensor_delivers",
       {.samples = [](std::vector<Sample>& samples,
                      World&) { std::erase_if(samples, [](const Sample& sample) { return sample.sensor == 1; }); }}},
      {"samples_hold_their_sensors_data", {.samples = every([](Sample& sample) { sample.sensor ^= 1; })}},
      {"samples_hold_their_sensors_data", {.samples = every([](Sample& sample) { sample.sensor += 1; })}},
      {"second_poll_is_empty",
       {.samples =
            [last = std::vector<Sample>()](std::vector<Sample>& samples, World&) mutable {
              if (samples.empty()) samples = last;
              last = samples;
            }}},
      {"samples_arrive_in_order",
       {.samples = [](std::vector<Sample>& samples,
                      World&) { samples = std::vector<Sample>(samples.rbegin(), samples.rend()); }}},
      {"received_is_the_time_of_the_poll",
       {.samples = every([](Sample& sample) { sample.received = sample.measured - 1ms; })}},
      {"measured_before_received", {.samples = every([](Sample& sample) { sample.measured += 1s; })}},
      {"samples_are_recent", {.samples = every([](Sample& sample) { sample.measured -= 2s; })}},
      {"sequence_counts_from_zero", {.samples = every([](Sample& sample) { sample.sequence += 1; })}},
      {"sequence_counts_from_zero", {.samples = every([](Sample& sample) { sample.sequence -= sample.sequence % 2; })}},
      {"rates_are_as_listed", {.features = [](Features& f, bool) { f.sensors[0].rate *= 1.25; }}},
      {"rates_are_as_listed", {.samples = every([](Sample& sample) { sample.measured = sample.measured / 2; })}},

      // delays
      {"each_sample_is_new", {.samples = each<LaserScan>(repeated<LaserScan>())}},
      {"each_sample_is_new", {.samples = each<Odometry>(repeated<Odometry>())}},
      {"odometry_answers_the_command_in_time", late<Odometry>(300ms)},
      {"imu_and_odometry_are_of_one_time", late<IMUData>(300ms)},
      {"imu_and_odometry_are_of_one_time", late<Odometry>(300ms)},
      {"lidar_and_odometry_are_of_one_time", late<LaserScan>(300ms)},
      {"lidar_and_odometry_are_of_one_time", late<Odometry>(300ms)},

      // lidar
      {"scan_has_the_profiles_beams", {.samples = each<LaserScan>([](LaserScan& scan) { scan.ranges.pop_back(); })}},
      {"scan_limits_are_the_profiles", {.samples = each<LaserScan>([](LaserScan& scan) { scan.range_max *= 2.0; })}},
      {"scan_ranges_are_valid", {.samples = each<LaserScan>([](LaserScan& scan) { scan.ranges[7] = kNanF; })}},
      {"scan_ranges_are_valid", {.samples = each<LaserScan>([](LaserScan& scan) { scan.ranges[7] = -1.0F; })}},
      {"scan_ranges_are_valid",
       {.samples = each<LaserScan>([](LaserScan& scan) { scan.ranges[7] = std::numeric_limits<float>::infinity(); })}},
      {"scan_angles_cover_the_turn",
       {.samples = each<LaserScan>([](LaserScan& scan) { scan.angle_increment = -scan.angle_increment; })}},
      {"scan_angles_cover_the_turn",
       {.samples = each<LaserScan>([](LaserScan& scan) { scan.angle_increment *= 180.0 / exact::kPi; })}},
      {"scan_times_fit_the_turn", {.samples = each<LaserScan>([](LaserScan& scan) { scan.time_increment = 0.01; })}},
      {"scan_times_fit_the_turn", {.samples = every([](Sample& sample) {
                                     if (std::holds_alternative<LaserScan>(sample.data))
                                       sample.measured = sample.received + 1ns;
                                   })}},
      {"scan_turns_as_the_device_does", {.samples = each<LaserScan>([](LaserScan& scan) {
                                           scan.time_increment =
                                               scan.time_increment == 0.0 ? 1e-4 : -scan.time_increment;
                                         })}},
      {"lidar_sees_the_robot_drive_forward",
       {.samples = each<LaserScan>([](LaserScan& scan) {
          const auto half = static_cast<std::ptrdiff_t>(scan.ranges.size() / 2);  // front and back swapped
          std::rotate(scan.ranges.begin(), scan.ranges.begin() + half, scan.ranges.end());
        })}},
      {"lidar_sees_the_robot_drive_forward", {.samples = each<LaserScan>([](LaserScan& scan) {
                                                for (float& range : scan.ranges) range *= 0.5F;
                                              })}},
      {"lidar_sees_the_robot_turn_left", {.samples = each<LaserScan>([](LaserScan& scan) {
                                            std::reverse(scan.ranges.begin(), scan.ranges.end());  // clockwise
                                          })}},

      {"lidar_sees_the_robot_drive_forward", {.samples = each<LaserScan>([](LaserScan& scan) {
                                                const auto quarter =  // counted from the left
                                                    static_cast<std::ptrdiff_t>(scan.ranges.size() / 4);
                                                std::rotate(scan.ranges.begin(), scan.ranges.begin() + quarter,
                                                            scan.ranges.end());
                                              })}},
      {"the_lidar_does_not_hit_the_robot", {.samples = each<LaserScan>([](LaserScan& scan) {
                                              for (std::size_t i = 0; i < 9; ++i) scan.ranges[i] = 0.13F;  // a post
                                            })}},
      {"the_lidar_is_where_the_profile_says", {.samples = each<LaserScan>([](LaserScan& scan) {
                                                 replace_points(scan, [](Vec2 p) { return p + Vec2{0.08, 0.0}; });
                                               })}},

      // ultrasonics
      {"ultrasonics_are_mounted",
       {.features =
            [](Features& f, bool) {
              const auto echo = [](const SensorInfo& sensor) { return sensor.type == SensorType::ultrasonic; };
              std::ranges::find_if(f.sensors, echo)->name = "ultrasonic_rear";
            }}},
      {"sonar_limits_are_the_profiles", {.samples = each<RangeData>([](RangeData& echo) { echo.range_max = 5.0; })}},
      {"sonar_limits_are_the_profiles",
       {.samples = each<RangeData>([](RangeData& echo) { echo.field_of_view *= 180.0 / exact::kPi; })}},
      {"sonar_ranges_are_valid", {.samples = each<RangeData>([](RangeData& echo) { echo.range = kNan; })}},
      {"sonar_ranges_are_valid", {.samples = each<RangeData>([](RangeData& echo) { echo.range *= 1000.0; })}},
      {"one_ultrasonic_pings_at_a_time",  // all at the first one's time
       {.samples = every([](Sample& sample) {
          if (std::holds_alternative<RangeData>(sample.data)) sample.measured -= sample.measured % 240ms;
        })}},
      {"ultrasonics_measure_the_robot_drive_forward",
       {.samples = each<RangeData>([](RangeData& echo) { echo.range = std::min(echo.range, 1.0); })}},
      {"ultrasonics_measure_the_robot_drive_forward",  // half the way there and back
       {.samples = each<RangeData>([](RangeData& echo) { echo.range *= 0.5; })}},

      // camera
      {"images_have_the_profiles_size", {.samples = each_image([](RGBDImage& image) { --image.intrinsics.height; })}},
      {"images_have_the_profiles_size",  // grey
       {.samples = each_image([](RGBDImage& image) { image.color.resize(image.color.size() / 3); })}},
      {"image_intrinsics_are_the_profiles",  // as if the angle of view were the image's height
       {.samples = each_image([](RGBDImage& image) { image.intrinsics.fx *= 0.75; })}},
      {"image_intrinsics_are_the_profiles",
       {.samples = each_image([](RGBDImage& image) { image.intrinsics.cx = image.intrinsics.cy = 0.0; })}},
      {"images_follow_the_robot", {.samples = each<Picture>([first = Picture()](Picture& picture) mutable {
                                     if (!first.is_drawn()) first = Picture(picture.image());
                                     picture = first;
                                   })}},
      {"images_show_what_is_there",  // from the last row to the first
       {.samples = each_image([](RGBDImage& image) {
          const auto row = static_cast<std::ptrdiff_t>(3 * image.intrinsics.width);
          for (auto top = image.color.begin(), bottom = image.color.end() - row; top < bottom;
               top += row, bottom -= row) {
            std::swap_ranges(top, top + row, bottom);
          }
        })}},
      {"images_show_what_is_there",
       {.samples = each_image([](RGBDImage& image) { std::ranges::fill(image.color, std::uint8_t{128}); })}},
      {"images_show_what_is_there", {.samples = each_image(mirror)}},
      {"images_turn_with_the_robot", {.samples = each_image(mirror)}},
      {"depth_shows_what_is_there", {.samples = each_image(mirror)}},
      {"depth_shows_what_is_there",  // in decimetres
       {.samples = each_image([](RGBDImage& image) {
          for (float& depth : image.depth) depth *= 0.1F;
        })}},
      {"images_are_blue_green_red", {.samples = each_image([](RGBDImage& image) {
                                       for (std::size_t i = 0; i < image.color.size(); i += 3) {
                                         std::swap(image.color[i], image.color[i + 2]);
                                       }
                                     })}},
      {"depth_is_there_if_promised", {.samples = each_image([](RGBDImage& image) { image.depth.clear(); })}},
      {"depth_is_valid", {.samples = each_image([](RGBDImage& image) {
                            std::ranges::replace(image.depth, 0.0F, std::numeric_limits<float>::infinity());
                            image.depth[0] = kNanF;
                          })}},
      {"depth_is_valid",  // in millimetres
       {.samples = each_image([](RGBDImage& image) {
          for (float& depth : image.depth) depth *= 1000.0F;
        })}},
      {"depth_agrees_with_lidar",  // along each pixel's ray
       {.samples = each_image([](RGBDImage& image) {
          const CameraIntrinsics& camera = image.intrinsics;
          for (std::size_t i = 0; i < image.depth.size(); ++i) {
            const auto column = static_cast<double>(i % static_cast<std::size_t>(camera.width)) + 0.5;
            image.depth[i] *= static_cast<float>(norm({1.0, (camera.cx - column) / camera.fx}));
          }
        })}},

      {"depth_agrees_with_lidar",  // from behind the middle of the base
       {.samples = each_image([](RGBDImage& image) {
          for (float& depth : image.depth) depth += depth > 0.0F ? 0.21F : 0.0F;
        })}},

      // motion
      {"odometry_starts_at_the_origin", {.samples = each<Odometry>([](Odometry& o) { o.pose.x += 1.0; })}},
      {"a_metre_driven_is_a_metre_in_odometry", {.samples = each<Odometry>([](Odometry& o) { o.pose.x *= 0.5; })}},
      {"a_metre_driven_is_a_metre_in_odometry", {.samples = each<Odometry>([](Odometry& o) { o.pose.x *= -1.0; })}},
      {"odometry_turns_left", {.samples = each<Odometry>([](Odometry& o) { o.pose.theta *= -1.0; })}},
      {"odometry_turns_left", {.samples = each<Odometry>([](Odometry& o) { o.pose.theta *= 180.0 / exact::kPi; })}},
      {"heading_stays_within_pi", {.samples = each<Odometry>([](Odometry& o) {
                                     if (o.pose.theta < 0.0) o.pose.theta += 2.0 * exact::kPi;
                                   })}},
      {"odometry_velocity_is_in_the_body_frame", {.samples = each<Odometry>([](Odometry& o) {
                                                    const Vec2 in_odom =
                                                        rotate({o.velocity.vx, o.velocity.vy}, o.pose.theta);
                                                    o.velocity = {in_odom.x, in_odom.y, o.velocity.omega};
                                                  })}},
      {"odometry_velocity_fits_its_pose", {.samples = each<Odometry>([](Odometry& o) { o.velocity.vx *= 1.3; })}},
      {"odometry_drives_where_it_heads", {.samples = each<Odometry>([](Odometry& o) { o.pose.y *= -1.0; })}},
      {"sideways_is_left",
       {.command = [](RobotPort& port, Velocity v, Time until) { port.command({v.vx, -v.vy, v.omega}, until); }}},
      {"gyro_agrees_with_odometry", {.samples = each<IMUData>([](IMUData& imu) { imu.angular_velocity[2] *= -1.0; })}},
      {"gyro_agrees_with_odometry",
       {.samples = each<IMUData>([](IMUData& imu) { imu.angular_velocity[2] *= 180.0 / exact::kPi; })}},
      {"imu_at_rest_measures_gravity_alone",
       {.samples = each<IMUData>([](IMUData& imu) { imu.linear_acceleration[2] *= -1.0; })}},
      {"imu_at_rest_measures_gravity_alone",
       {.samples = each<IMUData>([](IMUData& imu) { imu.linear_acceleration[2] = 1.0; })}},
      {"imu_at_rest_measures_gravity_alone",
       {.samples = each<IMUData>([](IMUData& imu) { imu.angular_velocity[0] += 0.1; })}},
      {"battery_is_a_fraction_and_never_rises",
       {.samples = each<BatteryState>([](BatteryState& b) { b.charge *= 100.0; })}},
      {"battery_is_a_fraction_and_never_rises",
       {.samples = each<BatteryState>([](BatteryState& b) { b.charge = 1.0 - b.charge; })}},

      // commands
      {"commands_that_are_not_finite_are_refused",
       {.command = [](RobotPort& port, Velocity v,
                      Time until) { port.command(is_finite(v) ? v : Velocity{}, until); }}},
      {"sideways_is_refused",
       {.command = [](RobotPort& port, Velocity v, Time until) { port.command({v.vx, 0.0, v.omega}, until); }}},
      {"a_refused_command_changes_nothing",
       {.command =
            [last = Velocity{}](RobotPort& port, Velocity v, Time until) mutable {
              if (!is_finite(v)) port.command(last, until + 10s);  // the last that moved
              port.command(v, until);
              if (v != Velocity{}) last = v;
            }}},
      {"an_expired_command_stops_the_robot", never_expiring()},
      {"a_command_lasts_while_it_is_valid",
       {.command = [](RobotPort& port, Velocity v, Time until) { port.command(v, std::min(until, until - 700ms)); }}},
      {"zero_stops_the_robot",
       {.command =
            [](RobotPort& port, Velocity v, Time until) {
              if (v != Velocity{}) port.command(v, until + 10s);
            }}},
      {"a_stopped_robot_stands_still", {.samples = creep(0.01)}},
      {"a_robot_stands_still_until_commanded", {.samples = creep(0.01)}},
      {"hardware_limits_hold", {.samples = each<Odometry>([](Odometry& o) { o.pose.x *= 3.0; })}},
      {"hardware_limits_hold",
       {.samples = each<Odometry>([](Odometry& o) { o.pose.theta = wrap_angle(2.0 * o.pose.theta); })}},

      // repeating
      {"the_same_seed_repeats", {.options = [n = 0U](WorldOptions& options) mutable { options.seed += ++n; }}},
      {"another_seed_differs", {.options = [](WorldOptions& options) { options.seed = 7; }}},
      {"reset_without_the_claim_is_refused",
       {.features = [](Features& f, bool) { f.can_reset = false; }, .reset = [](World&, const ResetOptions&) {}}},
      {"reset_begins_anew", {.reset = [](World&, const ResetOptions&) {}}},
      {"reset_forgets_the_command",
       {.reset =
            [](World& world, const ResetOptions& options) {
              world.reset(options);
              world.robot(0).command({0.3, 0.0, 0.0}, 10s);
            }}},
      {"reset_with_the_same_seed_repeats",
       {.reset =
            [n = 0U](World& world, ResetOptions options) mutable {
              options.seed += ++n;
              world.reset(options);
            }}},
      {"saving_without_the_claim_is_refused",
       {.features = [](Features& f, bool) { f.can_save = false; },
        .save = [](World&) { return std::vector<std::byte>(); }}},
      {"a_restored_world_has_the_same_future", {.restore = [](World&, const std::vector<std::byte>&) {}}},
      {"a_restored_world_has_the_same_future",  // a counter that is not saved
       {.samples = every([n = 0U](Sample& sample) mutable { sample.sequence = n++; })}},
      {"saving_changes_nothing",
       {.save =
            [](World& world) {
              const auto state = world.save();
              world.reset({});
              return state;
            }}},

      // truth
      {"truth_begins_at_the_start_pose",
       {.true_pose = [](Pose2D pose) { return Pose2D{pose.x + 0.5, pose.y, pose.theta}; }}},
      {"truth_agrees_with_odometry", {.true_pose = [](Pose2D pose) { return Pose2D{pose.x, -pose.y, -pose.theta}; }}},
      {"true_velocity_is_in_the_body_frame",
       {.true_velocity = [](Velocity v) { return Velocity{v.vy, v.vx, v.omega}; }}},
      {"distance_driven_is_counted", {.distance_driven = [](double) { return 0.0; }}},
      {"a_free_drive_has_no_collision", {.collision_speed = [](double) { return 0.1; }}},
      {"free_poses_follow_from_the_seed", {.free_pose = [](Pose2D) { return Pose2D{1.0, 2.0, 3.0}; }}},
      {"free_poses_follow_from_the_seed",
       {.free_pose = [n = 0](Pose2D pose) mutable { return Pose2D{pose.x + ++n, pose.y, pose.theta}; }}},
      {"the_robot_starts_at_the_commanded_pose", {.options = [](WorldOptions& options) { options.poses.clear(); }}},
      {"reset_puts_the_robot_at_its_pose",
       {.reset = [](World& world, const ResetOptions& options) { world.reset({.seed = options.seed, .poses = {}}); }}},
      {"truth_is_in_the_frame_of_the_scene",
       {.true_pose = [](Pose2D pose) { return Pose2D{pose.x + 1.0, pose.y - 2.0, pose.theta}; }}},
      {"truth_is_in_the_frame_of_the_scene",
       {.true_pose = [](Pose2D pose) { return Pose2D{pose.x, -pose.y, -pose.theta}; }}},
      {"no_path_is_shorter_than_the_straight_line", {.geodesic = [](double length) { return 0.5 * length; }}},
  };
}

/// Makes worlds of `honest` with a fault. What the fault counts begins anew in each world, but for `options`.
inline WorldFactory with_fault(WorldFactory honest, Fault fault) {
  return [honest = std::move(honest), fault = std::move(fault)](WorldOptions options) mutable {
    if (fault.options) fault.options(options);
    return std::make_unique<FaultyWorld>(honest(options), fault);
  };
}

}  // namespace threewe::backend::testing
