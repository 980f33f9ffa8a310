#include "ros2/link_proposal.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "hardware/link.hpp"
#include "ros2/diagnosis.hpp"

namespace threewe::ros2 {
namespace {

// What a topic may be used for.
struct Role {
  std::string sensor;
  std::vector<std::string> types;  // the preferred one first
  bool we_publish = false;
};

std::vector<Role> roles_of(const RobotProfile& profile) {
  std::vector<Role> roles;
  for (auto& [sensor, types] : deliverables(profile)) roles.push_back({sensor, types});
  roles.push_back({"command", command_types(), true});
  return roles;
}

// Lower case, without what separates words.
std::string plain(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) letters += static_cast<char>(std::tolower(c));
  }
  return letters;
}

const TopicSpec* topic_of(const RobotProfile& profile, std::string_view sensor) {
  if (!profile.link) return nullptr;
  if (sensor == "command") return &profile.link->command;
  const auto found = std::ranges::find(profile.link->topics, sensor, &TopicSpec::sensor);
  return found == profile.link->topics.end() ? nullptr : &*found;
}

bool is_offered(const Endpoint& endpoint, const Role& role) {
  return endpoint.publishes != role.we_publish && std::ranges::find(role.types, endpoint.type) != role.types.end();
}

// Higher for what fits better.
int fit(const Endpoint& endpoint, const Role& role, const RobotProfile& profile) {
  const TopicSpec* usual = topic_of(profile, role.sensor);
  const std::string name = plain(endpoint.topic);
  int points = 0;
  if (usual != nullptr && usual->topic == endpoint.topic) points += 8;
  if (name.find(plain(role.sensor)) != std::string::npos) points += 4;
  if (role.sensor == "command" && endpoint.topic.ends_with("/cmd_vel")) points += 4;
  if (role.sensor == "camera" && name.find("depth") != std::string::npos) points -= 16;
  if (endpoint.type == role.types.front()) points += 2;
  return points;
}

std::string why_unused(const Endpoint& endpoint, const std::vector<Role>& roles, const LinkProposal& proposal) {
  if (endpoint.type.empty()) return "its type is none of ROS 2";
  for (const Role& role : roles) {
    if (std::ranges::find(role.types, endpoint.type) == role.types.end()) continue;
    const auto used = std::ranges::find(proposal.topics, role.sensor, &TopicUse::sensor);
    if (used != proposal.topics.end()) return fmt::format("{} is {}", role.sensor, used->topic);
    return role.we_publish ? "no node subscribes to it" : "no node publishes it";
  }
  const std::string_view sensor = sensor_of(endpoint.type);
  return sensor.empty() ? "no sensor comes as this type" : fmt::format("the profile has no {}", sensor);
}

std::string write(const RobotProfile& profile, const std::vector<TopicUse>& used) {
  std::string yaml = "link:\n  driver: ros2\n  topics:\n";
  std::string command;
  for (const TopicUse& use : used) {
    const std::string entry = fmt::format("{{topic: {}, type: {}", use.topic, use.type);
    if (use.sensor == "command") {
      command = entry + (profile.link && profile.link->shared_command ? ", shared: true}" : "}");
    } else if (!use.sensor.empty()) {
      yaml += fmt::format("    {}: {}}}\n", use.sensor, entry);
    }
  }
  if (!command.empty()) yaml += fmt::format("  command: {}\n", command);
  if (!profile.link)
    return yaml + "  # stops: {by: WHO, after: SECONDS} # once velocities cease; measure it before it drives\n";
  const LinkSpec& link = *profile.link;
  yaml += fmt::format("  frames: {{map: {}, odom: {}, base: {}}}\n", link.map_frame, link.odom_frame, link.base_frame);
  return yaml + fmt::format("  stops: {{by: {}, after: {}}}\n", link.stopped_by, to_seconds(link.stopped_after));
}

}  // namespace

LinkProposal propose_link(const RobotProfile& profile, const std::vector<Endpoint>& endpoints) {
  const std::vector<Role> roles = roles_of(profile);
  LinkProposal proposal;

  // the best topic for each role, each topic for one
  std::set<std::string> taken;
  for (const Role& role : roles) {
    const Endpoint* best = nullptr;
    for (const Endpoint& endpoint : endpoints) {
      if (!is_offered(endpoint, role) || taken.contains(endpoint.topic) || !endpoint.topic.starts_with('/')) continue;
      if (has_unknown_hash(endpoint)) continue;
      if (best == nullptr || fit(endpoint, role, profile) > fit(*best, role, profile)) best = &endpoint;
    }
    if (best == nullptr) {
      proposal.missing.push_back(role.sensor);
    } else {
      taken.insert(best->topic);
      proposal.topics.push_back({best->topic, best->type, role.sensor, ""});
    }
  }
  proposal.yaml = write(profile, proposal.topics);

  // and why not the others
  std::vector<TopicUse> others;
  for (const Endpoint& endpoint : endpoints) {
    const auto same = [&](const TopicUse& use) { return use.topic == endpoint.topic && use.type == endpoint.type; };
    if (!endpoint.topic.starts_with('/') || std::ranges::any_of(proposal.topics, same) ||
        std::ranges::any_of(others, same)) {
      continue;
    }
    const std::string reason = has_unknown_hash(endpoint) ? "no distribution that we know has its type so"
                                                          : why_unused(endpoint, roles, proposal);
    others.push_back({endpoint.topic, endpoint.type, "", reason});
  }
  std::ranges::move(others, std::back_inserter(proposal.topics));
  std::ranges::stable_sort(proposal.topics, {}, &TopicUse::topic);
  return proposal;
}

}  // namespace threewe::ros2
