#include "ros2/diagnosis.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hardware/link.hpp"
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

// Those who publish a topic; nodes of micro-ROS have no names.
std::vector<std::string> publishers_of(const std::string& topic, const std::vector<Endpoint>& endpoints) {
  std::vector<std::string> names;
  for (const Endpoint& endpoint : endpoints) {
    if (!endpoint.publishes || endpoint.topic != topic) continue;
    names.push_back(endpoint.node.empty() ? "a node without a name" : endpoint.node);
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

bool has_unknown_hash(const Endpoint& endpoint) {
  return !endpoint.hash.empty() && distributions_with(endpoint.type, endpoint.hash).empty();
}

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
  for (const Endpoint& endpoint : theirs) {
    if (endpoint.topic != topic.topic || endpoint.type != topic.type || !has_unknown_hash(endpoint)) continue;
    return fmt::format("{}: {} is of a {} that no distribution has which we know ({})", topic.sensor, topic.topic,
                       topic.type, endpoint.hash);
  }
  if (we_publish ? right->qos.reliable && !topic.reliable : topic.reliable && !right->qos.reliable) {
    return fmt::format("{}: {} is {} there, the profile has {}: the two do not match", topic.sensor, topic.topic,
                       right->qos.reliable ? "reliable" : "best effort", topic.reliable ? "reliable" : "best effort");
  }
  return "";
}

std::string command_type(const TopicSpec& command, const std::vector<Endpoint>& endpoints) {
  const std::vector<std::string> types = command_types();
  std::string type = command.type;
  for (const Endpoint& endpoint : endpoints) {
    if (endpoint.publishes || endpoint.topic != command.topic) continue;
    if (endpoint.type == command.type) return command.type;
    if (std::ranges::find(types, endpoint.type) != types.end()) type = endpoint.type;
  }
  return type;
}

std::string diagnose_drivers(const TopicSpec& command, const std::vector<Endpoint>& endpoints) {
  const std::vector<std::string> others = publishers_of(command.topic, endpoints);
  if (others.empty()) return "";
  return fmt::format(
      "command: {} is published by {} as well, and two that command one robot take turns: end that, or "
      "set `shared: true` in the `command` of the profile's link",
      command.topic, fmt::join(others, ", "));
}

std::string diagnose_rivals(const TopicSpec& topic, const std::vector<Endpoint>& endpoints) {
  return fmt::format("{}: two nodes publish it on {} ({}): one of them is another robot, or is left over", topic.sensor,
                     topic.topic, fmt::join(publishers_of(topic.topic, endpoints), ", "));
}

std::string explain_lost_images(std::size_t most_granted) {
  constexpr std::size_t kEnough = 4U << 20U;  // [bytes] for two images of 0.9 MB and what comes meanwhile
  if (most_granted >= kEnough) return "on the way or as this computer was too slow; compressed images need less";
  return fmt::format(
      "an image comes as one burst of packets, of which the kernel keeps {} KiB at most: sysctl -w "
      "net.core.rmem_max={}",
      most_granted / 1024, kEnough);
}

std::string describe_interfaces(const std::vector<std::string>& interfaces) {
  return interfaces.empty() ? "(no network interface is up)"
                            : fmt::format("(interfaces: {})", fmt::join(interfaces, ", "));
}

std::string diagnose_silence(const Discovery& discovery, const Search& search) {
  const bool local = discovery.range == DiscoveryRange::localhost;
  const auto look =
      fmt::format("no ROS 2 node was found in domain {}{} within {:.0f} s {}", discovery.domain,
                  local ? " on this computer" : "", to_seconds(search.lasted), describe_interfaces(search.interfaces));
  if (discovery.range == DiscoveryRange::off) return look + ": ROS_AUTOMATIC_DISCOVERY_RANGE is OFF";
  if (search.participants > 0) {
    return fmt::format("{}, but {} participants of DDS without a topic: {}", look, search.participants,
                       discovery.enclave ? "they do not prove who they are, or are of another authority"
                                         : "they may want security (ROS_SECURITY_ENABLE), or be about to begin");
  }
  if (local) {
    return look +
           "; to look farther, set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET, or ROS_STATIC_PEERS to the robot's address";
  }
  return look + ": is ROS_DOMAIN_ID the robot's, and does the network let multicast through (else ROS_STATIC_PEERS)?";
}

Duration patience_with(const SensorInfo& sensor) {
  constexpr double kPeriods = 3.0;  // of a sensor that is not silent yet
  return std::max<Duration>(1s, from_seconds(kPeriods / sensor.rate));
}

diagnostic_msgs::DiagnosticStatus to_status(const RobotProfile& profile, std::string_view part, std::string mistake,
                                            std::optional<Duration> age, Duration patience) {
  constexpr std::byte kOk{0}, kError{2}, kStale{3};  // of diagnostic_msgs/msg/DiagnosticStatus
  diagnostic_msgs::DiagnosticStatus status;
  status.name = fmt::format("threewe: {}", part);
  status.hardware_id = profile.name;
  status.level = kOk;
  status.message = "ok";
  if (!age || *age > patience) {
    status.level = kStale;
    status.message = age ? fmt::format("no message for {:.1f} s", to_seconds(*age)) : "no message yet";
  }
  if (!mistake.empty()) {
    status.level = kError;
    status.message = std::move(mistake);
  }
  return status;
}

}  // namespace threewe::ros2
