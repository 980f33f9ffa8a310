#include "ros2/dds/raw_type.hpp"

#include <algorithm>
#include <cstring>
#include <memory>

namespace threewe::ros2 {
namespace {

struct Sample : ddsi_serdata {
  Payload payload;
  std::int64_t number = 0;
  std::optional<RequestId> answered;
};

constexpr unsigned char kData = 0x15;  // a kind of submessage

// Of a submessage, in its byte order.
std::uint64_t integer(std::span<const unsigned char> submessage, std::size_t at, std::size_t size) {
  const bool little = (submessage[1] & 1U) != 0;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= std::uint64_t{submessage[at + i]} << 8 * (little ? i : size - 1 - i);
  }
  return value;
}

// Of 64 bits, the upper half first.
std::int64_t sequence_number(std::span<const unsigned char> submessage, std::size_t at) {
  return static_cast<std::int64_t>(integer(submessage, at, 4) << 32U | integer(submessage, at + 4, 4));
}

// The parameters that stand before the payload in a DATA submessage. Those of a reply name the request, in one of
// eProsima's own since Fast DDS 2.6 and in one of the standard's since 2.10.
std::optional<RequestId> find_request(std::span<const unsigned char> submessage, std::size_t parameters) {
  constexpr std::uint16_t kSentinel = 1;
  constexpr std::uint16_t kOfStandard = 0x0083;
  constexpr std::uint16_t kOfEprosima = 0x800f;
  for (std::size_t at = parameters; at + 4 <= submessage.size();) {
    const auto id = static_cast<std::uint16_t>(integer(submessage, at, 2));
    const auto size = static_cast<std::size_t>(integer(submessage, at + 2, 2));
    at += 4;
    if (id == kSentinel || at + size > submessage.size()) return std::nullopt;
    if ((id == kOfStandard || id == kOfEprosima) && size >= 24) {
      RequestId request;
      std::copy_n(submessage.begin() + static_cast<std::ptrdiff_t>(at), request.writer.size(), request.writer.begin());
      request.number = sequence_number(submessage, at + 16);
      return request;
    }
    at += size;
  }
  return std::nullopt;
}

// What stands before the payload, in the packet that it came in; empty where that is not known.
std::span<const unsigned char> submessage_of(const nn_rdata& data) {
  constexpr unsigned kLeast = 24;
  const unsigned begin = NN_RDATA_SUBMSG_OFF(&data);
  const unsigned end = NN_RDATA_PAYLOAD_OFF(&data);
  if (begin == 0 || end < begin + kLeast) return {};
  return {reinterpret_cast<const unsigned char*>(data.rmsg + 1) + begin, end - begin};
}

// Which of all that its writer has written.
std::int64_t number_in(const nn_rdata& data) {
  constexpr unsigned char kFragment = 0x16;
  const auto submessage = submessage_of(data);
  const bool known = !submessage.empty() && (submessage[0] == kData || submessage[0] == kFragment);
  return known ? sequence_number(submessage, 16) : 0;
}

// Of an unfragmented sample: replies are small.
std::optional<RequestId> request_in(const nn_rdata& data) {
  constexpr unsigned char kHasParameters = 2;
  const auto submessage = submessage_of(data);
  if (submessage.empty() || submessage[0] != kData || (submessage[1] & kHasParameters) == 0) return std::nullopt;
  // the header is of 4 bytes; what follows says from where on it counts to the parameters
  return find_request(submessage, 8 + static_cast<std::size_t>(integer(submessage, 6, 2)));
}

Sample* make_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto sample = std::make_unique<Sample>();
  library().ddsi_serdata_init(sample.get(), type, kind);
  sample->payload.resize(size);
  return sample.release();
}

const Sample& as_sample(const ddsi_serdata* data) { return *static_cast<const Sample*>(data); }

// All samples are of one instance: no ROS message has a key.
bool has_equal_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }

std::uint32_t size_of(const ddsi_serdata* data) { return static_cast<std::uint32_t>(as_sample(data).payload.size()); }

ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                             std::size_t size) {
  Sample* sample = make_sample(type, kind, size);
  sample->answered = request_in(*fragment);
  sample->number = number_in(*fragment);
  std::uint32_t filled = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::uint32_t end = std::min<std::uint32_t>(fragment->maxp1, static_cast<std::uint32_t>(size));
    if (end <= filled) continue;  // all of it came before
    const auto* packet = reinterpret_cast<const unsigned char*>(fragment->rmsg + 1);
    const unsigned char* begin = packet + NN_RDATA_PAYLOAD_OFF(fragment) + (filled - fragment->min);
    std::memcpy(sample->payload.data() + filled, begin, end - filled);
    filled = end;
  }
  return sample;
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, std::size_t size) {
  Sample* sample = make_sample(type, kind, size);
  std::size_t filled = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && filled < size; ++i) {
    const std::size_t length = std::min<std::size_t>(pieces[i].iov_len, size - filled);
    std::memcpy(sample->payload.data() + filled, pieces[i].iov_base, length);
    filled += length;
  }
  return sample;
}

ddsi_serdata* from_key(const ddsi_sertype* type, const ddsi_keyhash*) { return make_sample(type, SDK_KEY, 0); }

ddsi_serdata* from_payload(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* payload) {
  Sample* sample = make_sample(type, kind, 0);
  if (kind != SDK_DATA) return sample;
  sample->payload = *static_cast<const Payload*>(payload);
  // as other ROS 2 nodes on Cyclone do, which reads whole words of what it sends
  sample->payload.resize((sample->payload.size() + 3) / 4 * 4);
  return sample;
}

void copy_part(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* buffer) {
  std::memcpy(buffer, as_sample(data).payload.data() + offset, size);
}

ddsi_serdata* lend_part(const ddsi_serdata* data, std::size_t offset, std::size_t size, ddsrt_iovec_t* part) {
  part->iov_base = const_cast<std::uint8_t*>(as_sample(data).payload.data()) + offset;
  part->iov_len = size;
  return ddsi_serdata_ref(data);
}

void give_back_part(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }

bool copy_payload(const ddsi_serdata* data, void* payload, void**, void*) {
  *static_cast<Payload*>(payload) = as_sample(data).payload;
  return true;
}

ddsi_serdata* without_type(const ddsi_serdata* data) {
  Sample* sample = make_sample(data->type, SDK_KEY, 0);
  sample->type = nullptr;
  return sample;
}

bool key_to_payload(const ddsi_sertype*, const ddsi_serdata*, void* payload, void**, void*) {
  static_cast<Payload*>(payload)->clear();
  return true;
}

void free_sample(ddsi_serdata* data) { delete static_cast<Sample*>(data); }

std::size_t print(const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t size) {
  if (size > 0) text[0] = '\0';
  return 0;
}

void get_key_hash(const ddsi_serdata*, ddsi_keyhash* hash, bool) { *hash = {}; }

constexpr ddsi_serdata_ops kSampleOps{
    .eqkey = has_equal_key,
    .get_size = size_of,
    .from_ser = from_fragments,
    .from_ser_iov = from_pieces,
    .from_keyhash = from_key,
    .from_sample = from_payload,
    .to_ser = copy_part,
    .to_ser_ref = lend_part,
    .to_ser_unref = give_back_part,
    .to_sample = copy_payload,
    .to_untyped = without_type,
    .untyped_to_sample = key_to_payload,
    .free = free_sample,
    .print = print,
    .get_keyhash = get_key_hash,
    .get_sample_size = nullptr,
    .from_iox_buffer = nullptr,
};

void free_type(ddsi_sertype* type) {
  library().ddsi_sertype_fini(type);
  delete type;
}

void zero_payloads(const ddsi_sertype*, void* payloads, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) static_cast<Payload*>(payloads)[i].clear();
}

// Cyclone lends no payloads: all are taken as they arrived.
void grow_payloads(void** payloads, const ddsi_sertype*, void*, std::size_t, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) payloads[i] = nullptr;
}

void free_payloads(const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {}

bool is_equal(const ddsi_sertype*, const ddsi_sertype*) { return true; }
std::uint32_t hash(const ddsi_sertype*) { return 0; }

const ddsi_sertype_ops& type_ops() {
  static const ddsi_sertype_ops ops{
      .version = library().ddsi_sertype_v0,
      .arg = nullptr,
      .free = free_type,
      .zero_samples = zero_payloads,
      .realloc_samples = grow_payloads,
      .free_samples = free_payloads,
      .equal = is_equal,
      .hash = hash,
      .type_id = nullptr,
      .type_map = nullptr,
      .type_info = nullptr,
      .derive_sertype = nullptr,
      .get_serialized_size = nullptr,
      .serialize_into = nullptr,
  };
  return ops;
}

}  // namespace

dds_entity_t create_topic(dds_entity_t participant, const std::string& topic, const std::string& type) {
  auto* raw = new ddsi_sertype{};
  constexpr bool kNoKey = true;
  library().ddsi_sertype_init(raw, type.c_str(), &type_ops(), &kSampleOps, kNoKey);
  raw->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  const dds_entity_t entity =
      library().dds_create_topic_sertype(participant, topic.c_str(), &raw, nullptr, nullptr, nullptr);
  if (entity < 0) free_type(raw);
  return checked(entity, "no topic " + topic + " of type " + type);
}

std::optional<RequestId> answered_by(const ddsi_serdata& sample) { return as_sample(&sample).answered; }

std::int64_t number_of(const ddsi_serdata& sample) { return as_sample(&sample).number; }

std::span<const std::uint8_t> payload_of(const ddsi_serdata& sample) { return as_sample(&sample).payload; }

}  // namespace threewe::ros2
