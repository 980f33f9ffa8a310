#include "gazebo/protobuf.hpp"

#include <random>

#include <doctest/doctest.h>

#include "gazebo/messages.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::gazebo;

namespace {

msgs::Discovery an_advertisement() {
  msgs::Discovery message;
  message.version = 10;
  message.process = "here";
  message.type = msgs::Discovery::Type::advertise;
  msgs::Publisher publisher;
  publisher.topic = "@/partition@/lidar";
  publisher.scope = msgs::Publisher::kEverywhere;
  publisher.message = msgs::MessagePublisher{.control = {}, .type = msgs::LaserScan::kType};
  message.publisher = publisher;
  return message;
}

}  // namespace

TEST_CASE("a message comes back as it was written") {
  const auto back = decode<msgs::Discovery>(encode(an_advertisement()));
  REQUIRE(back);
  CHECK(back->version == 10);
  CHECK(back->type == msgs::Discovery::Type::advertise);
  CHECK(!back->subscriber);
  REQUIRE(back->publisher);
  CHECK(back->publisher->topic == "@/partition@/lidar");
  REQUIRE(back->publisher->message);
  CHECK(!back->publisher->service);
  CHECK(back->publisher->message->type == "gz.msgs.LaserScan");
}

TEST_CASE("a negative number fills its field") {
  const msgs::Stamp stamp{.sec = -1, .nsec = -5};
  CHECK(encode(stamp).size() == 22);
  const auto back = decode<msgs::Stamp>(encode(stamp));
  REQUIRE(back);
  CHECK(back->sec == -1);
  CHECK(back->nsec == -5);
  CHECK(msgs::to_time({.sec = std::numeric_limits<std::int64_t>::max(), .nsec = 0}) == Time{});
}

TEST_CASE("ranges may come packed or one by one") {
  const Bytes packed{0x72, 16, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F, 0, 0, 0, 0, 0, 0, 0, 0x40};
  const Bytes single{0x71, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F, 0x71, 0, 0, 0, 0, 0, 0, 0, 0x40};
  for (const Bytes& bytes : {packed, single}) {
    const auto scan = decode<msgs::LaserScan>(bytes);
    REQUIRE(scan);
    CHECK(scan->ranges == std::vector{1.0, 2.0});
  }
}

TEST_CASE("what is cut off, too long or of another kind is no message") {
  const Bytes whole = encode(an_advertisement());
  for (const Bytes& wrong : {Bytes{0x0A}, Bytes{0x0A, 5, 1}, Bytes{0x0A, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F}, Bytes{0x0B},
                             Bytes{0x00}, Bytes{0x10}, Bytes(11, 0xFF), Bytes{0x12, 1, 0}}) {
    CHECK(!decode<msgs::Discovery>(wrong));
  }
  const Bytes odd{0x72, 3, 0, 0, 0};
  CHECK(!decode<msgs::LaserScan>(odd));
  CHECK(!decode<msgs::Discovery>(ByteView(whole).first(whole.size() - 1)));
}

TEST_CASE("any bytes are read within their bounds, into no more than them") {
  std::mt19937 random(1);
  const Bytes whole = encode(an_advertisement());
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes = whole;
    for (unsigned i = 0; i < 1 + random() % 4; ++i)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    bytes.resize(random() % (bytes.size() + 1));
    const auto message = decode<msgs::Discovery>(bytes);
    if (message && message->publisher) CHECK(message->publisher->topic.size() <= bytes.size());
    if (const auto scan = decode<msgs::LaserScan>(bytes)) CHECK(scan->ranges.size() * sizeof(double) <= bytes.size());
  }
}
