#include "threewe/sim/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "sim/renderer_columns.hpp"
#include "sim/renderer_kernel.hpp"
#include "sim/renderer_place.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {

struct RenderScratch::Buffers {
  view::Candidates candidates;
  view::Columns columns;
  view::Row row;
  // of a row in a strip that is no whole number of vectors
  std::array<std::uint8_t, std::size_t{3} * view::kStripWidth> colour{};
  std::array<float, view::kStripWidth> depth{};
  std::array<std::int16_t, view::kStripWidth> ids{};
};

RenderScratch::RenderScratch() : buffers_(std::make_unique<Buffers>()) {}
RenderScratch::~RenderScratch() = default;
RenderScratch::RenderScratch(RenderScratch&&) noexcept = default;
RenderScratch& RenderScratch::operator=(RenderScratch&&) noexcept = default;

namespace {

void check_size(std::string_view name, std::size_t given, std::size_t needed) {
  if (given != 0 && given != needed) {
    throw ConfigError(fmt::format("the {} image has room for {} values, {} are needed", name, given, needed));
  }
}

void check_images(const CameraIntrinsics& camera, const Images& images) {
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  check_size("colour", images.colour.size(), 3 * pixels);
  check_size("depth", images.depth.size(), pixels);
  check_size("id", images.ids.size(), pixels);
}

void check_view(const CameraPose& view) {
  constexpr double kFarthest = 1e5;  // [m]: beyond it, single precision has no textures
  const auto [x, y, theta] = view.pose;
  const bool place_ok = std::fabs(x) <= kFarthest && std::fabs(y) <= kFarthest && std::isfinite(theta);
  if (!place_ok) {
    throw ConfigError(
        fmt::format("the camera is at ({}, {}), heading {}: it must be within {} m", x, y, theta, kFarthest));
  }
  const bool height_ok = view.height > 0.0 && view.height <= kFarthest;
  if (!height_ok) {
    throw ConfigError(fmt::format("the camera is at a height of {} m: it must be above the floor, up to {} m",
                                  view.height, kFarthest));
  }
}

// Puts a strip's directions and the eye in place.
void begin_strip(const view::View& seen, const view::FloorLight& light, int first, int count, view::Row& row) {
  constexpr double kScale = 1.0 / view::FloorLight::kCell;
  row.lanes = (count + view::kMostLanes - 1) / view::kMostLanes * view::kMostLanes;
  for (auto& field : row.fields) std::fill(field.begin() + count, field.begin() + row.lanes, 0.0F);
  for (int i = 0; i < row.lanes; ++i) {
    const Vec2 step = kScale * seen.direction(seen.slope_of(first + i));
    row.x_steps[static_cast<std::size_t>(i)] = static_cast<float>(step.x);
    row.y_steps[static_cast<std::size_t>(i)] = static_cast<float>(step.y);
  }
  const Vec2 eye = kScale * (seen.eye - light.origin);
  row.eye_x = static_cast<float>(eye.x);
  row.eye_y = static_cast<float>(eye.y);
}

// Lets columns show what begins at a row.
void turn_to(const view::Columns& columns, std::size_t r, view::Row& row) {
  for (std::int32_t i = columns.first_span[r]; i >= 0;) {
    const view::Span& span = columns.spans[static_cast<std::size_t>(i)];
    const auto column = static_cast<std::size_t>(span.column);
    for (std::size_t k = 0; k < view::kFieldCount; ++k) row.fields[k][column] = span.fields[k];
    i = span.next;
  }
}

template <class T, class Buffer>
T* place_of(std::span<T> image, std::size_t at, bool direct, Buffer& buffer) {
  return image.empty() ? nullptr : direct ? image.data() + at : buffer.data();
}

// Draws a strip's rows in place where they are whole vectors, else by way of a buffer.
void draw_strip(const view::View& seen, const view::Place& place, int first, int count, const Images& images,
                RenderScratch::Buffers& work) {
  const CameraIntrinsics& camera = seen.camera;
  const auto columns = static_cast<std::size_t>(count);
  const bool direct = count == work.row.lanes;
  for (int image_row = 0; image_row < camera.height; ++image_row) {
    const auto r = static_cast<std::size_t>(image_row);
    turn_to(work.columns, r, work.row);
    work.row.slope = work.columns.slopes[r];
    work.row.haze = place.is_open ? view::haze(seen.height, work.row.slope) : 0.0F;
    const std::size_t at = r * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(first);
    const view::RowImages row{place_of(images.colour, 3 * at, direct, work.colour),
                              place_of(images.depth, at, direct, work.depth),
                              place_of(images.ids, at, direct, work.ids)};
    view::draw_row(work.row, place.light, row);
    if (direct) continue;
    if (row.colour) std::memcpy(images.colour.data() + 3 * at, row.colour, 3 * columns);
    if (row.depth) std::memcpy(images.depth.data() + at, row.depth, columns * sizeof(float));
    if (row.ids) std::memcpy(images.ids.data() + at, row.ids, columns * sizeof(std::int16_t));
  }
}

}  // namespace

Renderer::Renderer(const scene::Scene& scene) : place_(std::make_shared<const view::Place>(scene)) {}

void Renderer::render(const CameraIntrinsics& camera, const CameraPose& view, const Paint& paint, const Images& images,
                      RenderScratch& scratch, std::span<const VisibleSolid> moving) const {
  check(camera);
  check_view(view);
  check_images(camera, images);
  if (paint.colours.size() != place_->solids.size()) throw ConfigError("the paint is that of another scene");

  RenderScratch::Buffers& work = *scratch.buffers_;
  const view::View seen(camera, view, place_->ceiling);
  view::find_candidates(*place_, seen, paint, moving, work.candidates);
  view::begin_picture(seen, work.columns);
  for (int first = 0; first < camera.width; first += view::kStripWidth) {
    const int count = std::min(view::kStripWidth, camera.width - first);
    view::find_spans(*place_, seen, work.candidates, first, count, work.columns);
    begin_strip(seen, place_->light, first, count, work.row);
    draw_strip(seen, *place_, first, count, images, work);
  }
}

const std::vector<VisibleSolid>& Renderer::solids() const { return place_->solids; }
double Renderer::ceiling() const { return place_->ceiling; }

}  // namespace threewe::sim
