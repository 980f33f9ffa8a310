// A ROS 2 node on Fast DDS with the code that fastddsgen made: what a micro-ROS agent shows of a microcontroller.
#pragma once

#include <cstdlib>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

namespace fast = eprosima::fastdds::dds;

/// Best effort and volatile, as firmware publishes; no type hash, as the agent has none, unless `user_data` has one.
class Node {
 public:
  explicit Node(unsigned domain, std::string user_data = {})
      : user_data_(std::move(user_data)),
        participant_(fast::DomainParticipantFactory::get_instance()->create_participant(domain, participant_qos())) {
    if (participant_ == nullptr) throw std::runtime_error("no participant");
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  }
  ~Node() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// `type` as DDS has it.
  template <typename Support>
  fast::DataWriter* advertise(const std::string& topic, const std::string& type, bool reliable = false) {
    fast::DataWriterQos qos;
    qos.reliability().kind = reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
    qos.history().depth = reliable ? 100 : 1;
    qos.user_data().setValue({user_data_.begin(), user_data_.end()});
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    return checked(publisher_->create_datawriter(make_topic<Support>("rt" + topic, type), qos), topic);
  }
  /// Of a service, a topic that stays, or an action's: `topic` as DDS has it, reliable, `user_data` as rmw has it.
  template <typename Support>
  fast::DataWriter* offer(const std::string& topic, const std::string& type, bool kept,
                          const std::string& user_data = {}) {
    fast::DataWriterQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = kept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
    qos.history().depth = kept ? 1 : 10;
    qos.user_data().setValue({user_data.begin(), user_data.end()});
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    return checked(publisher_->create_datawriter(make_topic<Support>(topic, type), qos), topic);
  }
  /// The other end of such a one.
  template <typename Support>
  void take(const std::string& topic, const std::string& type, fast::DataReaderListener& listener,
            const std::string& user_data = {}) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 10;
    qos.user_data().setValue({user_data.begin(), user_data.end()});
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    checked(subscriber_->create_datareader(make_topic<Support>(topic, type), qos, &listener), topic);
  }
  /// Reliable, and kept for those who come later: the graph of nodes. `topic` as DDS has it.
  template <typename Support>
  void join_graph(const std::string& topic, const std::string& type, fast::DataReaderListener& listener) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    checked(subscriber_->create_datareader(make_topic<Support>(topic, type), qos, &listener), topic);
  }
  /// Reliable, with all that is kept for those who come later where `kept`.
  template <typename Support>
  void record(const std::string& topic, const std::string& type, bool kept, fast::DataReaderListener& listener) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = kept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;  // of all, it shows pieces of what is still to come
    qos.history().depth = 200;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    checked(subscriber_->create_datareader(make_topic<Support>("rt" + topic, type), qos, &listener), topic);
  }
  template <typename Support>
  void subscribe(const std::string& topic, const std::string& type, fast::DataReaderListener& listener) {
    fast::DataReaderQos qos;
    qos.reliability().kind = fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    checked(subscriber_->create_datareader(make_topic<Support>("rt" + topic, type), qos, &listener), topic);
  }

 private:
  // an image is one burst of packets, more than the kernel keeps by default
  static fast::DomainParticipantQos participant_qos() {
    fast::DomainParticipantQos qos;
    qos.transport().listen_socket_buffer_size = 4 << 20;
    if (const char* enclave = std::getenv("THREEWE_TEST_ENCLAVE")) secure(qos, std::string("file://") + enclave + "/");
    return qos;
  }
  // as rmw_fastrtps does, with the files of an enclave
  static void secure(fast::DomainParticipantQos& qos, const std::string& enclave) {
    const auto set = [&](const char* name, const std::string& value) {
      qos.properties().properties().emplace_back(name, value);
    };
    set("dds.sec.auth.plugin", "builtin.PKI-DH");
    set("dds.sec.auth.builtin.PKI-DH.identity_ca", enclave + "identity_ca.cert.pem");
    set("dds.sec.auth.builtin.PKI-DH.identity_certificate", enclave + "cert.pem");
    set("dds.sec.auth.builtin.PKI-DH.private_key", enclave + "key.pem");
    set("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
    set("dds.sec.access.plugin", "builtin.Access-Permissions");
    set("dds.sec.access.builtin.Access-Permissions.permissions_ca", enclave + "permissions_ca.cert.pem");
    set("dds.sec.access.builtin.Access-Permissions.governance", enclave + "governance.p7s");
    set("dds.sec.access.builtin.Access-Permissions.permissions", enclave + "permissions.p7s");
  }
  template <typename Support>
  fast::Topic* make_topic(const std::string& topic, const std::string& type) {
    fast::TypeSupport support(new Support());
    support->auto_fill_type_object(false);
    support->auto_fill_type_information(false);
    support.register_type(participant_, type);
    return checked(participant_->create_topic(topic, type, fast::TOPIC_QOS_DEFAULT), topic);
  }
  template <typename T>
  static T* checked(T* made, const std::string& topic) {
    if (made == nullptr) throw std::runtime_error("no endpoint of " + topic);
    return made;
  }

  std::string user_data_;  // of what it advertises
  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
};
