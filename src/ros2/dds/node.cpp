#include "ros2/dds/node.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "ros2/diagnosis.hpp"
#include "ros2/message_types.hpp"
#include "ros2/network_interfaces.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

using rmw_dds_common::Gid;
using rmw_dds_common::ParticipantEntitiesInfo;

constexpr const char* kGraphTopic = "ros_discovery_info";
constexpr Qos kGraphQos{.reliable = true, .transient_local = true, .depth = 1};
constexpr std::uint32_t kMostEndpoints = 4096;
constexpr std::uint32_t kMostParticipants = 256;
constexpr std::uint32_t kAtATime = 16;         // samples taken from a reader
constexpr std::ptrdiff_t kRequestHeader = 16;  // [bytes] before requests and replies of ROS 2 on Cyclone DDS
constexpr Qos kServiceQos{.reliable = true, .transient_local = false, .depth = 10};

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { library().dds_delete_qos(qos); }
};
struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { library().dds_delete_listener(listener); }
};
using QosPointer = std::unique_ptr<dds_qos_t, QosDeleter>;

QosPointer make_qos(const Qos& qos, const std::string& user_data) {
  const Library& dds = library();
  QosPointer made(dds.dds_create_qos());
  dds.dds_qset_reliability(made.get(), qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                           DDS_MSECS(100));
  dds.dds_qset_durability(made.get(), qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds.dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  if (qos.transient_local) {  // what is kept for those who come later is settled here, not by the history
    dds.dds_qset_durability_service(made.get(), 0, DDS_HISTORY_KEEP_LAST, qos.depth, DDS_LENGTH_UNLIMITED,
                                    DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  dds.dds_qset_writer_data_lifecycle(made.get(), false);
  dds.dds_qset_userdata(made.get(), user_data.data(), user_data.size());
  return made;
}

std::string user_data_of(const dds_qos_t* qos) {
  void* value = nullptr;
  std::size_t size = 0;
  if (!library().dds_qget_userdata(qos, &value, &size) || value == nullptr) return "";
  std::string text(static_cast<const char*>(value), size);
  library().dds_free(value);
  return text;
}

// The value of `key` in "key=value;key=value;".
std::string value_in(std::string_view user_data, std::string_view key) {
  while (!user_data.empty()) {
    const std::string_view pair = user_data.substr(0, user_data.find(';'));
    if (pair.starts_with(key) && pair.substr(key.size()).starts_with('=')) {
      return std::string(pair.substr(key.size() + 1));
    }
    user_data.remove_prefix(std::min(user_data.size(), pair.size() + 1));
  }
  return "";
}

std::array<std::uint8_t, 16> bytes_of(const dds_guid_t& guid) {
  std::array<std::uint8_t, 16> bytes{};
  std::memcpy(bytes.data(), guid.v, bytes.size());
  return bytes;
}

std::array<std::uint8_t, 16> bytes_of(const Gid& gid) {
  std::array<std::uint8_t, 16> bytes{};
  std::copy_n(gid.data.begin(), bytes.size(), bytes.begin());
  return bytes;
}

Gid gid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  checked(library().dds_get_guid(entity, &guid), "no GUID");
  Gid gid;
  std::memcpy(gid.data.data(), guid.v, sizeof guid.v);
  return gid;
}

// What Cyclone DDS says of a handshake it says in its log alone. Lines go where they go else, and this one is looked
// for.
std::atomic<bool> g_unreadable_key = false;

void pass_on(void*, const dds_log_data_t* line) {
  const std::string_view message(line->message, line->size);
  if (message.find("octet sequence to ASN1 integer") != std::string_view::npos) g_unreadable_key = true;
  std::fwrite(line->message - line->hdrsize, 1, line->hdrsize + line->size + 1, stderr);
}

// What Cyclone DDS says while it lives, instead of where that goes else.
class Log {
 public:
  Log() { library().dds_set_log_sink(&Log::add, this); }
  ~Log() { library().dds_set_log_sink(&pass_on, nullptr); }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  std::string text() {
    const std::scoped_lock lock(mutex_);
    return text_;
  }

 private:
  static void add(void* self, const dds_log_data_t* line) {
    Log& log = *static_cast<Log*>(self);
    const std::scoped_lock lock(log.mutex_);
    log.text_ += fmt::format("\n  {}", std::string_view(line->message, line->size));
    while (log.text_.ends_with('\n')) log.text_.pop_back();
  }
  std::mutex mutex_;
  std::string text_;
};

[[noreturn]] void fail_to_begin(const Discovery& discovery, const std::string& said) {
  if (discovery.enclave) {
    throw ConfigError(fmt::format("the security enclave '{}' in {} is not accepted by Cyclone DDS:{}",
                                  discovery.enclave->name, discovery.enclave->folder.string(), said));
  }
  throw ConnectionError(fmt::format("Cyclone DDS cannot begin in ROS domain {} {}{}", discovery.domain,
                                    describe_interfaces(network_interfaces()), said));
}

dds_entity_t create_participant(const Discovery& discovery) {
  const Library& dds = library();
  const QosPointer qos(dds.dds_create_qos());
  const std::string enclave = fmt::format("enclave={};", discovery.enclave ? discovery.enclave->name : "/");
  dds.dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
  if (discovery.enclave) {
    for (const auto& [name, value] : security_properties(*discovery.enclave)) {
      dds.dds_qset_prop(qos.get(), name.c_str(), value.c_str());
    }
  }
  Log said;
  const auto domain = static_cast<dds_domainid_t>(discovery.domain);
  const dds_entity_t participant = dds.dds_create_participant(domain, qos.get(), nullptr);
  if (participant < 0) fail_to_begin(discovery, said.text());
  return participant;
}

std::string join_name(std::string_view name_space, std::string_view name) {
  return name_space == "/" ? fmt::format("/{}", name) : fmt::format("{}/{}", name_space, name);
}

// "/scan" of what DDS calls "rt/scan".
std::string ros_topic(std::string_view dds_topic) {
  return std::string(dds_topic.starts_with("rt/") ? dds_topic.substr(2) : dds_topic);
}

}  // namespace

bool received_unreadable_key() { return g_unreadable_key; }

// Domains.

std::shared_ptr<Domain> Domain::get(const Discovery& discovery) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Domain>> domains;
  const std::scoped_lock lock(mutex);
  std::weak_ptr<Domain>& known = domains[discovery.domain];
  std::shared_ptr<Domain> domain = known.lock();
  if (!domain) known = domain = std::make_shared<Domain>(discovery);
  if (domain->discovery_ == discovery) return domain;
  throw ContractError(fmt::format(
      "a node of ROS domain {} is alive that was made with another discovery range or peers", discovery.domain));
}

Domain::Domain(Discovery discovery) : discovery_(std::move(discovery)) {
  const std::string configuration = cyclone_configuration(discovery_);
  if (configuration.empty()) return;  // made with the first participant, as the environment says
  Log said;
  entity_.id = library().dds_create_domain(static_cast<dds_domainid_t>(discovery_.domain), configuration.c_str());
  if (entity_.id < 0) fail_to_begin(discovery_, said.text());
}

Entity::~Entity() {
  if (id > 0) library().dds_delete(id);
}

// Nodes.

namespace {

/// Counts what is lost between the messages of each publisher.
class Losses {
 public:
  void note(std::uint64_t publisher, std::int64_t number) {
    const std::scoped_lock lock(mutex_);
    std::int64_t& newest = newest_[publisher];
    if (newest > 0 && number > newest + 1) count_ += static_cast<std::size_t>(number - newest - 1);
    newest = std::max(newest, number);
  }
  std::size_t count() {
    const std::scoped_lock lock(mutex_);
    return count_;
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, std::int64_t> newest_;
  std::size_t count_ = 0;
};

}  // namespace

/// A publisher or a subscription of a node.
struct Node::Part {
  bool publishes = false;
  Receiver receiver = nullptr;
  dds_entity_t entity = 0;
  // of a client: its replies, and what it has requested
  ReplyReceiver replies = nullptr;
  std::array<std::uint8_t, 16> requester = {};
  std::int64_t requests = 0;
  std::unique_ptr<Losses> losses = std::make_unique<Losses>();

  // In a thread of Cyclone's, perhaps before `entity` is set.
  void take(dds_entity_t reader) const {
    std::array<ddsi_serdata*, kAtATime> samples{};
    std::vector<dds_sample_info_t> infos(kAtATime);
    for (;;) {
      const auto count = library().dds_takecdr(reader, samples.data(), kAtATime, infos.data(), DDS_ANY_STATE);
      for (std::size_t i = 0; std::cmp_less(i, count); ++i) {
        if (infos[i].valid_data && number_of(*samples[i]) > 0)
          losses->note(infos[i].publication_handle, number_of(*samples[i]));
        if (infos[i].valid_data && receiver) receiver(payload_of(*samples[i]), infos[i].publication_handle);
        if (infos[i].valid_data && replies) take_reply(*samples[i]);
        ddsi_serdata_unref(samples[i]);
      }
      if (std::cmp_less(count, kAtATime)) return;
    }
  }

  // All clients of a service get all replies. Servers on Fast DDS name the request beside the reply, those on Cyclone
  // DDS before it.
  void take_reply(const ddsi_serdata& sample) const {
    const std::span<const std::uint8_t> payload = payload_of(sample);
    if (const auto answered = answered_by(sample)) {
      if (answered->writer == requester) replies(payload, answered->number);
      return;
    }
    if (payload.size() < kEncapsulation + kRequestHeader) return;
    const auto header = payload.subspan(kEncapsulation, kRequestHeader);
    if (!std::equal(header.begin(), header.begin() + 8, requester.begin() + 8)) return;
    std::int64_t number = 0;
    std::memcpy(&number, header.data() + 8, sizeof number);
    Payload rest(payload.begin(), payload.end());
    rest.erase(rest.begin() + kEncapsulation, rest.begin() + kEncapsulation + kRequestHeader);
    replies(rest, number);
  }
};

Node::Node(const Discovery& discovery, std::string name_space, std::string name)
    : domain_(Domain::get(discovery)), name_space_(std::move(name_space)), name_(std::move(name)) {
  participant_.id = create_participant(discovery);
  publications_ =
      checked(library().dds_create_reader(participant_.id, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
              "no discovery");
  participants_ =
      checked(library().dds_create_reader(participant_.id, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr),
              "no discovery");
  subscriptions_ =
      checked(library().dds_create_reader(participant_.id, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
              "no discovery");

  const auto note = [this](std::span<const std::uint8_t> payload, std::uint64_t) { note_nodes(payload); };
  add(std::make_unique<Part>(Part{.publishes = false, .receiver = note}), kGraphTopic, ParticipantEntitiesInfo::kType,
      {.reliable = true, .transient_local = true, .depth = 1000});
  introduce();
}

Node::~Node() = default;

Node::Handle Node::advertise(const std::string& topic, std::string_view type, const Qos& qos) {
  return add(std::make_unique<Part>(Part{.publishes = true}), "rt" + topic, type, qos);
}

Node::Handle Node::subscribe(const std::string& topic, std::string_view type, const Qos& qos, Receiver receiver) {
  return add(std::make_unique<Part>(Part{.publishes = false, .receiver = std::move(receiver)}), "rt" + topic, type,
             qos);
}

Node::Handle Node::add(std::unique_ptr<Part> part, const std::string& topic, std::string_view type, const Qos& qos) {
  const Library& dds = library();
  const dds_entity_t dds_topic = create_topic(participant_.id, topic, dds_type_name(type));
  const QosPointer made = make_qos(qos, fmt::format("typehash={};", message_type(type).hash(Distribution::jazzy)));
  const std::string what = fmt::format("no endpoint of topic {}", topic);
  if (part->publishes) {
    part->entity = checked(dds.dds_create_writer(participant_.id, dds_topic, made.get(), nullptr), what);
  } else {
    const std::unique_ptr<dds_listener_t, ListenerDeleter> listener(dds.dds_create_listener(part.get()));
    dds.dds_lset_data_available(listener.get(),
                                [](dds_entity_t reader, void* self) { static_cast<const Part*>(self)->take(reader); });
    part->entity = checked(dds.dds_create_reader(participant_.id, dds_topic, made.get(), listener.get()), what);
  }
  parts_.push_back(std::move(part));
  if (graph_writer_ > 0) introduce();
  return {parts_.size() - 1};
}

Node::Client Node::add_client(const std::string& service, std::string_view request_type, std::string_view reply_type,
                              ReplyReceiver receiver) {
  Client client{.requests = add(std::make_unique<Part>(Part{.publishes = true}), "rq" + service + "Request",
                                request_type, kServiceQos),
                .replies = {},
                .service = service};
  auto part = std::make_unique<Part>(Part{.publishes = false, .replies = std::move(receiver)});
  dds_guid_t guid{};
  checked(library().dds_get_guid(parts_[client.requests.index]->entity, &guid), "no GUID");
  part->requester = bytes_of(guid);
  client.replies = add(std::move(part), "rr" + service + "Reply", reply_type, kServiceQos);
  return client;
}

bool Node::has_server(const Client& client) { return peers(client.requests) > 0 && peers(client.replies) > 0; }

bool Node::expects_header(const Client& client) {
  return std::ranges::any_of(endpoints(), [topic = "rq" + client.service + "Request"](const Endpoint& endpoint) {
    return endpoint.topic == topic && !endpoint.publishes && endpoint.of_cyclone_service;
  });
}

std::int64_t Node::call(const Client& client, const Payload& request) {
  const std::int64_t number = ++parts_[client.requests.index]->requests;
  if (!expects_header(client)) {
    publish(client.requests, request);
    return number;
  }
  // half of the writer's name, by which it knows its replies, and the number; an alignment of 8 bytes stays as it was
  std::array<std::uint8_t, kRequestHeader> header{};
  const auto& name = parts_[client.replies.index]->requester;
  std::copy(name.begin() + 8, name.end(), header.begin());
  std::memcpy(header.data() + 8, &number, sizeof number);
  Payload with_header = request;
  with_header.insert(with_header.begin() + kEncapsulation, header.begin(), header.end());
  publish(client.requests, with_header);
  return number;
}

void Node::publish(Handle publisher, const Payload& payload) {
  checked(library().dds_write(parts_[publisher.index]->entity, &payload), "a message was not sent");
}

void Node::wait_until_received(Handle publisher, Duration wall) {
  (void)library().dds_wait_for_acks(parts_[publisher.index]->entity, wall.count());  // some may be gone
}

std::size_t Node::peers(Handle endpoint) {
  const Part& part = *parts_[endpoint.index];
  const auto count = part.publishes ? library().dds_get_matched_subscriptions(part.entity, nullptr, 0)
                                    : library().dds_get_matched_publications(part.entity, nullptr, 0);
  return static_cast<std::size_t>(std::max<std::int32_t>(count, 0));
}

std::size_t Node::lost(Handle subscription) { return parts_[subscription.index]->losses->count(); }

// The graph.

std::vector<Endpoint> Node::endpoints() {
  std::vector<Endpoint> all = discovered(publications_, true);
  std::ranges::move(discovered(subscriptions_, false), std::back_inserter(all));
  std::ranges::stable_sort(all, {}, &Endpoint::topic);
  return all;
}

std::vector<Endpoint> Node::discovered(dds_entity_t reader, bool publishes) {
  const Library& dds = library();
  std::vector<void*> samples(kMostEndpoints, nullptr);
  std::vector<dds_sample_info_t> infos(kMostEndpoints);
  const auto count = dds.dds_read(reader, samples.data(), infos.data(), kMostEndpoints, kMostEndpoints);
  checked(count, "no discovery");
  dds_guid_t own{};
  checked(dds.dds_get_guid(participant_.id, &own), "no GUID");

  std::vector<Endpoint> found;
  for (std::size_t i = 0; std::cmp_less(i, count); ++i) {
    const auto& sample = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    const bool alive = infos[i].valid_data && infos[i].instance_state == DDS_ALIVE_INSTANCE_STATE;
    if (!alive || std::memcmp(sample.participant_key.v, own.v, sizeof own.v) == 0) continue;
    dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
    dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
    dds.dds_qget_reliability(sample.qos, &reliability, nullptr);
    dds.dds_qget_durability(sample.qos, &durability);
    Endpoint& endpoint = found.emplace_back();
    endpoint.publishes = publishes;
    endpoint.topic = ros_topic(sample.topic_name);
    endpoint.type = ros_type_name(sample.type_name);
    const std::string user_data = user_data_of(sample.qos);
    endpoint.hash = value_in(user_data, "typehash");
    endpoint.of_cyclone_service = !value_in(user_data, "serviceid").empty();
    endpoint.qos = {reliability == DDS_RELIABILITY_RELIABLE, durability != DDS_DURABILITY_VOLATILE, 0};
    endpoint.guid = bytes_of(sample.key);
    const std::scoped_lock lock(mutex_);
    const auto node = nodes_.find(endpoint.guid);
    if (node != nodes_.end()) endpoint.node = node->second;
  }
  if (count > 0) dds.dds_return_loan(reader, samples.data(), count);
  return found;
}

std::size_t Node::participants() {
  std::array<void*, kMostParticipants> samples{};
  std::vector<dds_sample_info_t> infos(kMostParticipants);
  const auto count =
      checked(library().dds_read(participants_, samples.data(), infos.data(), kMostParticipants, kMostParticipants),
              "no discovery");
  const auto end = infos.begin() + count;
  const auto alive = std::count_if(infos.begin(), end, [](const dds_sample_info_t& info) {
    return info.valid_data && info.instance_state == DDS_ALIVE_INSTANCE_STATE;
  });
  if (count > 0) library().dds_return_loan(participants_, samples.data(), count);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(alive - 1, 0));  // one of them is this node
}

/// Which layout of the graph's message the others read: two of them on one topic misread each other.
Distribution Node::graph_layout() {
  bool humble = false;
  for (const Endpoint& endpoint : endpoints()) {
    if (endpoint.topic != kGraphTopic) continue;
    if (!endpoint.hash.empty()) return Distribution::jazzy;
    humble = true;
  }
  return humble ? Distribution::humble : graph_layout_;
}

/// Tells the graph of this node and its endpoints, which `ros2 node list` and `ros2 topic info -v` show.
void Node::introduce() {
  const Library& dds = library();
  const Distribution layout = graph_layout();
  if (graph_topic_ == 0) {
    graph_topic_ = create_topic(participant_.id, kGraphTopic, dds_type_name(ParticipantEntitiesInfo::kType));
  }
  if (graph_writer_ > 0 && layout != graph_layout_) dds.dds_delete(std::exchange(graph_writer_, 0));
  graph_layout_ = layout;
  if (graph_writer_ == 0) {
    const bool hashed = layout != Distribution::humble;
    const std::string hash = message_type(ParticipantEntitiesInfo::kType).hash(layout);
    const QosPointer qos = make_qos(kGraphQos, hashed ? fmt::format("typehash={};", hash) : "");
    graph_writer_ = checked(dds.dds_create_writer(participant_.id, graph_topic_, qos.get(), nullptr), "no graph");
  }

  ParticipantEntitiesInfo info;
  info.gid = gid_of(participant_.id);
  auto& node = info.node_entities_info_seq.emplace_back();
  node.node_namespace.assign(name_space_);
  node.node_name.assign(name_);
  for (const auto& part : parts_) {
    if (part == parts_.front()) continue;  // the reader of this very topic is of the participant, not of a node
    (part->publishes ? node.writer_gid_seq : node.reader_gid_seq).push_back(gid_of(part->entity));
  }
  const Payload payload = encode(info, layout);
  checked(dds.dds_write(graph_writer_, &payload), "the graph was not informed");
}

void Node::refresh() {
  if (graph_layout() != graph_layout_) introduce();
}

void Node::note_nodes(std::span<const std::uint8_t> payload) {
  auto info = decode<ParticipantEntitiesInfo>(payload, Distribution::jazzy);
  if (!info) info = decode<ParticipantEntitiesInfo>(payload, Distribution::humble);
  if (!info) return;  // another's mistake, which costs names in a list alone
  const std::scoped_lock lock(mutex_);
  for (const auto& node : info->node_entities_info_seq) {
    for (const auto* gids : {&node.reader_gid_seq, &node.writer_gid_seq}) {
      for (const Gid& gid : *gids) nodes_[bytes_of(gid)] = join_name(node.node_namespace, node.node_name);
    }
  }
}

}  // namespace threewe::ros2
