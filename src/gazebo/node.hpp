// Node of Gazebo's transport: finds others, exchanges messages by topics, and asks services.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "gazebo/messages.hpp"
#include "gazebo/network.hpp"
#include "gazebo/zmq.hpp"

namespace threewe::gazebo {

/// One node, in a thread of its own. All methods may be called from any other thread; topics and services are named
/// without their partition, such as "/clock".
class Node {
 public:
  using Receive = std::function<void(ByteView)>;

  /// Throws ConfigError where ZeroMQ cannot be loaded, ConnectionError where there is no network to talk over.
  explicit Node(const Settings& settings);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  ~Node();

  /// Hands each message of a topic to `receive`, in the node's thread, in the order in which one process sent them.
  void subscribe(const std::string& topic, const char* type, Receive receive);
  /// Asks who offers a service, so that it is found sooner than it is said anew.
  void look_for(const std::string& service);
  /// Says that we publish a topic.
  void advertise(const std::string& topic, const char* type);
  /// Sends a message of a topic that was advertised.
  void publish(const std::string& topic, const char* type, ByteView message);
  /// The reply of a service. Throws ConnectionError where none came in time, or the service said no.
  Bytes request(const std::string& service, const char* request_type, const char* reply_type, ByteView message,
                std::chrono::milliseconds patience);

  // What was found so far.

  /// The type that is published there; empty without a publisher.
  std::string type_of(const std::string& topic) const;
  /// Whether what we publish there has a subscriber.
  bool is_taken(const std::string& topic) const;
  /// The types of a service, as "request -> reply"; empty without a server.
  std::string service_types(const std::string& service) const;
  /// How many processes offer a service.
  std::size_t offers(const std::string& service) const;
  /// How many publish that type on a topic.
  std::size_t publishers(const std::string& topic, const std::string& type) const;
  /// The names of all services, in our partition or in any other: "partition", "name".
  std::vector<std::pair<std::string, std::string>> services() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Subscription {
    std::string type;
    Receive receive;
  };
  struct Call {
    std::string service;
    std::string request_type;
    std::string reply_type;
    std::string message;
    bool sent = false;
    std::optional<Bytes> reply;
    bool refused = false;
  };

  void run();
  void find_others();
  void beat();
  void hear(const msgs::Discovery& message, bool service);
  void forget(const std::string& process);
  void forget_silent();
  void connect_to(const msgs::Publisher& publisher);
  void receive_message();
  void receive_reply();
  void receive_subscription();
  void send_pending();
  void wake() const;
  std::string full(std::string_view name) const;
  msgs::Discovery about(msgs::Discovery::Type type) const;
  msgs::Publisher own(const std::string& topic, const std::string& type) const;

  const Settings settings_;
  const std::string process_ = unique_name();
  const std::string node_ = unique_name();
  const std::string reply_name_ = unique_name();
  zmq::Context context_;
  zmq::Socket publisher_;
  zmq::Socket subscriber_;
  zmq::Socket requester_;
  zmq::Socket replies_;
  Multicast messages_;
  Multicast services_;
  std::string address_;        // of what we publish
  std::string reply_address_;  // where replies go
  int waker_ = -1;

  // of the node's thread alone
  std::set<std::string> connected_;  // addresses, of publishers and of services
  std::set<std::string> filtered_;   // topics

  mutable std::mutex mutex_;  // of what follows
  Clock::time_point next_beat_{};
  std::condition_variable replied_;
  std::map<std::string, Subscription> subscriptions_;               // by full topic
  std::set<std::string> sought_;                                    // full services
  std::map<std::string, std::string> advertised_;                   // full topic: type
  std::vector<std::array<std::string, 3>> outbox_;                  // full topic, type, message
  std::map<std::string, Call> calls_;                               // by name of the call
  std::map<std::string, std::vector<msgs::Publisher>> publishers_;  // by full topic
  std::map<std::string, std::vector<msgs::Publisher>> offers_;      // by full service
  std::map<std::string, Clock::time_point> heard_;                  // process: when last
  std::set<std::string> taken_;                                     // full topics of ours
  std::atomic<bool> ended_ = false;
  std::thread thread_;  // last: it uses all of this
};

}  // namespace threewe::gazebo
