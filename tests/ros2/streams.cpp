// Stand-in for a robot whose cameras send raw images: another process, on another DDS, of messages alone.
//
//   ros2_streams DOMAIN [--images]
//
// It publishes /odom and /scan 50 times a second, and with --images /camera/image_raw (bgr8) and /camera/depth (32FC1)
// of 640 x 480 pixels 30 times a second, best effort; it takes velocities on /cmd_vel. The first range of a scan, and
// the first depth of an image, are 1 + k / 1024 m in the k-th (of 1024). It prints a line when it is ready, and
// when it is asked to end when each of them was sent and each velocity came, in nanoseconds of the computer's monotonic
// clock. Where the system permits it, velocities are received in threads of real-time priority: how late they come is
// then their sender's doing.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <pthread.h>
#include <sched.h>

#include "node.hpp"
#include "robotPubSubTypes.h"

using Clock = std::chrono::steady_clock;

namespace {

constexpr int kBeams = 450;
constexpr std::uint32_t kWidth = 640, kHeight = 480;
constexpr auto kPeriod = std::chrono::milliseconds(20);
constexpr auto kImagePeriod = std::chrono::microseconds(33'333);

std::atomic<bool> g_ended = false;

std::int64_t now() { return Clock::now().time_since_epoch().count(); }

std_msgs::msg::dds_::Header_ header(const std::string& frame) {
  const std::int64_t nanoseconds = now();
  std_msgs::msg::dds_::Header_ header;
  header.stamp().sec(static_cast<std::int32_t>(nanoseconds / 1'000'000'000));
  header.stamp().nanosec(static_cast<std::uint32_t>(nanoseconds % 1'000'000'000));
  header.frame_id(frame);
  return header;
}

float numbered(std::size_t count) { return 1.0F + static_cast<float>(count % 1024) / 1024.0F; }

/// When each velocity came.
class Commands : public fast::DataReaderListener {
 public:
  void on_data_available(fast::DataReader* reader) override {
    geometry_msgs::msg::dds_::Twist_ twist;
    fast::SampleInfo info;
    while (reader->take_next_sample(&twist, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      const std::scoped_lock lock(mutex_);
      times_.push_back(now());
    }
  }
  std::vector<std::int64_t> times() {
    const std::scoped_lock lock(mutex_);
    return times_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::int64_t> times_;
};

void print(const char* name, const std::vector<std::int64_t>& times, const char* end) {
  std::printf("\"%s\": [", name);
  for (std::size_t i = 0; i < times.size(); ++i)
    std::printf("%s%lld", i == 0 ? "" : ", ", static_cast<long long>(times[i]));
  std::printf("]%s", end);
}

// Of this thread.
void set_policy(int policy) {
  const sched_param priority{.sched_priority = policy == SCHED_FIFO ? 2 : 0};
  (void)pthread_setschedparam(pthread_self(), policy, &priority);
}

void run(unsigned domain, bool with_images) {
  using namespace sensor_msgs::msg::dds_;
  Commands commands;
  set_policy(SCHED_FIFO);  // which the threads of Fast DDS inherit
  Node node(domain);
  set_policy(SCHED_OTHER);
  fast::DataWriter* odometry =
      node.advertise<nav_msgs::msg::dds_::Odometry_PubSubType>("/odom", "nav_msgs::msg::dds_::Odometry_");
  fast::DataWriter* scans = node.advertise<LaserScan_PubSubType>("/scan", "sensor_msgs::msg::dds_::LaserScan_");
  const std::string image_type = "sensor_msgs::msg::dds_::Image_";
  fast::DataWriter* color = with_images ? node.advertise<Image_PubSubType>("/camera/image_raw", image_type) : nullptr;
  fast::DataWriter* depth = with_images ? node.advertise<Image_PubSubType>("/camera/depth", image_type) : nullptr;
  node.subscribe<geometry_msgs::msg::dds_::Twist_PubSubType>("/cmd_vel", "geometry_msgs::msg::dds_::Twist_", commands);
  std::puts("ready");
  std::fflush(stdout);

  std::vector<std::int64_t> scan_times, image_times;
  const auto begin = Clock::now();
  std::thread camera([&] {
    if (!with_images) return;
    Image_ of_color, of_depth;
    for (Image_* image : {&of_color, &of_depth}) {
      image->width(kWidth);
      image->height(kHeight);
    }
    of_color.encoding("bgr8");
    of_color.step(3 * kWidth);
    of_color.data().assign(std::size_t{3} * kWidth * kHeight, 90);
    of_depth.encoding("32FC1");
    of_depth.step(4 * kWidth);
    of_depth.data().assign(std::size_t{4} * kWidth * kHeight, 0);
    for (int i = 0; !g_ended; ++i) {
      std::this_thread::sleep_until(begin + i * kImagePeriod);
      const float number = numbered(image_times.size());
      std::memcpy(of_depth.data().data(), &number, sizeof number);
      of_color.header(header("camera"));
      of_depth.header(of_color.header());
      image_times.push_back(now());
      color->write(&of_color);
      depth->write(&of_depth);
    }
  });
  nav_msgs::msg::dds_::Odometry_ where;
  where.child_frame_id("base_link");
  where.pose().pose().orientation().w(1.0);
  LaserScan_ scan;
  scan.angle_min(-3.14159265F);
  scan.angle_increment(6.28318531F / kBeams);
  scan.angle_max(scan.angle_min() + (kBeams - 1) * scan.angle_increment());
  scan.range_min(0.12F);
  scan.range_max(12.0F);
  scan.ranges().assign(kBeams, 3.0F);
  for (int i = 0; !g_ended; ++i) {
    std::this_thread::sleep_until(begin + i * kPeriod);
    where.header(header("odom"));
    odometry->write(&where);
    std::this_thread::sleep_until(begin + i * kPeriod + kPeriod / 3);
    scan.header(header("lidar"));
    scan.ranges()[0] = numbered(scan_times.size());
    scan_times.push_back(now());
    scans->write(&scan);
  }
  camera.join();
  std::printf("{");
  print("scans", scan_times, ", ");
  print("images", image_times, ", ");
  print("commands", commands.times(), "}\n");
}

}  // namespace

int main(int count, char** arguments) {
  const bool with_images = count == 3 && std::string_view(arguments[2]) == "--images";
  if (count < 2 || count > 3 || (count == 3 && !with_images)) {
    std::fputs("usage: ros2_streams DOMAIN [--images]\n", stderr);
    return 2;
  }
  std::signal(SIGTERM, [](int) { g_ended = true; });
  try {
    run(static_cast<unsigned>(std::stoul(arguments[1])), with_images);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_streams: %s\n", error.what());
    return 1;
  }
  return 0;
}
