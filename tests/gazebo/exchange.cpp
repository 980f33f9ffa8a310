// Our codec of messages against Protocol Buffers' own: random messages there and back.
//
//   gazebo_exchange COUNT SEED
#include <algorithm>
#include <cstdio>
#include <random>
#include <string>

#include "gazebo/messages.hpp"
#include "messages.pb.h"

using namespace threewe;
using namespace threewe::gazebo;

namespace {

std::mt19937_64 g_random;

double real() {
  return std::uniform_int_distribution(0, 3)(g_random) == 0 ? 0.0 : std::normal_distribution(0.0, 1e3)(g_random);
}
std::int64_t integer() {
  const int bits = std::uniform_int_distribution(0, 62)(g_random);
  const auto value = static_cast<std::int64_t>(g_random() >> (63 - bits));
  return g_random() % 2 == 0 ? value : -value;
}
std::string text() {
  std::string text(std::uniform_int_distribution<std::size_t>(0, 300)(g_random), ' ');
  for (char& letter : text) letter = static_cast<char>(g_random());
  return text;
}

void fill(msgs::Vector3d& v) { v = {real(), real(), real()}; }
void fill(msgs::Stamp& stamp) { stamp = {integer(), static_cast<std::int32_t>(integer())}; }
bool same(const msgs::Vector3d& a, const gz::msgs::Vector3d& b) { return a.x == b.x() && a.y == b.y() && a.z == b.z(); }
bool same(const msgs::Stamp& a, const gz::msgs::Time& b) { return a.sec == b.sec() && a.nsec == b.nsec(); }

/// Whether what they read of ours is what we wrote, and what we read of theirs, too.
template <typename Theirs, typename Ours, typename Same>
bool agrees(const Ours& ours, Same same_fields) {
  const Bytes bytes = encode(ours);
  Theirs theirs;
  if (!theirs.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) || !same_fields(ours, theirs)) return false;
  const std::string again = theirs.SerializeAsString();
  const auto back = decode<Ours>(view(again));
  return back && same_fields(*back, theirs);
}

bool one() {
  msgs::Odometry odometry;
  fill(odometry.header.stamp);
  fill(odometry.pose.position);
  odometry.pose.orientation = {real(), real(), real(), real()};
  fill(odometry.twist.linear);
  fill(odometry.twist.angular);
  const auto same_odometry = [](const msgs::Odometry& a, const gz::msgs::Odometry& b) {
    const auto& q = b.pose().orientation();
    return same(a.header.stamp, b.header().stamp()) && same(a.pose.position, b.pose().position()) &&
           a.pose.orientation.x == q.x() && a.pose.orientation.w == q.w() && same(a.twist.linear, b.twist().linear()) &&
           same(a.twist.angular, b.twist().angular());
  };
  msgs::LaserScan scan;
  scan.angle_min = real();
  scan.range_max = real();
  scan.count = static_cast<std::uint32_t>(g_random());
  scan.ranges.resize(g_random() % 400);
  for (double& range : scan.ranges) range = real();
  const auto same_scan = [](const msgs::LaserScan& a, const gz::msgs::LaserScan& b) {
    return a.angle_min == b.angle_min() && a.range_max == b.range_max() && a.count == b.count() &&
           std::ranges::equal(a.ranges, b.ranges());
  };
  msgs::Image image;
  image.width = static_cast<std::uint32_t>(g_random());
  image.pixel_format = static_cast<msgs::PixelFormat>(integer());
  const std::string data = text();
  image.data.assign(data.begin(), data.end());
  const auto same_image = [](const msgs::Image& a, const gz::msgs::Image& b) {
    return a.width == b.width() && static_cast<int>(a.pixel_format) == b.pixel_format_type() &&
           std::string(a.data.begin(), a.data.end()) == b.data();
  };
  msgs::WorldControl control{
      .pause = g_random() % 2 == 0, .multi_step = static_cast<std::uint32_t>(g_random()), .reset = {}};
  if (g_random() % 2 == 0) control.reset = msgs::WorldReset{.all = g_random() % 2 == 0};
  const auto same_control = [](const msgs::WorldControl& a, const gz::msgs::WorldControl& b) {
    return a.pause == b.pause() && a.multi_step == b.multi_step() && a.reset.has_value() == b.has_reset() &&
           (!a.reset || a.reset->all == b.reset().all());
  };
  msgs::Contacts contacts;
  contacts.contacts.resize(g_random() % 4);
  for (msgs::Contact& contact : contacts.contacts) {
    contact.normals.resize(g_random() % 4);
    for (msgs::Vector3d& normal : contact.normals) fill(normal);
  }
  const auto same_contacts = [](const msgs::Contacts& a, const gz::msgs::Contacts& b) {
    return std::ranges::equal(a.contacts, b.contact(), [](const msgs::Contact& one, const gz::msgs::Contact& other) {
      return std::ranges::equal(one.normals, other.normal(), [](const auto& x, const auto& y) { return same(x, y); });
    });
  };
  return agrees<gz::msgs::Odometry>(odometry, same_odometry) && agrees<gz::msgs::LaserScan>(scan, same_scan) &&
         agrees<gz::msgs::Image>(image, same_image) && agrees<gz::msgs::WorldControl>(control, same_control) &&
         agrees<gz::msgs::Contacts>(contacts, same_contacts);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  const int rounds = std::stoi(arguments[1]);
  g_random.seed(std::stoul(arguments[2]));
  for (int i = 0; i < rounds; ++i) {
    if (one()) continue;
    std::printf("round %d of seed %s differs\n", i, arguments[2]);
    return 1;
  }
  std::printf("%d rounds agree\n", rounds);
  return 0;
}
