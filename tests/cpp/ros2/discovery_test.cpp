// With whom a node talks, by the environment.
#include "ros2/discovery.hpp"

#include <doctest/doctest.h>

#include <map>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

Discovery read(const std::map<std::string, std::string>& variables) {
  return read_discovery([&](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("a node is announced to this computer alone unless a variable asks for more") {
  const Discovery discovery = read({});
  CHECK(discovery.domain == 0);
  CHECK(discovery.range == DiscoveryRange::localhost);
  const std::string xml = cyclone_configuration(discovery);
  CHECK(has(xml, "<AllowMulticast>false</AllowMulticast>"));
  CHECK(has(xml, R"(<Peers><Peer address="localhost"/></Peers>)"));
}

TEST_CASE("ranges are those of ROS 2") {
  CHECK(has(cyclone_configuration(read({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}})), "<Tag>"));
  const std::string subnet = cyclone_configuration(read({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}));
  CHECK_FALSE(has(subnet, "AllowMulticast"));
  CHECK_FALSE(has(subnet, "Peer"));
  CHECK(cyclone_configuration(read({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SYSTEM_DEFAULT"}})).empty());
  CHECK_THROWS_WITH_AS(read({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNETS"}}),
                       "unknown ROS_AUTOMATIC_DISCOVERY_RANGE 'SUBNETS'; did you mean 'SUBNET'?", ConfigError);
}

TEST_CASE("peers of other computers are reached over the network, and found without multicast") {
  const Discovery discovery = read({{"ROS_STATIC_PEERS", "192.168.7.2;robot.local;"}});
  CHECK(discovery.static_peers == std::vector<std::string>{"192.168.7.2", "robot.local"});
  const std::string xml = cyclone_configuration(discovery);
  CHECK(has(xml, R"(<Peer address="192.168.7.2"/><Peer address="robot.local"/>)"));
  CHECK(has(xml, "<AllowMulticast>false</AllowMulticast>"));
  CHECK_THROWS_AS(read({{"ROS_STATIC_PEERS", R"(a"/><Evil)"}}), ConfigError);
}

TEST_CASE("ROS_LOCALHOST_ONLY is above the others") {
  const Discovery discovery = read(
      {{"ROS_LOCALHOST_ONLY", "1"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}, {"ROS_STATIC_PEERS", "192.168.7.2"}});
  CHECK(discovery == Discovery{0, DiscoveryRange::localhost, {}});
  CHECK(read({{"ROS_LOCALHOST_ONLY", "0"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}).range ==
        DiscoveryRange::subnet);
}

TEST_CASE("domains are numbers that have ports") {
  CHECK(read({{"ROS_DOMAIN_ID", "232"}}).domain == 232);
  for (const char* wrong : {"233", "-1", "one", "1.5", "1 "}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(read({{"ROS_DOMAIN_ID", wrong}}), ConfigError);
  }
}

}  // namespace
}  // namespace threewe::ros2
