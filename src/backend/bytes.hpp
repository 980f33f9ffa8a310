// Byte serialization of a saved world, field by field, so that no padding gets in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "threewe/core/errors.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::backend {

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
    for (const char c : text) put(c);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    for (const T& value : values) put(value);
  }
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

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Throws ContractError where the bytes end too early or cannot have been saved.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
    requires std::is_trivially_copyable_v<T>
  void get(T& value) {
    require(bytes_.size() >= sizeof(T));
    std::memcpy(static_cast<void*>(&value), bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
  }
  /// A count of things that take at least a byte each.
  std::size_t get_size() {
    std::uint64_t size = 0;
    get(size);
    require(size <= bytes_.size());
    return size;
  }
  void get(std::string& text) {
    text.resize(get_size());
    for (char& c : text) get(c);
  }
  template <typename T>
  void get(std::vector<T>& values) {
    values.resize(get_size());
    for (T& value : values) get(value);
  }
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
  static void require(bool ok) {
    if (!ok) throw ContractError("restore: these bytes are no saved world");
  }
  std::span<const std::byte> bytes_;
};

}  // namespace threewe::backend
