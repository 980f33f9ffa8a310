#include "vision/detector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/exact.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"
#include "vision/color_terms.hpp"
#include "vision/integer_network.hpp"
#include "vision/view.hpp"

namespace threewe::vision {
namespace {

constexpr int kCell = 8;  // [px] of the view
constexpr int kColumns = kViewWidth / kCell;
constexpr int kRows = kViewHeight / kCell;
constexpr double kOffsetUnit = 4.0;      // [cells] in which offsets are learnt
constexpr double kLeastNearness = 0.08;  // [1/m]
constexpr double kMostNearness = 5.0;    // [1/m]
constexpr double kLargest = 20.0;        // [m] radius of a thing
constexpr double kAround = 0.3;          // share of a thing's cells that shows what is around it
constexpr double kThing = 0.5;           // probability of being no background, from which a cell belongs to a thing
// Neighbouring cells are of one thing when they agree on where its centre is, more closely if they differ on its kind.
constexpr double kSameColumn = 2.5;     // [cells]
constexpr double kSameNearness = 1.35;  // ratio
constexpr double kOtherKind = 0.4;      // share of these

// What the network says of one cell.
struct Cell {
  std::vector<double> scores;  // probability of each label
  std::size_t best = 0;        // but for the background
  double column = 0.0;         // [cells] of the thing's centre
  double nearness = 0.0;       // [1/m]
};

bool are_one(const Cell& a, const Cell& b) {
  const double share = a.best == b.best ? 1.0 : kOtherKind;
  const double ratio = std::max(a.nearness, b.nearness) / std::min(a.nearness, b.nearness);
  return std::fabs(a.column - b.column) < share * kSameColumn && ratio < 1.0 + share * (kSameNearness - 1.0);
}

// Numbers equal for cells of one thing: union-find over neighbours.
std::vector<int> group(const std::vector<std::optional<Cell>>& cells) {
  std::vector<int> parent(cells.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) i = parent[static_cast<std::size_t>(i)];
    return i;
  };
  const auto join = [&](int a, int b) {
    const auto& first = cells[static_cast<std::size_t>(a)];
    const auto& second = cells[static_cast<std::size_t>(b)];
    if (!first || !second || !are_one(*first, *second)) return;
    const int ra = root(a);
    const int rb = root(b);
    parent[static_cast<std::size_t>(std::max(ra, rb))] = std::min(ra, rb);
  };
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const int i = y * kColumns + x;
      if (x + 1 < kColumns) join(i, i + 1);
      if (y + 1 < kRows) join(i, i + kColumns);
      if (x + 1 < kColumns && y + 1 < kRows) join(i, i + kColumns + 1);
      if (x > 0 && y + 1 < kRows) join(i, i + kColumns - 1);
    }
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(static_cast<int>(i));
  return parent;
}

using ColorCounts = std::array<int, kColorTerms.size()>;

// How many of a cell's pixels have each color term, of a quarter of them.
void count_colors(int x, int y, std::span<const std::uint8_t> view, ColorCounts& counts) {
  for (int v = y * kCell + 1; v < (y + 1) * kCell; v += 2) {
    for (int u = x * kCell + 1; u < (x + 1) * kCell; u += 2) {
      const auto* pixel = view.data() + 3UL * static_cast<std::size_t>(v * kViewWidth + u);
      ++counts[color_term(pixel[0], pixel[1], pixel[2])];
    }
  }
}

// Sums over the cells of one thing, and the colors of those around it.
struct Thing {
  std::vector<double> scores;
  double column = 0.0;
  double nearness = 0.0;
  double weight = 0.0;
  int cells = 0;
  int x_min = kColumns;
  int y_min = kRows;
  int x_max = 0;
  int y_max = 0;
  ColorCounts colors{};
  ColorCounts colors_around{};

  void add(const Cell& cell, int x, int y, std::span<const std::uint8_t> view) {
    if (scores.empty()) scores.assign(cell.scores.size(), 0.0);
    for (std::size_t k = 0; k < scores.size(); ++k) scores[k] += cell.scores[k];
    const double certainty = 1.0 - cell.scores[0];
    column += certainty * cell.column;
    nearness += certainty * cell.nearness;
    weight += certainty;
    ++cells;
    x_min = std::min(x_min, x), x_max = std::max(x_max, x + 1);
    y_min = std::min(y_min, y), y_max = std::max(y_max, y + 1);
    count_colors(x, y, view, colors);
  }

  // What it shows most, but for the background.
  std::size_t kind() const {
    return static_cast<std::size_t>(std::max_element(scores.begin() + 1, scores.end()) - scores.begin());
  }

  double distance() const { return weight / nearness; }  // [m]

  // Whether both are parts of one thing, which stands behind another or whose cells disagree: their middles are in it.
  bool is_one_with(const Thing& other, double radius) const {
    const double reach = radius * kViewFocal / kCell / std::min(distance(), other.distance());
    return kind() == other.kind() && std::fabs(distance() - other.distance()) < 2.0 * radius &&
           std::fabs(column / weight - other.column / other.weight) < std::max(reach, 1.0);
  }

  void absorb(const Thing& other) {
    for (std::size_t k = 0; k < scores.size(); ++k) scores[k] += other.scores[k];
    column += other.column;
    nearness += other.nearness;
    weight += other.weight;
    cells += other.cells;
    x_min = std::min(x_min, other.x_min), x_max = std::max(x_max, other.x_max);
    y_min = std::min(y_min, other.y_min), y_max = std::max(y_max, other.y_max);
    for (std::size_t term = 0; term < colors.size(); ++term) {
      colors[term] += other.colors[term];
      colors_around[term] += other.colors_around[term];
    }
  }

  // Share of each color term in the thing: of what its cells show, some is what is around it.
  std::array<float, kColorTerms.size()> shares_of_colors() const {
    const auto sum = [](const ColorCounts& counts) { return std::accumulate(counts.begin(), counts.end(), 0); };
    const double around = kAround * sum(colors) / std::max(sum(colors_around), 1);
    std::array<double, kColorTerms.size()> own{};
    for (std::size_t term = 0; term < own.size(); ++term) {
      own[term] = std::max(0.0, colors[term] - around * colors_around[term]);
    }
    const double all = std::accumulate(own.begin(), own.end(), 0.0);
    std::array<float, kColorTerms.size()> shares{};
    std::ranges::transform(own, shares.begin(), [all](double each) { return static_cast<float>(each / all); });
    return shares;
  }

  Detection detection(const CameraIntrinsics& camera) const {
    Detection found;
    found.cells = cells;
    for (const double score : scores) found.scores.push_back(static_cast<float>(score / cells));
    found.kind = kind();
    found.confidence = found.scores[found.kind];
    const double slope = (column / weight - 0.5 * kColumns) * kCell / kViewFocal;
    found.bearing = exact::atan2(-slope, 1.0);
    found.distance = distance();
    const auto pixel = [](double center, double focal, double view, double at, int size) {
      const double x = center + focal * (at * kCell - 0.5 * view) / kViewFocal;
      return static_cast<int>(std::clamp(std::floor(x + 0.5), 0.0, static_cast<double>(size)));
    };
    found.x_min = pixel(camera.cx, camera.fx, kViewWidth, x_min, camera.width);
    found.x_max = pixel(camera.cx, camera.fx, kViewWidth, x_max, camera.width);
    found.y_min = pixel(camera.cy, camera.fy, kViewHeight, y_min, camera.height);
    found.y_max = pixel(camera.cy, camera.fy, kViewHeight, y_max, camera.height);
    found.colors = shares_of_colors();
    return found;
  }
};

std::filesystem::path file_of(std::string_view name) {
  if (name.ends_with(".safetensors")) return name;
  for (const auto& folder : asset_directories()) {
    const auto file = folder / "detectors" / fmt::format("{}.safetensors", name);
    if (std::filesystem::exists(file)) return file;
  }
  throw ConfigError(
      fmt::format("there is no detector '{}'; known is 'indoor_v1', or a file that ends in .safetensors", name));
}

struct IntegerModel : DetectorModel {
  IntegerNetwork network;

  std::vector<Detection> detect(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) const override;
  // What the network says of a cell; none for background.
  std::optional<Cell> cell(const std::int32_t* sums, int x) const;
};

std::optional<Cell> IntegerModel::cell(const std::int32_t* sums, int x) const {
  const auto value = [&](std::size_t i) { return std::ldexp(static_cast<double>(sums[i]), -network.places(i)); };
  Cell cell{std::vector<double>(labels.size()), 1, 0.0, 0.0};
  for (std::size_t k = 0; k < labels.size(); ++k) {
    cell.scores[k] = value(k);
    if (k > 1 && cell.scores[k] > cell.scores[cell.best]) cell.best = k;
  }
  // with so many labels the background's share is above a half
  if (cell.scores[0] > cell.scores[cell.best] + exact::log(static_cast<double>(labels.size()))) return {};
  const double highest = std::max(cell.scores[0], cell.scores[cell.best]);
  double sum = 0.0;
  for (double& score : cell.scores) sum += score = exact::exp(score - highest);
  for (double& score : cell.scores) score /= sum;
  if (cell.scores[0] > 1.0 - kThing) return {};
  cell.column = x + 0.5 + kOffsetUnit * value(labels.size());
  cell.nearness = std::clamp(value(labels.size() + 1), kLeastNearness, kMostNearness);
  return cell;
}

std::vector<Detection> IntegerModel::detect(std::span<const std::uint8_t> picture,
                                            const CameraIntrinsics& camera) const {
  const auto view = detector_view(picture, camera);
  const auto sums = network.run(view, kViewHeight, kViewWidth);
  std::vector<std::optional<Cell>> cells(static_cast<std::size_t>(kRows * kColumns));
  for (std::size_t i = 0; i < cells.size(); ++i)
    cells[i] = cell(sums.data() + i * network.padded_outputs(), static_cast<int>(i) % kColumns);

  const std::vector<int> groups = group(cells);
  std::vector<Thing> things(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!cells[i]) continue;
    const int x = static_cast<int>(i) % kColumns;
    const int y = static_cast<int>(i) / kColumns;
    Thing& thing = things[static_cast<std::size_t>(groups[i])];
    thing.add(*cells[i], x, y, view);
    for (const auto& [u, v] : {std::pair{x, y - 1}, {x - 1, y}, {x + 1, y}, {x, y + 1}}) {
      if (u < 0 || v < 0 || u >= kColumns || v >= kRows) continue;
      const int next = v * kColumns + u;
      if (!cells[static_cast<std::size_t>(next)]) count_colors(u, v, view, thing.colors_around);
    }
  }
  std::erase_if(things, [](const Thing& thing) { return thing.cells == 0; });
  std::ranges::stable_sort(things, std::greater<>(), &Thing::cells);
  std::vector<Thing> whole;
  for (const Thing& thing : things) {
    const auto same =
        std::ranges::find_if(whole, [&](const Thing& other) { return other.is_one_with(thing, radii[thing.kind()]); });
    if (same == whole.end())
      whole.push_back(thing);
    else
      same->absorb(thing);
  }

  std::vector<Detection> found;
  for (const Thing& thing : whole) found.push_back(thing.detection(camera));
  std::ranges::stable_sort(found, std::greater<>(), &Detection::cells);
  return found;
}

}  // namespace

Detector Detector::load(std::string_view name) {
  const TensorFile file = TensorFile::load(file_of(name));
  auto model = std::make_shared<IntegerModel>();
  try {
    model->labels = nlohmann::json::parse(file.text("labels")).get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {
    file.fail("'labels' must be a list of names");
  }
  try {
    model->radii = nlohmann::json::parse(file.text("radii")).get<std::vector<double>>();
  } catch (const nlohmann::json::exception&) {
    file.fail("'radii' must be a list of numbers");
  }
  if (model->radii.size() != model->labels.size() ||
      !std::ranges::all_of(model->radii, [](double radius) { return radius >= 0.0 && radius < kLargest; }))
    file.fail(fmt::format("'radii' must be a number of 0 to {:g} m for each of the {} labels", kLargest,
                          model->labels.size()));
  model->description = file.text("description");
  model->network = IntegerNetwork(file);
  if (model->labels.size() < 2 || model->network.outputs() != model->labels.size() + 2)
    file.fail(fmt::format("its network has {} outputs, which must be two more than its {} labels",
                          model->network.outputs(), model->labels.size()));
  return Detector(std::move(model));
}

std::vector<Detection> Detector::detect(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) const {
  if (camera.width < 1 || camera.height < 1 ||
      picture.size() != 3 * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height))
    throw ContractError(
        fmt::format("a picture of {} bytes is not one of {} x {} pixels", picture.size(), camera.width, camera.height));
  return model_->detect(picture, camera);
}

std::size_t Detection::color() const {
  return static_cast<std::size_t>(std::ranges::max_element(colors) - colors.begin());
}

std::span<const std::string_view> color_names() { return kColorTerms; }
std::uint8_t color_of(std::uint8_t blue, std::uint8_t green, std::uint8_t red) { return color_term(blue, green, red); }

}  // namespace threewe::vision
