#include "gazebo/node.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "threewe/core/errors.hpp"

namespace threewe::gazebo {
namespace {

using Type = msgs::Discovery::Type;

// As nodes of Gazebo have them.
constexpr auto kBeat = std::chrono::seconds(1);
constexpr auto kSilence = std::chrono::seconds(3);  // of a process that has ended

constexpr std::size_t kMostTopics = 10000;  // of what others say

std::string_view text_of(ByteView bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

Node::Node(const Settings& settings)
    : settings_(settings),
      publisher_(context_, zmq::Kind::publisher),
      subscriber_(context_, zmq::Kind::subscriber),
      requester_(context_, zmq::Kind::router),
      replies_(context_, zmq::Kind::router),
      messages_(settings, settings.message_port),
      services_(settings, settings.service_port),
      waker_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  const std::string ip = own_address(settings);
  address_ = publisher_.bind(ip);
  replies_.set_identity(reply_name_);
  reply_address_ = replies_.bind(ip);
  thread_ = std::thread([this] { run(); });
}

Node::~Node() {
  ended_ = true;
  wake();
  thread_.join();
  ::close(waker_);
}

// For other threads.

void Node::subscribe(const std::string& topic, const char* type, Receive receive) {
  const std::scoped_lock lock(mutex_);
  subscriptions_[full(topic)] = {type, std::move(receive)};
  next_beat_ = {};
  wake();
}

void Node::look_for(const std::string& service) {
  const std::scoped_lock lock(mutex_);
  sought_.insert(full(service));
  next_beat_ = {};
  wake();
}

void Node::advertise(const std::string& topic, const char* type) {
  const std::scoped_lock lock(mutex_);
  advertised_[full(topic)] = type;
  next_beat_ = {};
  wake();
}

void Node::publish(const std::string& topic, const char* type, ByteView message) {
  const std::scoped_lock lock(mutex_);
  outbox_.push_back({full(topic), type, std::string(text_of(message))});
  wake();
}

Bytes Node::request(const std::string& service, const char* request_type, const char* reply_type, ByteView message,
                    std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  const std::string name = unique_name();
  calls_[name] = {.service = full(service),
                  .request_type = request_type,
                  .reply_type = reply_type,
                  .message = std::string(text_of(message)),
                  .reply = std::nullopt};
  wake();
  const Call& call = calls_[name];
  replied_.wait_for(lock, patience, [&] { return call.reply || call.refused; });
  const Call ended = calls_.at(name);
  calls_.erase(name);
  if (ended.refused) throw ConnectionError(fmt::format("Gazebo refused {}", service));
  if (!ended.reply) {
    throw ConnectionError(fmt::format("Gazebo has not answered {} within {} s", service,
                                      std::chrono::duration<double>(patience).count()));
  }
  return *ended.reply;
}

std::string Node::type_of(const std::string& topic) const {
  const std::scoped_lock lock(mutex_);
  const auto found = publishers_.find(full(topic));
  if (found == publishers_.end() || found->second.empty()) return "";
  // of several the one that we want
  const auto wanted = subscriptions_.find(found->first);
  for (const msgs::Publisher& publisher : found->second) {
    if (wanted != subscriptions_.end() && publisher.message->type == wanted->second.type) return wanted->second.type;
  }
  return found->second.front().message->type;
}

bool Node::is_taken(const std::string& topic) const {
  const std::scoped_lock lock(mutex_);
  return taken_.contains(full(topic));
}

std::string Node::service_types(const std::string& service) const {
  const std::scoped_lock lock(mutex_);
  const auto found = offers_.find(full(service));
  if (found == offers_.end() || found->second.empty()) return "";
  const msgs::ServicePublisher& offer = *found->second.front().service;
  return offer.request_type + " -> " + offer.reply_type;
}

std::size_t Node::publishers(const std::string& topic, const std::string& type) const {
  const std::scoped_lock lock(mutex_);
  const auto found = publishers_.find(full(topic));
  if (found == publishers_.end()) return 0;
  return static_cast<std::size_t>(std::ranges::count(
      found->second, type, [](const msgs::Publisher& publisher) { return publisher.message->type; }));
}

std::size_t Node::offers(const std::string& service) const {
  const std::scoped_lock lock(mutex_);
  const auto found = offers_.find(full(service));
  return found == offers_.end() ? 0 : found->second.size();
}

std::vector<std::pair<std::string, std::string>> Node::services() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto& [name, publishers] : offers_) {
    const std::size_t end = name.find('@', 1);  // "@/partition@/service"
    if (publishers.empty() || !name.starts_with("@/") || end == std::string::npos) continue;
    names.emplace_back(name.substr(2, end - 2), name.substr(end + 1));
  }
  return names;
}

// The node's thread.

void Node::run() {
  while (!ended_) {
    std::array<zmq::PollItem, 6> items{{{.socket = subscriber_.get()},
                                        {.socket = replies_.get()},
                                        {.socket = publisher_.get()},
                                        {.descriptor = waker_},
                                        {.descriptor = messages_.descriptor()},
                                        {.descriptor = services_.descriptor()}}};
    bool waiting = false;
    {
      const std::scoped_lock lock(mutex_);
      waiting = std::ranges::any_of(calls_, [](const auto& call) { return !call.second.sent; });
    }
    zmq::poll(items, waiting ? 1 : 50);  // a connection that comes to be says nothing
    std::uint64_t count = 0;
    (void)!::read(waker_, &count, sizeof count);
    receive_subscription();
    find_others();
    beat();
    send_pending();
    receive_message();
    receive_reply();
  }
  for (const Multicast* group : {&messages_, &services_}) group->send(about(Type::bye));
}

void Node::find_others() {
  for (const msgs::Discovery& message : messages_.receive()) hear(message, false);
  for (const msgs::Discovery& message : services_.receive()) hear(message, true);
  forget_silent();
}

/// Says from time to time that we are here, what we publish, and what we look for.
void Node::beat() {
  const std::scoped_lock lock(mutex_);
  if (Clock::now() < next_beat_) return;
  next_beat_ = Clock::now() + kBeat;
  for (const Multicast* group : {&messages_, &services_}) group->send(about(Type::heartbeat));
  for (const auto& [topic, type] : advertised_) {
    msgs::Discovery message = about(Type::advertise);
    message.publisher = own(topic, type);
    messages_.send(message);
  }
  for (const auto& [topic, subscription] : subscriptions_) {
    msgs::Discovery message = about(Type::subscribe);
    message.subscriber = {topic};
    messages_.send(message);
  }
  for (const std::string& service : sought_) {
    msgs::Discovery message = about(Type::subscribe);
    message.subscriber = {service};
    services_.send(message);
  }
}

void Node::hear(const msgs::Discovery& message, bool service) {
  if (message.process == process_) return;
  const std::scoped_lock lock(mutex_);
  heard_[message.process] = Clock::now();
  if (message.type == Type::bye) return forget(message.process);
  if (message.type != Type::advertise && message.type != Type::unadvertise && message.type != Type::subscribe) return;
  if (message.type == Type::subscribe) {  // answered at once, for those who look
    if (!service && message.subscriber && advertised_.contains(message.subscriber->topic)) next_beat_ = {};
    return;
  }
  const auto& publisher = message.publisher;
  if (!publisher || !(service ? publisher->service.has_value() : publisher->message.has_value())) return;
  auto& known = service ? offers_ : publishers_;
  if (known.size() > kMostTopics) return;
  std::vector<msgs::Publisher>& publishers = known[publisher->topic];
  std::erase_if(publishers, [&](const msgs::Publisher& other) {
    return other.process == publisher->process && other.node == publisher->node;
  });
  if (message.type == Type::unadvertise) return;
  publishers.push_back(*publisher);
  if (!service) connect_to(*publisher);
}

void Node::forget(const std::string& process) {
  heard_.erase(process);
  for (auto* known : {&publishers_, &offers_}) {
    for (auto& [name, publishers] : *known) {
      std::erase_if(publishers, [&](const msgs::Publisher& one) { return one.process == process; });
    }
  }
}

void Node::forget_silent() {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> silent;
  for (const auto& [process, when] : heard_) {
    if (Clock::now() - when > kSilence) silent.push_back(process);
  }
  for (const std::string& process : silent) forget(process);
}

/// Where a process publishes what we subscribe to: connects, and says so to it, as it sends to subscribers only.
void Node::connect_to(const msgs::Publisher& publisher) {
  const auto wanted = subscriptions_.find(publisher.topic);
  if (wanted == subscriptions_.end() || publisher.message->type != wanted->second.type) return;
  try {
    if (!connected_.contains(publisher.address)) subscriber_.connect(publisher.address);
  } catch (const ConnectionError&) {
    return;  // an address that is none is another's mistake, and shows as a topic that is silent
  }
  connected_.insert(publisher.address);
  if (filtered_.insert(publisher.topic).second) subscriber_.subscribe(publisher.topic);
  msgs::Discovery message = about(Type::new_connection);
  message.publisher = publisher;
  message.publisher->process = process_;
  message.publisher->node = node_;
  message.publisher->message->control = publisher.process;
  messages_.send(message);
}

void Node::receive_message() {
  for (zmq::Frames frames = subscriber_.receive(); !frames.empty(); frames = subscriber_.receive()) {
    if (frames.size() < 4) continue;  // topic, sender, message, type
    Receive receive;
    {
      const std::scoped_lock lock(mutex_);
      const auto found = subscriptions_.find(frames[0]);
      if (found == subscriptions_.end() || found->second.type != frames[3]) continue;
      receive = found->second.receive;
    }
    receive(view(frames[2]));
  }
}

void Node::receive_reply() {
  for (zmq::Frames frames = replies_.receive(); !frames.empty(); frames = replies_.receive()) {
    if (frames.size() < 6) continue;  // identity, service, node, call, reply, result
    const std::scoped_lock lock(mutex_);
    const auto call = calls_.find(frames[3]);
    if (call == calls_.end()) continue;
    if (frames[5] == "1") {
      call->second.reply = Bytes(frames[4].begin(), frames[4].end());
    } else {
      call->second.refused = true;
    }
    replied_.notify_all();
  }
}

/// Subscribers say so to our socket: 1 and the topic, or 0 and the topic once the last has unsubscribed.
void Node::receive_subscription() {
  for (zmq::Frames frames = publisher_.receive(); !frames.empty(); frames = publisher_.receive()) {
    if (frames[0].empty()) continue;
    const std::scoped_lock lock(mutex_);
    if (frames[0][0] == 1) taken_.insert(frames[0].substr(1));
    if (frames[0][0] == 0) taken_.erase(frames[0].substr(1));
  }
}

void Node::send_pending() {
  const std::scoped_lock lock(mutex_);
  for (const auto& [topic, type, message] : std::exchange(outbox_, {})) {
    publisher_.send(std::array<std::string_view, 4>{topic, address_, message, type});
  }
  for (auto& [name, call] : calls_) {
    const auto found = offers_.find(call.service);
    if (call.sent || found == offers_.end()) continue;
    for (const msgs::Publisher& offer : found->second) {
      if (offer.service->request_type != call.request_type || offer.service->reply_type != call.reply_type) continue;
      try {
        if (!connected_.contains(offer.address)) requester_.connect(offer.address);
      } catch (const ConnectionError&) {
        continue;
      }
      connected_.insert(offer.address);
      call.sent = requester_.send(std::array<std::string_view, 9>{offer.service->socket, call.service, reply_address_,
                                                                  reply_name_, node_, name, call.message,
                                                                  call.request_type, call.reply_type});
      if (call.sent) break;
    }
  }
}

void Node::wake() const {
  const std::uint64_t one = 1;
  (void)!::write(waker_, &one, sizeof one);
}

std::string Node::full(std::string_view name) const {
  const std::string_view slash = settings_.partition.starts_with('/') ? "" : "/";
  return fmt::format("@{}{}@{}", slash, settings_.partition, name);
}

msgs::Discovery Node::about(Type type) const {
  msgs::Discovery message;
  message.process = process_;
  message.type = type;
  return message;
}

msgs::Publisher Node::own(const std::string& topic, const std::string& type) const {
  msgs::Publisher publisher;
  publisher.topic = topic;
  publisher.address = address_;
  publisher.process = process_;
  publisher.node = node_;
  publisher.scope = msgs::Publisher::kEverywhere;
  publisher.message = msgs::MessagePublisher{.control = {}, .type = type};
  return publisher;
}

}  // namespace threewe::gazebo
