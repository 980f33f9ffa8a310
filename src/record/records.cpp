#include "record/records.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/bounds.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::record {
namespace {

constexpr const char* kBroken = "a record cannot have been written";
constexpr std::uint32_t kFormat = 2;

constexpr std::uint32_t kMostPixels = 8192;  // along either side, as in profiles

void require(bool ok) {
  if (!ok) throw ContractError(kBroken);
}

template <typename... Fields>
void put_fields(ByteWriter& bytes, const Fields&... fields) {
  (bytes.put(fields), ...);
}
template <typename... Fields>
void get_fields(ByteReader& bytes, Fields&... fields) {
  (bytes.get(fields), ...);
}

// The fields of a payload that begins with the robot's number, which is returned.
template <typename... Fields>
std::uint8_t parse_fields(std::span<const std::byte> payload, Fields&... fields) {
  ByteReader bytes(payload, kBroken);
  std::uint8_t robot = 0;
  get_fields(bytes, robot, fields...);
  bytes.finish();
  return robot;
}

// Throws for what is not UTF-8.
void check(const Metadata& metadata) {
  for (const auto& [name, value] : metadata) {
    check_text(name);
    if (const auto* text = std::get_if<std::string>(&value)) check_text(*text);
  }
}

void put_metadata(ByteWriter& bytes, const Metadata& metadata) {
  bytes.put(std::uint64_t{metadata.size()});
  for (const auto& [name, value] : metadata) {
    bytes.put(name);
    bytes.put(static_cast<std::uint8_t>(value.index()));
    std::visit([&](const auto& plain) { bytes.put(plain); }, value);
  }
}

// The alternative of that number, read.
template <std::size_t I = 0>
void get_value(ByteReader& bytes, std::uint8_t index, Metadata::mapped_type& value) {
  if constexpr (I == std::variant_size_v<Metadata::mapped_type>) {
    require(false);
  } else if (index == I) {
    bytes.get(value.emplace<I>());
  } else {
    get_value<I + 1>(bytes, index, value);
  }
}

Metadata get_metadata(ByteReader& bytes) {
  Metadata metadata;
  for (std::size_t left = bytes.get_size(); left > 0; --left) {
    std::string name;
    std::uint8_t index = 0;
    bytes.get(name);
    bytes.get(index);
    get_value(bytes, index, metadata[name]);
  }
  return metadata;
}

// Whether there is one, and what it is.
template <typename T>
void put_optional(ByteWriter& bytes, const std::optional<T>& value) {
  put_fields(bytes, value.has_value(), value.value_or(T{}));
}
template <typename T>
void get_optional(ByteReader& bytes, std::optional<T>& value) {
  bool there = false;
  T read{};
  get_fields(bytes, there, read);
  if (there) value = read;
}

void put_robot(ByteWriter& bytes, const RecordedRobot& robot) {
  bytes.put(robot.profile);
  bytes.put(robot.hardware);
  put_optional(bytes, robot.scene_from_map);
  bytes.put(std::uint64_t{robot.sensors.size()});
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    bytes.put(robot.sensors[i].name);
    bytes.put(robot.sensors[i].type);
    bytes.put(robot.sensors[i].rate);
    bytes.put(robot.cameras[i]);
  }
}

RecordedRobot get_robot(ByteReader& bytes) {
  RecordedRobot robot;
  bytes.get(robot.profile);
  bytes.get(robot.hardware);
  get_optional(bytes, robot.scene_from_map);
  for (std::size_t left = bytes.get_size(); left > 0; --left) {
    SensorInfo& sensor = robot.sensors.emplace_back();
    bytes.get(sensor.name);
    bytes.get(sensor.type);
    bytes.get(sensor.rate);
    bytes.get(robot.cameras.emplace_back());
    require(sensor.type <= SensorType::camera);
  }
  return robot;
}

// Calls `visit` with all fields of how a world was made, in the order of the format.
template <typename Origin, typename Visit>
void with_options(Origin& origin, const Visit& visit) {
  auto& o = origin.options;
  visit(origin.backend, o.scene, o.robots, o.noise, o.seed, o.poses, o.randomization);
}

void put_key(ByteWriter& bytes, const FrameKey& key) {
  bytes.put(key.robot);
  bytes.put(key.sensor);
  bytes.put(key.sequence);
  bytes.put(key.width);
  bytes.put(key.height);
}
constexpr std::size_t kKeySize = 1 + 2 + 8 + 4 + 4;

// Calls `visit` with all fields of a tick, in the order of the format.
template <typename Tick, typename Visit>
auto with_fields(Tick& t, const Visit& visit) {
  return visit(t.now, t.map_from_base, t.odom_from_base, t.velocity, t.requested, t.executed, t.intervention, t.lost,
               t.takeover, t.simulated, t.true_pose, t.true_velocity);
}

}  // namespace

// By a library's judgement of what JSON can hold.
void check_text(const std::string& text) {
  try {
    (void)nlohmann::json(text).dump();
  } catch (const nlohmann::json::exception&) {
    throw ContractError("task, instruction and metadata must be UTF-8 text");
  }
}

// A record whose payload is what `write` puts.
template <typename Write>
void RecordWriter::append(RecordType type, const Write& write) {
  const std::size_t start = bytes_.size();
  try {
    bytes_.put(type);
    const std::size_t size_at = bytes_.size();
    bytes_.put(std::uint32_t{0});
    const std::size_t payload = bytes_.size();
    write();
    bytes_.put_at(size_at, static_cast<std::uint32_t>(bytes_.size() - payload));
  } catch (...) {
    bytes_.shrink(start);
    throw;
  }
}

void RecordWriter::put(const Header& header) {
  check_text(header.task);
  check(header.metadata);
  append(RecordType::begin, [&] {
    bytes_.put(kFormat);
    bytes_.put(std::uint64_t{header.episode});
    bytes_.put(header.task);
    put_metadata(bytes_, header.metadata);
    bytes_.put(header.started);
    bytes_.put(header.began);
    bytes_.put(static_cast<std::uint8_t>(header.robots.size()));
    for (const RecordedRobot& robot : header.robots) put_robot(bytes_, robot);
    bytes_.put(header.origin.has_value());
    if (!header.origin) return;
    with_options(*header.origin, [&](const auto&... fields) { put_fields(bytes_, fields...); });
    put_optional(bytes_, header.origin->options.image_size);
  });
}

void RecordWriter::put(const Footer& footer) {
  check(footer.metadata);
  append(RecordType::end, [&] {
    put_optional(bytes_, footer.success);
    bytes_.put(footer.recovered);
    put_metadata(bytes_, footer.metadata);
  });
}

void RecordWriter::put_state(std::span<const std::byte> state) {
  append(RecordType::state, [&] { bytes_.put_bytes(state); });
}

void RecordWriter::put(std::uint8_t robot, const RecordedTick& tick) {
  append(RecordType::tick, [&] {
    bytes_.put(robot);
    with_fields(tick, [&](const auto&... fields) { put_fields(bytes_, fields...); });
  });
}

void RecordWriter::put(std::uint8_t robot, const Sample& sample) {
  append(RecordType::sample, [&] { put_fields(bytes_, robot, sample.sequence, sample.received, sample); });
}

void RecordWriter::put(std::uint8_t robot, const RecordedStep& step) {
  append(RecordType::step, [&] { put_fields(bytes_, robot, step.now, step.action); });
}

void RecordWriter::put(std::uint8_t robot, const RecordedInstruction& instruction) {
  append(RecordType::instruction, [&] { put_fields(bytes_, robot, instruction.now, instruction.text); });
}

void RecordWriter::put_color(const FrameKey& key, bool encoded, std::span<const std::byte> image) {
  append(RecordType::color, [&] {
    put_key(bytes_, key);
    bytes_.put(encoded);
    bytes_.put_bytes(image);
  });
}

void RecordWriter::put_depth(const FrameKey& key, std::span<const float> depth) {
  constexpr float kMost = 65.535F;  // [m]
  std::vector<std::byte> planes(2 * depth.size());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const float metres = depth[i];
    const bool valid = metres > 0.0F && metres <= kMost;
    const auto millimetres = static_cast<std::uint16_t>(valid ? std::lround(1000.0F * metres) : 0);
    planes[i] = static_cast<std::byte>(millimetres & 0xFFU);
    planes[depth.size() + i] = static_cast<std::byte>(millimetres >> 8U);
  }
  append(RecordType::depth, [&] {
    put_key(bytes_, key);
    bytes_.put_bytes(planes);
  });
}

std::vector<Record> parse_records(std::span<const std::byte> content) {
  ByteReader bytes(content, kBroken);
  std::vector<Record> records;
  while (!bytes.at_end()) {
    RecordType type = RecordType::begin;
    std::uint32_t size = 0;
    bytes.get(type);
    bytes.get(size);
    records.push_back({type, bytes.get_bytes(size)});
  }
  return records;
}

Header parse_header(std::span<const std::byte> payload) {
  ByteReader bytes(payload, kBroken);
  Header header;
  std::uint32_t format = 0;
  std::uint64_t episode = 0;
  std::uint8_t robots = 0;
  bytes.get(format);
  if (format != kFormat) {
    throw ContractError(fmt::format("its format is {}, this version of 3we reads {}", format, kFormat));
  }
  get_fields(bytes, episode, header.task);
  header.episode = episode;
  header.metadata = get_metadata(bytes);
  get_fields(bytes, header.started, header.began, robots);
  require(robots > 0);
  for (std::uint8_t i = 0; i < robots; ++i) header.robots.push_back(get_robot(bytes));
  bool made_by_name = false;
  bytes.get(made_by_name);
  if (made_by_name) {
    World::Origin& origin = header.origin.emplace();
    with_options(origin, [&](auto&... fields) { get_fields(bytes, fields...); });
    get_optional(bytes, origin.options.image_size);
    require(origin.options.noise <= NoiseLevel::ideal);
  }
  bytes.finish();
  return header;
}

Footer parse_footer(std::span<const std::byte> payload) {
  ByteReader bytes(payload, kBroken);
  Footer footer;
  get_optional(bytes, footer.success);
  bytes.get(footer.recovered);
  footer.metadata = get_metadata(bytes);
  bytes.finish();
  return footer;
}

std::uint8_t parse(std::span<const std::byte> payload, RecordedTick& tick) {
  return with_fields(tick, [&](auto&... fields) { return parse_fields(payload, fields...); });
}

std::uint8_t parse(std::span<const std::byte> payload, Sample& sample) {
  return parse_fields(payload, sample.sequence, sample.received, sample);
}

std::uint8_t parse(std::span<const std::byte> payload, RecordedStep& step) {
  return parse_fields(payload, step.now, step.action);
}

std::uint8_t parse(std::span<const std::byte> payload, RecordedInstruction& instruction) {
  return parse_fields(payload, instruction.now, instruction.text);
}

std::span<const std::byte> parse_image(std::span<const std::byte> payload, RecordType type, FrameKey& key,
                                       bool& encoded) {
  ByteReader bytes(payload, kBroken);
  get_fields(bytes, key.robot, key.sensor, key.sequence, key.width, key.height);
  encoded = false;
  if (type == RecordType::color) bytes.get(encoded);
  const auto image = bytes.get_bytes(payload.size() - kKeySize - (type == RecordType::color ? 1 : 0));
  require(key.width <= kMostPixels && key.height <= kMostPixels);
  const std::size_t pixels = std::size_t{key.width} * key.height;
  require(encoded || image.size() == pixels * (type == RecordType::color ? 3 : 2));
  return image;
}

std::vector<std::uint16_t> parse_depth(std::span<const std::byte> bytes) {
  const std::size_t count = bytes.size() / 2;
  std::vector<std::uint16_t> depth(count);
  for (std::size_t i = 0; i < count; ++i) {
    depth[i] = static_cast<std::uint16_t>(std::to_integer<unsigned>(bytes[i]) |
                                          std::to_integer<unsigned>(bytes[count + i]) << 8U);
  }
  return depth;
}

}  // namespace threewe::record
