#include "env/observations.hpp"

#include <algorithm>
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

}  // namespace threewe::env
