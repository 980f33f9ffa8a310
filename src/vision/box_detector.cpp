#include "vision/box_detector.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/config.hpp"
#include "core/exact.hpp"
#include "threewe/core/errors.hpp"
#include "vision/color_terms.hpp"

namespace threewe::vision {
namespace {

constexpr std::size_t kMostLabels = 1000;
constexpr std::size_t kMostBoxes = 200;     // of one picture, the surest
constexpr double kSmallest = 0.02;          // [m] of a radius
constexpr double kLargest = 20.0;           // [m]
constexpr double kColumns = 40.0;           // cells across a picture, as those of the detector that ships
constexpr int kColorSamples = 20;           // each way in the middle of a box
constexpr double kFarthestDistance = 50.0;  // [m]

struct Box {
  double x_min = 0.0, y_min = 0.0, x_max = 0.0, y_max = 0.0;
  std::size_t label = 0;     // of the layout
  const float* scores = {};  // of all labels

  double area() const { return (x_max - x_min) * (y_max - y_min); }
  float score() const { return scores[label]; }
};

double overlap_of(const Box& a, const Box& b) {
  const double width = std::min(a.x_max, b.x_max) - std::max(a.x_min, b.x_min);
  const double height = std::min(a.y_max, b.y_max) - std::max(a.y_min, b.y_min);
  if (width <= 0.0 || height <= 0.0) return 0.0;
  return width * height / (a.area() + b.area() - width * height);
}

std::array<double, 3> three(const ConfigNode& node, double low) {
  const auto items = node.items();
  if (items.size() != 3) node.fail(fmt::format("expected three numbers, one of each channel, got {}", items.size()));
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) values[i] = items[i].number_in(low, 1e4);
  return values;
}

// The sure boxes within the picture, each with its best label; none that is not used.
std::vector<Box> sure_boxes(const BoxRows& rows, const BoxLayout& layout, const CameraIntrinsics& camera) {
  const std::size_t length = 4 + layout.labels.size();
  if (rows.size() % length != 0)
    throw ConfigError(fmt::format("its output of {} numbers is not rows of {}, a box and {} scores", rows.size(),
                                  length, layout.labels.size()));
  if (!std::ranges::all_of(rows, [](float value) { return std::isfinite(value); }))
    throw ConfigError("its output is not finite");
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < rows.size(); i += length) {
    const float* row = rows.data() + i;
    const auto best = std::max_element(row + 4, row + length);
    const auto label = static_cast<std::size_t>(best - (row + 4));
    if (static_cast<double>(*best) < layout.confidence || layout.labels[label].empty()) continue;
    std::array<double, 4> box{row[0], row[1], row[2], row[3]};
    if (layout.centers)
      box = {box[0] - 0.5 * box[2], box[1] - 0.5 * box[3], box[0] + 0.5 * box[2], box[1] + 0.5 * box[3]};
    const double width = camera.width;
    const double height = camera.height;
    const Box within{std::clamp(box[0], 0.0, width),
                     std::clamp(box[1], 0.0, height),
                     std::clamp(box[2], 0.0, width),
                     std::clamp(box[3], 0.0, height),
                     label,
                     row + 4};
    if (within.x_max - within.x_min >= 1.0 && within.y_max - within.y_min >= 1.0) boxes.push_back(within);
  }
  std::ranges::stable_sort(boxes, std::greater<>(), &Box::score);
  return boxes;
}

// Share of each color term in the middle of a box.
std::array<float, kColorTerms.size()> colors_of_box(const Box& box, std::span<const std::uint8_t> picture, int width) {
  std::array<int, kColorTerms.size()> counts{};
  for (int i = 0; i < kColorSamples; ++i) {
    for (int j = 0; j < kColorSamples; ++j) {
      const auto at = [](double low, double high, int k) {
        return static_cast<std::size_t>(low + (high - low) * (0.25 + 0.5 * (k + 0.5) / kColorSamples));
      };
      const std::size_t pixel =
          at(box.y_min, box.y_max, i) * static_cast<std::size_t>(width) + at(box.x_min, box.x_max, j);
      ++counts[color_term(picture[3 * pixel], picture[3 * pixel + 1], picture[3 * pixel + 2])];
    }
  }
  std::array<float, kColorTerms.size()> shares{};
  std::ranges::transform(counts, shares.begin(), [](int count) {
    return static_cast<float>(count) / static_cast<float>(kColorSamples * kColorSamples);
  });
  return shares;
}

Detection detection_of(const Box& box, const BoxLayout& layout, std::span<const std::uint8_t> picture,
                       const CameraIntrinsics& camera) {
  Detection found;
  found.scores.push_back(1.0F - std::clamp(box.score(), 0.0F, 1.0F));
  float sum = 0.0F;
  std::vector<float> used;
  for (std::size_t i = 0; i < layout.labels.size(); ++i) {
    if (layout.labels[i].empty()) continue;
    if (i == box.label) found.kind = used.size() + 1;
    used.push_back(std::clamp(box.scores[i], 0.0F, 1.0F));
    sum += used.back();
  }
  for (const float score : used) found.scores.push_back((1.0F - found.scores[0]) * score / sum);
  found.confidence = found.scores[found.kind];
  found.x_min = static_cast<int>(std::floor(box.x_min));
  found.y_min = static_cast<int>(std::floor(box.y_min));
  found.x_max = static_cast<int>(std::ceil(box.x_max));
  found.y_max = static_cast<int>(std::ceil(box.y_max));
  const double cell = camera.width / kColumns;
  found.cells = std::max(1, static_cast<int>(std::lround(box.area() / (cell * cell))));
  found.bearing = exact::atan2(-(0.5 * (box.x_min + box.x_max) - camera.cx) / camera.fx, 1.0);
  found.distance = std::min(kFarthestDistance, 2.0 * layout.radii[box.label] * camera.fx / (box.x_max - box.x_min));
  found.colors = colors_of_box(box, picture, camera.width);
  return found;
}

struct BoxModel : DetectorModel {
  BoxLayout layout;
  BoxFinder find;

  std::vector<Detection> detect(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) const override {
    const BoxRows rows = find(picture, camera);
    std::vector<Box> kept;
    for (const Box& box : sure_boxes(rows, layout, camera)) {
      if (kept.size() == kMostBoxes) break;
      if (std::ranges::none_of(kept, [&](const Box& one) { return overlap_of(one, box) > layout.overlap; }))
        kept.push_back(box);
    }
    std::vector<Detection> found;
    found.reserve(kept.size());
    for (const Box& box : kept) found.push_back(detection_of(box, layout, picture, camera));
    std::ranges::stable_sort(found, std::greater<>(), &Detection::cells);
    return found;
  }
};

}  // namespace

BoxLayout BoxLayout::load(const std::filesystem::path& file) {
  ConfigNode root = ConfigNode::load(file);
  (void)root.integer_in("version", 1, 1);
  BoxLayout layout;
  const ConfigNode labels = root.at("labels");
  for (ConfigNode& node : labels.items(kMostLabels)) {
    const std::string label = node.is_map() ? node.name("kind") : node.text();
    if (!node.is_map() && label != "-") node.fail("expected {kind: NAME, radius: METRES}, or '-' for one not used");
    if (node.is_map() && std::ranges::find(layout.labels, label) != layout.labels.end())
      node.at("kind").fail(fmt::format("kind '{}' is there already", label));
    layout.labels.push_back(node.is_map() ? label : "");
    layout.radii.push_back(node.is_map() ? node.number_in("radius", kSmallest, kLargest) : 0.0);
    if (node.is_map()) node.finish();
  }
  if (std::ranges::all_of(layout.labels, &std::string::empty)) labels.fail("expected one kind or more");
  if (root.has("input")) {
    ConfigNode input = root.at("input");
    if (input.has("colors")) layout.rgb = input.choice("colors", {"rgb", "bgr"}) == "rgb";
    if (input.has("scale")) layout.scale = input.number_in("scale", 1e-3, 1e4);
    if (input.has("mean")) layout.mean = three(input.at("mean"), -1e4);
    if (input.has("standard_deviation")) layout.deviation = three(input.at("standard_deviation"), 1e-6);
    input.finish();
  }
  if (root.has("boxes")) layout.centers = root.choice("boxes", {"center", "corners"}) == "center";
  if (root.has("confidence")) layout.confidence = root.number_in("confidence", 0.01, 1.0);
  if (root.has("overlap")) layout.overlap = root.number_in("overlap", 0.0, 1.0);
  layout.description = root.text("description", "");
  root.finish();
  return layout;
}

Detector box_detector(const BoxLayout& layout, BoxFinder find) {
  auto model = std::make_shared<BoxModel>();
  model->labels.emplace_back("background");
  model->radii.push_back(0.0);
  for (std::size_t i = 0; i < layout.labels.size(); ++i) {
    if (layout.labels[i].empty()) continue;
    model->labels.push_back(layout.labels[i]);
    model->radii.push_back(layout.radii[i]);
  }
  model->description = layout.description;
  model->layout = layout;
  model->find = std::move(find);
  return Detector(std::move(model));
}

}  // namespace threewe::vision
