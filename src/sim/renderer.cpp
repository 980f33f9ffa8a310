#include "sim/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "sim/renderer/kernel.hpp"
#include "sim/renderer/place.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim {

struct RenderScratch::Buffers {
  view::Rows rows;
  view::Candidates candidates;
  view::BlockWork work;
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

void check_shading(const Shading& shading) {
  for (const float gain : {shading.gain.b, shading.gain.g, shading.gain.r}) {
    if (gain >= 0.0F && gain <= kMostGain) continue;
    throw ConfigError(fmt::format("a gain of the picture's colours is {}: it must be 0 to {}", gain, kMostGain));
  }
  const bool detail_ok = shading.detail >= 0.0F && shading.detail <= 1.0F;
  if (!detail_ok) throw ConfigError(fmt::format("the picture's detail is {}: it must be 0 to 1", shading.detail));
}

// What is known of rows that look at the sky, and at the ground below it.
void begin_sky(const view::View& seen, const view::Place& place, view::Rows& rows) {
  const std::size_t count = rows.slopes.size();
  rows.haze.resize(count);
  for (std::size_t k = 0; k < 3; ++k) {
    rows.sky[k].resize(count);
    rows.glow[k].resize(count);
  }
  for (std::size_t r = 0; r < count; ++r) {
    const float slope = rows.slopes[r];
    const Colour sky = view::sky_colour(slope);
    const Colour glow = view::sun_glow(slope);
    rows.haze[r] = place.is_open ? view::haze(seen.height, slope) : 0.0F;
    rows.sky[0][r] = sky.b, rows.sky[1][r] = sky.g, rows.sky[2][r] = sky.r;
    rows.glow[0][r] = glow.b, rows.glow[1][r] = glow.g, rows.glow[2][r] = glow.r;
  }
}

// What is known of rows before anything is drawn, also of some beyond the last.
void begin_rows(const view::View& seen, const view::Place& place, view::Rows& rows) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  rows.count = seen.camera.height;
  rows.level = -1;
  const auto count = static_cast<std::size_t>(rows.count) + view::kWidestBlock;
  rows.slopes.resize(count);
  rows.inverse.resize(count);
  rows.above.resize(count);
  rows.below.resize(count);
  const auto ceiling = static_cast<float>(place.ceiling - seen.height);
  const auto floor = static_cast<float>(-seen.height);
  for (std::size_t r = 0; r < count; ++r) {
    const double up = seen.camera.cy - (static_cast<double>(r) + 0.5);
    if (up == 0.0 && r + view::kWidestBlock < count) rows.level = static_cast<int>(r);
    rows.slopes[r] = static_cast<float>(up / seen.camera.fy);
    // nothing level is seen along the horizon
    rows.inverse[r] = up == 0.0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(seen.camera.fy / up);
    rows.above[r] = seen.is_roofed && up > 0.0 ? ceiling * rows.inverse[r] : kNothing;
    rows.below[r] = up < 0.0 ? floor * rows.inverse[r] : kNothing;
  }
  if (!seen.is_roofed) begin_sky(seen, place, rows);
}

}  // namespace

Renderer::Renderer(const scene::Scene& scene) : place_(std::make_shared<const view::Place>(scene)) {}

void Renderer::render(const CameraIntrinsics& camera, const CameraPose& view, const Shading& shading,
                      const Images& images, RenderScratch& scratch, std::span<const VisibleSolid> moving) const {
  check(camera);
  check_view(view);
  check_images(camera, images);
  check_shading(shading);

  RenderScratch::Buffers& work = *scratch.buffers_;
  const view::View seen(camera, view, place_->ceiling);
  view::find_candidates(*place_, seen, moving, work.candidates);
  begin_rows(seen, *place_, work.rows);
  view::draw({*place_, seen, work.rows, work.candidates, shading, images}, work.work);
}

Colour Renderer::colour(const Shading& shading, std::size_t solid) const { return place_->colour(shading, solid); }
const std::vector<VisibleSolid>& Renderer::solids() const { return place_->solids; }
double Renderer::ceiling() const { return place_->ceiling; }

}  // namespace threewe::sim
