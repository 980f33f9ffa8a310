// Byte serialization of samples and plain data, field by field, so that no padding gets in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "threewe/core/errors.hpp"
#include "threewe/core/samples.hpp"

namespace threewe {

/// What is wrong with bytes that are to be a saved world.
inline constexpr const char* kNotSaved = "restore: these bytes are no saved world";

/// Appends values to a buffer.
class ByteWriter {
 public:
  template <typename T>
    requires std::is_trivially_copyable_v<T>
  void put(const T& value) {
    const std::size_t size = bytes_.size();
    bytes_.resize(size + sizeof(T));
    std::memcpy(bytes_.data() + size, &value, sizeof(T));
  }
  void put(const std::string& text) {
    put(std::uint64_t{text.size()});
    put_bytes(std::as_bytes(std::span(text)));
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    if constexpr (std::is_trivially_copyable_v<T>) {
      put_bytes(std::as_bytes(std::span(values)));
    } else {
      for (const T& value : values) put(value);
    }
  }
  /// As they are, without their count.
  void put_bytes(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void put(const Sample& sample) {
    put(sample.sensor);
    put(sample.measured);
    put(static_cast<std::uint8_t>(sample.data.index()));
    std::visit([this](const auto& data) { put(data); }, sample.data);
  }
  void put(const LaserScan& scan) {
    for (const double value :
         {scan.angle_min, scan.angle_increment, scan.time_increment, scan.range_min, scan.range_max}) {
      put(value);
    }
    put(scan.ranges);
  }
  /// Nothing: a picture is drawn again from what was in sight, which its world saves.
  void put(const Picture&) {}

  std::size_t size() const { return bytes_.size(); }
  /// Forgets what was appended beyond a size.
  void shrink(std::size_t size) { bytes_.resize(size); }
  /// Replaces what was put at a place.
  template <typename T>
    requires std::is_trivially_copyable_v<T>
  void put_at(std::size_t place, const T& value) {
    std::memcpy(bytes_.data() + place, &value, sizeof(T));
  }
  std::vector<std::byte> take() { return std::exchange(bytes_, {}); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads them back. Throws ContractError with a message of its maker's where they end too early or cannot have been
/// written.
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> bytes, const char* complaint) : bytes_(bytes), complaint_(complaint) {}

  template <typename T>
    requires std::is_trivially_copyable_v<T>
  void get(T& value) {
    require(bytes_.size() >= sizeof(T));
    std::memcpy(static_cast<void*>(&value), bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    require(byte <= 1);
    value = byte == 1;
  }
  /// A count of things that take at least a byte each.
  std::size_t get_size() {
    std::uint64_t size = 0;
    get(size);
    require(size <= bytes_.size());
    return size;
  }
  void get(std::string& text) {
    const auto bytes = get_bytes(get_size());
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  template <typename T>
  void get(std::vector<T>& values) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      const std::size_t size = get_size();
      require(size <= bytes_.size() / sizeof(T));
      values.resize(size);
      const auto bytes = get_bytes(size * sizeof(T));
      if (size > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    } else {
      values.resize(get_size());
      for (T& value : values) get(value);
    }
  }
  /// So many of them, valid as long as what is read.
  std::span<const std::byte> get_bytes(std::size_t count) {
    require(count <= bytes_.size());
    const auto bytes = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return bytes;
  }
  bool at_end() const { return bytes_.empty(); }
  void get(Sample& sample) {
    get(sample.sensor);
    get(sample.measured);
    std::uint8_t type = 0;
    get(type);
    switch (static_cast<SensorType>(type)) {
      case SensorType::lidar: get(sample.data.emplace<LaserScan>()); return;
      case SensorType::imu: get(sample.data.emplace<IMUData>()); return;
      case SensorType::odometry: get(sample.data.emplace<Odometry>()); return;
      case SensorType::battery: get(sample.data.emplace<BatteryState>()); return;
      case SensorType::ultrasonic: get(sample.data.emplace<RangeData>()); return;
      case SensorType::camera: sample.data.emplace<Picture>(); return;
    }
    require(false);
  }
  void get(LaserScan& scan) {
    for (double* value :
         {&scan.angle_min, &scan.angle_increment, &scan.time_increment, &scan.range_min, &scan.range_max}) {
      get(*value);
    }
    get(scan.ranges);
  }
  /// Throws unless everything was read.
  void finish() const { require(bytes_.empty()); }

 private:
  void require(bool ok) const {
    if (!ok) throw ContractError(complaint_);
  }
  std::span<const std::byte> bytes_;
  const char* complaint_;
};

}  // namespace threewe
