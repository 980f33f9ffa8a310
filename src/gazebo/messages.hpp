// Messages of Gazebo, of package gz.msgs: those that we exchange, with the fields that we read or write. They are the
// same from Garden to Jetty.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "gazebo/protobuf.hpp"
#include "threewe/core/time.hpp"

namespace threewe::gazebo::msgs {

struct Stamp {
  std::int64_t sec = 0;
  std::int32_t nsec = 0;
  static constexpr auto kFields = std::tuple(Field{1, &Stamp::sec}, Field{2, &Stamp::nsec});
};

/// As nanoseconds; a stamp that is too far from zero is zero.
inline threewe::Time to_time(const Stamp& stamp) {
  constexpr std::int64_t kMost = 1'000'000'000;  // [s]
  if (stamp.sec > kMost || stamp.sec < -kMost) return {};
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nsec);
}

struct Header {
  Stamp stamp;
  static constexpr auto kFields = std::tuple(Field{1, &Header::stamp});
};

struct Vector3d {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  static constexpr auto kFields = std::tuple(Field{2, &Vector3d::x}, Field{3, &Vector3d::y}, Field{4, &Vector3d::z});
};

struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 0.0;
  static constexpr auto kFields = std::tuple(Field{2, &Quaternion::x}, Field{3, &Quaternion::y},
                                             Field{4, &Quaternion::z}, Field{5, &Quaternion::w});
};

struct Pose {
  static constexpr const char* kType = "gz.msgs.Pose";
  std::string name;
  Vector3d position;
  Quaternion orientation;
  static constexpr auto kFields =
      std::tuple(Field{2, &Pose::name}, Field{4, &Pose::position}, Field{5, &Pose::orientation});
};

struct Twist {
  static constexpr const char* kType = "gz.msgs.Twist";
  Vector3d linear;
  Vector3d angular;
  static constexpr auto kFields = std::tuple(Field{2, &Twist::linear}, Field{3, &Twist::angular});
};

struct Boolean {
  static constexpr const char* kType = "gz.msgs.Boolean";
  bool data = false;
  static constexpr auto kFields = std::tuple(Field{2, &Boolean::data});
};

struct WorldReset {
  bool all = false;
  static constexpr auto kFields = std::tuple(Field{2, &WorldReset::all});
};

struct WorldControl {
  static constexpr const char* kType = "gz.msgs.WorldControl";
  bool pause = false;
  std::uint32_t multi_step = 0;
  std::optional<WorldReset> reset;
  static constexpr auto kFields =
      std::tuple(Field{2, &WorldControl::pause}, Field{4, &WorldControl::multi_step}, Field{5, &WorldControl::reset});
};

struct Clock {
  static constexpr const char* kType = "gz.msgs.Clock";
  Stamp sim;
  static constexpr auto kFields = std::tuple(Field{4, &Clock::sim});
};

struct LaserScan {
  static constexpr const char* kType = "gz.msgs.LaserScan";
  Header header;
  double angle_min = 0.0;
  double angle_max = 0.0;
  double angle_step = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  std::uint32_t count = 0;
  std::vector<double> ranges;
  static constexpr auto kFields =
      std::tuple(Field{1, &LaserScan::header}, Field{4, &LaserScan::angle_min}, Field{5, &LaserScan::angle_max},
                 Field{6, &LaserScan::angle_step}, Field{7, &LaserScan::range_min}, Field{8, &LaserScan::range_max},
                 Field{9, &LaserScan::count}, Field{14, &LaserScan::ranges});
};

struct Imu {
  static constexpr const char* kType = "gz.msgs.IMU";
  Header header;
  Vector3d angular_velocity;
  Vector3d linear_acceleration;
  static constexpr auto kFields =
      std::tuple(Field{1, &Imu::header}, Field{5, &Imu::angular_velocity}, Field{7, &Imu::linear_acceleration});
};

struct Odometry {
  static constexpr const char* kType = "gz.msgs.Odometry";
  Header header;
  Pose pose;
  Twist twist;
  static constexpr auto kFields =
      std::tuple(Field{1, &Odometry::header}, Field{2, &Odometry::pose}, Field{3, &Odometry::twist});
};

enum class PixelFormat : std::int32_t { unknown = 0, rgb8 = 3, bgr8 = 8, float32 = 13 };

struct Image {
  static constexpr const char* kType = "gz.msgs.Image";
  Header header;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t step = 0;
  Bytes data;
  PixelFormat pixel_format = PixelFormat::unknown;
  static constexpr auto kFields =
      std::tuple(Field{1, &Image::header}, Field{2, &Image::width}, Field{3, &Image::height}, Field{4, &Image::step},
                 Field{5, &Image::data}, Field{6, &Image::pixel_format});
};

struct Contact {
  std::vector<Vector3d> normals;
  static constexpr auto kFields = std::tuple(Field{5, &Contact::normals});
};

struct Contacts {
  static constexpr const char* kType = "gz.msgs.Contacts";
  Header header;
  std::vector<Contact> contacts;
  static constexpr auto kFields = std::tuple(Field{1, &Contacts::header}, Field{2, &Contacts::contacts});
};

// What nodes say to find each other.

struct Flags {
  bool relay = false;
  bool no_relay = false;
  static constexpr auto kFields = std::tuple(Field{1, &Flags::relay}, Field{2, &Flags::no_relay});
};

struct Subscriber {
  std::string topic;
  static constexpr auto kFields = std::tuple(Field{1, &Subscriber::topic});
};

struct MessagePublisher {
  std::string control;  // of a new connection: the process that publishes
  std::string type;
  static constexpr auto kFields = std::tuple(Field{1, &MessagePublisher::control}, Field{2, &MessagePublisher::type});
};

struct ServicePublisher {
  std::string socket;
  std::string request_type;
  std::string reply_type;
  static constexpr auto kFields =
      std::tuple(Field{1, &ServicePublisher::socket}, Field{2, &ServicePublisher::request_type},
                 Field{3, &ServicePublisher::reply_type});
};

struct Publisher {
  static constexpr std::int32_t kEverywhere = 2;  // the scope of a publisher that other machines may use, too
  std::string topic;                              // with its partition
  std::string address;
  std::string process;
  std::string node;
  std::int32_t scope = 0;
  std::optional<MessagePublisher> message;
  std::optional<ServicePublisher> service;
  static constexpr auto kFields =
      std::tuple(Field{1, &Publisher::topic}, Field{2, &Publisher::address}, Field{3, &Publisher::process},
                 Field{4, &Publisher::node}, Field{5, &Publisher::scope}, Field{6, &Publisher::message},
                 Field{7, &Publisher::service});
};

struct Discovery {
  enum class Type : std::int32_t {
    uninitialized = 0,
    advertise = 1,
    subscribe = 2,
    unadvertise = 3,
    heartbeat = 4,
    bye = 5,
    new_connection = 6,
    end_connection = 7,
  };
  std::uint32_t version = 0;
  std::string process;
  Type type = Type::uninitialized;
  std::optional<Flags> flags;
  std::optional<Subscriber> subscriber;
  std::optional<Publisher> publisher;
  static constexpr auto kFields =
      std::tuple(Field{2, &Discovery::version}, Field{3, &Discovery::process}, Field{4, &Discovery::type},
                 Field{5, &Discovery::flags}, Field{6, &Discovery::subscriber}, Field{7, &Discovery::publisher});
};

}  // namespace threewe::gazebo::msgs
