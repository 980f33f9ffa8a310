// ROS 2 node on Cyclone DDS: publishers, subscriptions, and the graph of all nodes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "ros2/cdr.hpp"
#include "ros2/dds/library.hpp"
#include "ros2/dds/raw_type.hpp"
#include "ros2/discovery.hpp"
#include "ros2/endpoint.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "threewe/core/time.hpp"

namespace threewe::ros2 {

/// What Cyclone DDS made, and all that belongs to it; deleted with this.
struct Entity {
  Entity() = default;
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  ~Entity();
  dds_entity_t id = 0;
};

/// A domain of Cyclone DDS in this process; all nodes of one share it.
class Domain {
 public:
  /// Throws ContractError where there is one with other options, ConnectionError where there can be none.
  static std::shared_ptr<Domain> get(const Discovery& discovery);
  explicit Domain(Discovery discovery);

  int number() const { return discovery_.domain; }

 private:
  Discovery discovery_;
  Entity entity_;
};

/// Whether another node has begun a handshake by a key in a form that Cyclone DDS cannot read, in this process so far.
bool received_unreadable_key();

/// A node. One thread at a time may use it; what arrives is handed over in threads of Cyclone's.
class Node {
 public:
  /// Called with each payload as it arrives, and with a number that stands for its publisher. Must not use the node.
  using Receiver = std::function<void(std::span<const std::uint8_t> payload, std::uint64_t publisher)>;
  /// The same with the reply to a request, and the request's number.
  using ReplyReceiver = std::function<void(std::span<const std::uint8_t> payload, std::int64_t request)>;
  /// An endpoint of this node, for `publish` and `peers`.
  struct Handle {
    std::size_t index = 0;
  };

  /// Throws as `Domain::get`.
  Node(const Discovery& discovery, std::string name_space, std::string name);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// `topic` as ROS has it, "/scan"; `type` is one of `message_types()`.
  Handle advertise(const std::string& topic, std::string_view type, const Qos& qos);
  Handle subscribe(const std::string& topic, std::string_view type, const Qos& qos, Receiver receiver);
  /// What calls a service.
  struct Client {
    Handle requests, replies;
    std::string service;
  };
  /// `service` as ROS has it, "/spin"; types are those of its requests and replies, such as
  /// "std_srvs/srv/Empty_Request".
  Client add_client(const std::string& service, std::string_view request_type, std::string_view reply_type,
                    ReplyReceiver receiver);
  /// Whether there is a server. Only then a request arrives for certain, and so does its reply.
  bool has_server(const Client& client);
  /// Sends a request; its number.
  std::int64_t call(const Client& client, const Payload& request);
  /// Sends a message of the endpoint's type.
  void publish(Handle publisher, const Payload& payload);
  /// Waits until reliable subscriptions have all that was sent, for this long [wall] at most.
  void wait_until_received(Handle publisher, Duration wall);
  /// How many subscriptions a publisher has, or publishers a subscription.
  std::size_t peers(Handle endpoint);
  /// How many messages a subscription has lost so far.
  std::size_t lost(Handle subscription);

  /// Every endpoint of other nodes that has been discovered, by topic.
  std::vector<Endpoint> endpoints();
  /// How many participants of DDS have been discovered, each of a program on the network, whether or not it has
  /// endpoints.
  std::size_t participants();
  /// Announces this node again to those that read another layout. Call it now and then.
  void refresh();

 private:
  struct Part;
  Handle add(std::unique_ptr<Part> part, const std::string& topic, std::string_view type, const Qos& qos);
  bool expects_header(const Client& client);
  std::vector<Endpoint> discovered(dds_entity_t reader, bool publishes);
  void introduce();
  Distribution graph_layout();
  void note_nodes(std::span<const std::uint8_t> payload);

  std::shared_ptr<Domain> domain_;
  std::string name_space_;
  std::string name_;
  dds_entity_t participants_ = 0;
  dds_entity_t publications_ = 0;
  dds_entity_t subscriptions_ = 0;
  std::vector<std::unique_ptr<Part>> parts_;
  // how this node tells the graph of itself
  dds_entity_t graph_topic_ = 0;
  dds_entity_t graph_writer_ = 0;
  Distribution graph_layout_ = Distribution::jazzy;
  // what others announced: nodes by the 16 bytes of an endpoint; in threads of Cyclone's
  std::mutex mutex_;
  std::map<std::array<std::uint8_t, 16>, std::string> nodes_;
  Entity participant_;  // last: its readers end with it, and with them the threads that call receivers
};

}  // namespace threewe::ros2
