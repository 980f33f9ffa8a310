#include "threewe/sim/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "sim/renderer/columns.hpp"
#include "sim/renderer/kernel.hpp"
#include "sim/renderer/place.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {

struct RenderScratch::Buffers {
  view::Rows rows;
  view::Candidates candidates;
  view::Columns columns;
  view::Strip strip;
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

// What is known of rows before anything is drawn, also of some beyond the last.
void begin_rows(const view::View& seen, bool is_open, view::Rows& rows) {
  rows.count = seen.camera.height;
  const auto count = static_cast<std::size_t>(rows.count) + view::kMostLanes;
  rows.slopes.resize(count);
  rows.floor.resize(count);
  rows.haze.resize(is_open ? count : 0);
  for (std::size_t k = 0; k < 3; ++k) {
    rows.sky[k].resize(count);
    rows.glow[k].resize(count);
  }
  for (std::size_t r = 0; r < count; ++r) {
    const auto slope = static_cast<float>((seen.camera.cy - (static_cast<double>(r) + 0.5)) / seen.camera.fy);
    const Colour sky = view::sky_colour(slope);
    const Colour glow = view::sun_glow(slope);
    rows.slopes[r] = slope;
    rows.floor[r] = slope < 0.0F ? 1.0F / (view::inverse_of_level(-seen.height).rise * slope) : 0.0F;
    if (is_open) rows.haze[r] = view::haze(seen.height, slope);
    rows.sky[0][r] = sky.b, rows.sky[1][r] = sky.g, rows.sky[2][r] = sky.r;
    rows.glow[0][r] = glow.b, rows.glow[1][r] = glow.g, rows.glow[2][r] = glow.r;
  }
}

// Where the pixels of some columns go.
view::Target target_of(const Images& images, int width, int first, int count) {
  const auto at = static_cast<std::size_t>(first);
  return {images.colour.empty() ? nullptr : images.colour.data() + 3 * at,
          images.depth.empty() ? nullptr : images.depth.data() + at,
          images.ids.empty() ? nullptr : images.ids.data() + at, static_cast<std::size_t>(width),
          static_cast<std::size_t>(count)};
}

}  // namespace

Renderer::Renderer(const scene::Scene& scene) : place_(std::make_shared<const view::Place>(scene)) {}

void Renderer::render(const CameraIntrinsics& camera, const CameraPose& view, const Paint& paint, const Images& images,
                      RenderScratch& scratch, std::span<const VisibleSolid> moving) const {
  check(camera);
  check_view(view);
  check_images(camera, images);

  RenderScratch::Buffers& work = *scratch.buffers_;
  const view::View seen(camera, view, place_->ceiling);
  view::find_candidates(*place_, seen, paint, moving, work.candidates);
  begin_rows(seen, place_->is_open, work.rows);
  view::begin_strips(camera.height, work.strip);
  for (int first = 0; first < camera.width; first += view::kStripWidth) {
    const int count = std::min(view::kStripWidth, camera.width - first);
    view::find_spans(*place_, seen, work.rows, work.candidates, first, count, work.columns);
    view::draw_strip(work.columns.spans, work.rows, place_->light, work.strip,
                     target_of(images, camera.width, first, count));
  }
}

Colour Renderer::colour(const Paint& paint, std::size_t solid) const { return place_->colour(paint, solid); }
const std::vector<VisibleSolid>& Renderer::solids() const { return place_->solids; }
double Renderer::ceiling() const { return place_->ceiling; }

}  // namespace threewe::sim
