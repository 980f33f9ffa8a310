// Recorder of ROS 2 topics on Fast DDS, and a driver: neither knows any code of ours.
//
//   ros2_recorder DOMAIN FILE [--drive TOPIC | --drive-stamped TOPIC] [--goal X,Y] [--echo] TOPIC=TYPE[!] ...
//
// TYPE is as DDS has it, "sensor_msgs::msg::dds_::LaserScan_"; with ! it asks for what was published before. Payloads
// go to FILE as they are: a line "TOPIC SIZE" and the bytes. It prints "ready" once all topics are matched. Each line
// "VX VY OMEGA COUNT" of its input is published COUNT times, each time when the clock has gone on by 20 ms, or at 50 Hz
// where /clock is not among the topics. It ends with its input. With --goal it first publishes a pose in the map on
// /goal_pose. With
// --echo it publishes each message again, on TOPIC/back.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "node.hpp"
#include "robotPubSubTypes.h"

namespace {

using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Bytes = std::vector<unsigned char>;

constexpr std::int64_t kPeriod = 20'000'000;  // [ns]

/// A type whose samples are payloads as they come.
class RawType : public fast::TopicDataType {
 public:
  RawType() {
    m_typeSize = 1 << 10;  // to begin with
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    std::copy(bytes.begin(), bytes.end(), payload->data);
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

/// What all topics write to, and the newest clock among it.
class Record {
 public:
  explicit Record(const std::string& path) : file_(path, std::ios::binary) {}
  void add(const std::string& topic, const Bytes& payload) {
    const std::scoped_lock lock(mutex_);
    file_ << topic << ' ' << payload.size() << '\n';
    file_.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
    if (topic != "/clock") return;
    std::int32_t seconds = 0;
    std::uint32_t nanoseconds = 0;
    std::memcpy(&seconds, payload.data() + 4, sizeof seconds);
    std::memcpy(&nanoseconds, payload.data() + 8, sizeof nanoseconds);
    clock_ = std::int64_t{1'000'000'000} * seconds + nanoseconds;
  }
  std::int64_t clock() const { return clock_; }

 private:
  std::mutex mutex_;
  std::ofstream file_;
  std::atomic<std::int64_t> clock_ = -1;
};

class Topic : public fast::DataReaderListener {
 public:
  Topic(std::string name, Record& record, fast::DataWriter* back)
      : name_(std::move(name)), record_(record), back_(back) {}
  void on_data_available(fast::DataReader* reader) override {
    Bytes payload;
    fast::SampleInfo info;
    while (reader->take_next_sample(&payload, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      record_.add(name_, payload);
      if (back_ != nullptr) back_->write(&payload);
    }
  }
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    matched_ = status.current_count > 0;
  }
  bool matched() const { return matched_; }

 private:
  std::string name_;
  Record& record_;
  fast::DataWriter* back_;
  std::atomic<bool> matched_ = false;
};

/// Publishes velocities, stamped or not.
class Driver {
 public:
  Driver(Node& node, const std::string& topic, bool stamped) : stamped_(stamped) {
    using namespace geometry_msgs::msg::dds_;
    const std::string type = "geometry_msgs::msg::dds_::";
    writer_ = stamped ? node.advertise<TwistStamped_PubSubType>(topic, type + "TwistStamped_", true)
                      : node.advertise<Twist_PubSubType>(topic, type + "Twist_", true);
  }
  bool matched() const {
    fast::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }
  void send(double vx, double vy, double omega) {
    geometry_msgs::msg::dds_::TwistStamped_ message;
    message.twist().linear().x(vx);
    message.twist().linear().y(vy);
    message.twist().angular().z(omega);
    writer_->write(stamped_ ? static_cast<void*>(&message) : static_cast<void*>(&message.twist()));
  }

 private:
  bool stamped_;
  fast::DataWriter* writer_ = nullptr;
};

void drive(Driver& driver, const Record& record, bool by_clock) {
  while (by_clock && record.clock() < 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  double vx = 0.0;
  double vy = 0.0;
  double omega = 0.0;
  int count = 0;
  while (std::cin >> vx >> vy >> omega >> count) {
    for (; count > 0; --count) {
      const std::int64_t before = record.clock();
      driver.send(vx, vy, omega);
      if (!by_clock) std::this_thread::sleep_for(std::chrono::nanoseconds(kPeriod));
      while (by_clock && record.clock() < before + kPeriod) {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      }
    }
  }
}

int run(const std::vector<std::string>& arguments) {
  Record record(arguments[1]);
  Node node(static_cast<unsigned>(std::stoul(arguments[0])));
  std::unique_ptr<Driver> driver;
  std::optional<geometry_msgs::msg::dds_::PoseStamped_> goal;
  fast::DataWriter* goals = nullptr;
  bool by_clock = false;
  bool echo = false;
  std::vector<std::unique_ptr<Topic>> topics;
  for (std::size_t i = 2; i < arguments.size(); ++i) {
    if (arguments[i].starts_with("--drive")) {
      const bool stamped = arguments[i] == "--drive-stamped";
      driver = std::make_unique<Driver>(node, arguments.at(++i), stamped);
      continue;
    }
    if (arguments[i] == "--goal") {
      double x = 0.0;
      double y = 0.0;
      if (std::sscanf(arguments.at(++i).c_str(), "%lf,%lf", &x, &y) != 2) return 2;
      goal.emplace();
      goal->header().frame_id("map");
      goal->pose().position().x(x);
      goal->pose().position().y(y);
      goal->pose().orientation().w(1.0);
      goals = node.offer<geometry_msgs::msg::dds_::PoseStamped_PubSubType>(
          "rt/goal_pose", "geometry_msgs::msg::dds_::PoseStamped_", false);
      continue;
    }
    if (arguments[i] == "--echo") {
      echo = true;
      continue;
    }
    const std::size_t equals = arguments[i].find('=');
    const bool kept = arguments[i].ends_with('!');
    const std::string name = arguments[i].substr(0, equals);
    by_clock = by_clock || name == "/clock";
    const std::string type = arguments[i].substr(equals + 1, arguments[i].size() - equals - 1 - (kept ? 1 : 0));
    fast::DataWriter* back = echo ? node.advertise<RawType>(name + "/back", type, true) : nullptr;
    topics.push_back(std::make_unique<Topic>(name, record, back));
    node.record<RawType>(name, type, kept, *topics.back());
  }
  const auto all_matched = [&] {
    for (const auto& topic : topics) {
      if (!topic->matched()) return false;
    }
    return driver == nullptr || driver->matched();
  };
  for (int i = 0; i < 1500 && !all_matched(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // the others' side of the match, and what is kept
  std::puts(all_matched() ? "ready" : "not matched");
  std::fflush(stdout);
  if (goal) goals->write(&*goal);
  if (driver) {
    drive(*driver, record, by_clock);
  } else {
    std::string line;
    while (std::getline(std::cin, line)) continue;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) {
    std::fputs("usage: ros2_recorder DOMAIN FILE [--drive TOPIC | --drive-stamped TOPIC] TOPIC=TYPE[!] ...\n", stderr);
    return 2;
  }
  return run({arguments + 1, arguments + count});
}
