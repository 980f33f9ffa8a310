#include "ros2/diagnosis.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "ros2/message_types.hpp"

namespace threewe::ros2 {
namespace {

// Topics of the type that is looked for, on which it may be instead.
std::string others_of(const TopicSpec& topic, const std::vector<Endpoint>& endpoints) {
  std::vector<std::string> names;
  for (const Endpoint& endpoint : endpoints) {
    if (endpoint.type == topic.type) names.push_back(endpoint.topic);
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names.empty() ? "" : fmt::format("; of that type there is {}", fmt::join(names, ", "));
}

}  // namespace

std::string diagnose(const TopicSpec& topic, bool we_publish, const std::vector<Endpoint>& endpoints) {
  std::vector<Endpoint> theirs;
  std::ranges::copy_if(endpoints, std::back_inserter(theirs), [&](const Endpoint& endpoint) {
    return endpoint.publishes != we_publish && !endpoint.type.empty();
  });
  const char* does = we_publish ? "subscribes to" : "publishes";
  const auto here = std::ranges::find(theirs, topic.topic, &Endpoint::topic);
  if (here == theirs.end()) {
    return fmt::format("{}: no node {} {} ({}){}", topic.sensor, does, topic.topic, topic.type,
                       others_of(topic, theirs));
  }
  const auto right = std::ranges::find_if(
      theirs, [&](const Endpoint& endpoint) { return endpoint.topic == topic.topic && endpoint.type == topic.type; });
  if (right == theirs.end()) {
    return fmt::format("{}: {} is of type {}, the profile has {}", topic.sensor, topic.topic, here->type, topic.type);
  }
  if (!right->hash.empty() && distributions_with(right->type, right->hash).empty()) {
    return fmt::format("{}: {} is of a {} that no distribution has which we know ({})", topic.sensor, topic.topic,
                       topic.type, right->hash);
  }
  if (we_publish ? right->qos.reliable && !topic.reliable : topic.reliable && !right->qos.reliable) {
    return fmt::format("{}: {} is {} there, the profile has {}: the two do not match", topic.sensor, topic.topic,
                       right->qos.reliable ? "reliable" : "best effort", topic.reliable ? "reliable" : "best effort");
  }
  return "";
}

std::string explain_lost_images(std::size_t most_granted) {
  constexpr std::size_t kEnough = 4U << 20U;  // [bytes] for two images of 0.9 MB and what comes meanwhile
  if (most_granted >= kEnough) return "on the way or as this computer was too slow; compressed images need less";
  return fmt::format(
      "an image comes as one burst of packets, of which the kernel keeps {} KiB at most: sysctl -w "
      "net.core.rmem_max={}",
      most_granted / 1024, kEnough);
}

std::string diagnose_silence(const Discovery& discovery) {
  const auto look = fmt::format("no ROS 2 node was found in domain {}", discovery.domain);
  switch (discovery.range) {
    case DiscoveryRange::off: return look + ": ROS_AUTOMATIC_DISCOVERY_RANGE is OFF";
    case DiscoveryRange::localhost:
      return look +
             " on this computer; to look farther, set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET, or ROS_STATIC_PEERS "
             "to the robot's address";
    case DiscoveryRange::subnet:
    case DiscoveryRange::system_default: break;
  }
  return look + ": is ROS_DOMAIN_ID the robot's, and does the network let multicast through (else ROS_STATIC_PEERS)?";
}

}  // namespace threewe::ros2
