#include "env/observations.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace threewe::env {
namespace {

constexpr double kFarthest = 1000.0;  // [m] a robot can believe to be

std::size_t element_bytes(task::Field::Type type) { return type == task::Field::Type::uint8 ? 1 : 4; }

}  // namespace

std::vector<task::Field> observation_fields(const Options& options, const std::vector<task::Field>& task_fields) {
  using Type = task::Field::Type;
  const RobotProfile& profile = options.hardware;
  const auto width = static_cast<std::size_t>(options.image_width);
  const auto height = static_cast<std::size_t>(options.image_height);
  std::vector<task::Field> fields;
  if (options.observed.image) fields.push_back({"image", Type::uint8, {height, width, 3}, 0.0, 255.0});
  if (options.observed.depth) {
    fields.push_back({"depth", Type::float32, {height, width}, 0.0, profile.camera->depth->range_max});
  }
  if (options.observed.lidar) {
    const auto beams = static_cast<std::size_t>(options.lidar_beams);
    fields.push_back({"lidar", Type::float32, {beams}, 0.0, profile.lidar->range_max});
  }
  if (options.observed.pose) fields.push_back({"pose", Type::float32, {3}, -kFarthest, kFarthest});
  // wheels that spin, and noise, go beyond the limits
  const double fastest = 4.0 * std::max(profile.hardware_limits.linear, profile.hardware_limits.angular);
  if (options.observed.velocity) fields.push_back({"velocity", Type::float32, {3}, -fastest, fastest});
  const auto& wanted = options.observed.task_fields;
  for (const task::Field& field : task_fields) {
    if (!wanted || std::ranges::find(*wanted, field.name) != wanted->end()) fields.push_back(field);
  }
  return fields;
}

std::vector<bool> which_are_among(const std::vector<task::Field>& fields, const std::vector<task::Field>& task_fields) {
  std::vector<bool> among;
  for (const task::Field& field : task_fields) {
    among.push_back(std::ranges::find(fields, field.name, &task::Field::name) != fields.end());
  }
  return among;
}

std::vector<Array> make_arrays(const std::vector<task::Field>& fields, std::size_t rows) {
  std::vector<Array> arrays;
  for (const task::Field& field : fields) {
    Array& array = arrays.emplace_back();
    array.field = field;
    array.row_bytes = std::accumulate(field.shape.begin(), field.shape.end(), element_bytes(field.type),
                                      [](std::size_t a, std::size_t b) { return a * b; });
    array.data.resize(rows * array.row_bytes);
  }
  return arrays;
}

void put(const std::array<double, 3>& values, std::span<std::byte> to) {
  const std::array<float, 3> floats{static_cast<float>(values[0]), static_cast<float>(values[1]),
                                    static_cast<float>(values[2])};
  if (!to.empty()) std::memcpy(to.data(), floats.data(), sizeof(floats));
}

void put_scan(std::span<const float> scan, std::span<std::byte> to) {
  const std::size_t beams = to.size() / sizeof(float);
  if (scan.empty()) {
    std::ranges::fill(to, std::byte{});
  } else if (beams == scan.size()) {
    std::memcpy(to.data(), scan.data(), to.size());
  } else if (beams > 0) {
    const std::size_t k = scan.size() / beams;
    for (std::size_t i = 0; i < beams; ++i) std::memcpy(&to[i * sizeof(float)], &scan[i * k], sizeof(float));
  }
}

}  // namespace threewe::env
