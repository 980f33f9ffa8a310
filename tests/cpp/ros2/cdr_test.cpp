// Payloads that nobody meant: each is read or refused, and none takes more memory than a small multiple of its own
// size.
#include "ros2/cdr.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "draw.hpp"
#include "ros2/message_types.hpp"
#include "ros2/messages/nav_msgs.hpp"
#include "ros2/messages/sensor_msgs.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "ros2/sha256.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

TEST_CASE("the digest of FIPS 180-4's examples") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST_CASE("random bytes, and payloads with wrong bytes, are read or refused in every type and layout") {
  const nav_msgs::Path path{{{1, 2}, "map"}, {{}, {}, {}}};
  const std::vector<std::uint8_t> whole = encode(path, Distribution::jazzy);
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::vector<std::uint8_t> payload = whole;
    if (draw.whole(0, 1) == 0) {
      payload.resize(static_cast<std::size_t>(draw.whole(0, 200)));
      for (std::uint8_t& byte : payload)
        byte = static_cast<std::uint8_t>(draw.whole(0, 3) == 0 ? draw.whole(0, 255) : 0);
    }
    for (int i = 0; i < 5 && !payload.empty(); ++i) {
      payload[static_cast<std::size_t>(draw.whole(0, static_cast<int>(payload.size()) - 1))] =
          static_cast<std::uint8_t>(draw.whole(0, 255));
    }
    if (payload.size() >= 2 && draw.whole(0, 9) > 0) payload[0] = 0;
    if (payload.size() >= 2 && draw.whole(0, 9) > 0) payload[1] = static_cast<std::uint8_t>(draw.whole(0, 1));
    for (const MessageType& type : message_types()) {
      for (const Distribution layout : kDistributions) {
        const auto again = type.recode(payload, layout);
        // what was read is written as the same message, which is the same to every reader
        if (again) CHECK(type.recode(*again, layout) == again);
      }
    }
  }
}

TEST_CASE("elements are believed as far as bytes are there for the smallest of them") {
  std::vector<std::uint8_t> payload{0, 1, 0, 0, 0xff, 0xff, 0xff, 0x0f};
  payload.resize(1000);
  const auto message = decode<tf2_msgs::TFMessage>(payload, Distribution::jazzy);
  REQUIRE_FALSE(message);
  CHECK(message.error() == "tf2_msgs/msg/TFMessage: transforms has 268435455 elements, which are beyond the end");
  CHECK(least_wire_size<geometry_msgs::TransformStamped>(Distribution::jazzy) == 8 + 4 + 4 + 56);
}

TEST_CASE("a text longer than its type allows is refused") {
  rmw_dds_common::ParticipantEntitiesInfo info;
  info.node_entities_info_seq.emplace_back().node_name.assign(257, 'a');
  const auto read =
      decode<rmw_dds_common::ParticipantEntitiesInfo>(encode(info, Distribution::jazzy), Distribution::jazzy);
  REQUIRE_FALSE(read);
  CHECK(read.error().find("node_name is longer") != std::string::npos);
}

TEST_CASE("names of types, as ROS and as DDS has them") {
  CHECK(dds_type_name("geometry_msgs/msg/Twist") == "geometry_msgs::msg::dds_::Twist_");
  CHECK(ros_type_name("geometry_msgs::msg::dds_::Twist_") == "geometry_msgs/msg/Twist");
  CHECK(ros_type_name("nav2_msgs::action::dds_::NavigateToPose_FeedbackMessage_") ==
        "nav2_msgs/action/NavigateToPose_FeedbackMessage");
  CHECK(ros_type_name("HelloWorld").empty());
  CHECK_THROWS_WITH_AS(message_type("geometry_msgs/msg/Twits"),
                       "unknown message 'geometry_msgs/msg/Twits'; did you mean 'geometry_msgs/msg/Twist'?",
                       ConfigError);
}

TEST_CASE("a hash tells the distributions") {
  const MessageType& range = message_type("sensor_msgs/msg/Range");
  CHECK(distributions_with("sensor_msgs/msg/Range", range.hash(Distribution::humble)) ==
        std::vector{Distribution::humble});
  CHECK(distributions_with("sensor_msgs/msg/Range", range.hash(Distribution::jazzy)) ==
        std::vector{Distribution::jazzy, Distribution::kilted});
  CHECK(distributions_with("sensor_msgs/msg/Range", "RIHS01_00").empty());
  CHECK(distributions_with("my_msgs/msg/Mine", "RIHS01_00").empty());
}

}  // namespace
}  // namespace threewe::ros2
