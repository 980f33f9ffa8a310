#include "threewe/sim/renderer.hpp"

#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/renderer_columns.hpp"
#include "sim/renderer_kernel.hpp"
#include "sim/renderer_place.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {

struct RenderScratch::Buffers {
  view::Columns columns;
  view::Row row;
  std::vector<std::uint8_t> colour;  // of one row, where an image's rows are no whole number of vectors
  std::vector<float> depth;
  std::vector<std::int16_t> ids;
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
  if (!is_finite(view.pose)) throw ConfigError("the camera's pose is not finite");
  if (!(view.height > 0.0 && std::isfinite(view.height))) {
    throw ConfigError(fmt::format("the camera is at a height of {} m; it must be above the floor", view.height));
  }
}

// Puts the columns' directions and the eye in place.
void begin_rows(const CameraIntrinsics& camera, const CameraPose& pose, const view::FloorLight& light, view::Row& row) {
  row.width = camera.width;
  row.stride = (camera.width + view::kMostLanes - 1) / view::kMostLanes * view::kMostLanes;
  const auto stride = static_cast<std::size_t>(row.stride);
  row.fields.assign(view::kFieldCount * stride, 0.0F);
  row.x_steps.assign(stride, 0.0F);
  row.y_steps.assign(stride, 0.0F);
  const auto [sin, cos] = exact::sincos(pose.pose.theta);
  constexpr double kScale = 1.0 / view::FloorLight::kCell;
  for (std::size_t i = 0; i < static_cast<std::size_t>(camera.width); ++i) {
    const double s = (camera.cx - (static_cast<double>(i) + 0.5)) / camera.fx;
    row.x_steps[i] = static_cast<float>(kScale * (cos - s * sin));
    row.y_steps[i] = static_cast<float>(kScale * (sin + s * cos));
  }
  const Vec2 eye = kScale * (pose.pose.position() - light.origin);
  row.eye_x = static_cast<float>(eye.x);
  row.eye_y = static_cast<float>(eye.y);
}

// Lets columns show what begins at a row.
void turn_to(const view::Columns& columns, std::size_t r, view::Row& row) {
  row.slope = columns.slopes[r];
  const auto stride = static_cast<std::size_t>(row.stride);
  for (std::int32_t i = columns.first_span[r]; i >= 0;) {
    const view::Span& span = columns.spans[static_cast<std::size_t>(i)];
    float* field = row.fields.data() + span.column;
    for (std::size_t k = 0; k < view::kFieldCount; ++k) field[k * stride] = span.fields[k];
    i = span.next;
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
  view::find_spans(*place_, camera, view, paint, moving, work.columns);
  begin_rows(camera, view, place_->light, work.row);

  // rows of whole vectors are drawn in place, others by way of a buffer
  const auto width = static_cast<std::size_t>(camera.width);
  const auto stride = static_cast<std::size_t>(work.row.stride);
  const bool direct = width == stride;
  if (!direct) {
    work.colour.resize(3 * stride);
    work.depth.resize(stride);
    work.ids.resize(stride);
  }
  for (std::size_t r = 0; r < static_cast<std::size_t>(camera.height); ++r) {
    turn_to(work.columns, r, work.row);
    const auto at = [&](const auto& image, auto& buffer, std::size_t channels) {
      return image.empty() ? nullptr : direct ? image.data() + channels * width * r : buffer.data();
    };
    const view::RowImages row{at(images.colour, work.colour, 3), at(images.depth, work.depth, 1),
                              at(images.ids, work.ids, 1)};
    view::draw_row(work.row, place_->light, row);
    if (direct) continue;
    if (row.colour) std::memcpy(images.colour.data() + 3 * width * r, row.colour, 3 * width);
    if (row.depth) std::memcpy(images.depth.data() + width * r, row.depth, width * sizeof(float));
    if (row.ids) std::memcpy(images.ids.data() + width * r, row.ids, width * sizeof(std::int16_t));
  }
}

const std::vector<VisibleSolid>& Renderer::solids() const { return place_->solids; }
double Renderer::ceiling() const { return place_->ceiling; }

}  // namespace threewe::sim
