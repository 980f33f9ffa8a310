// Pictures of the renderer beside those of the ray tracer, pixel by pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "sim/ray_tracer.hpp"
#include "sim/renderer.hpp"

namespace threewe::sim {

inline constexpr double kGraze =
    2e-3;  // [px]: how near to an edge a pixel's centre may lie and show the one or the other

inline constexpr double kTexel = 0.02;  // [texels]: the same of the edges of texels

/// Colour, depth and ids.
struct Picture {
  std::vector<std::uint8_t> colour;
  std::vector<float> depth;
  std::vector<std::int16_t> ids;
  friend bool operator==(const Picture&, const Picture&) = default;

  explicit Picture(const CameraIntrinsics& camera) {
    const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    colour.resize(3 * pixels, 77);
    depth.resize(pixels, -1.0F);
    ids.resize(pixels, -1);
  }
  Images images() { return {colour, depth, ids}; }
};

inline Picture take(const Renderer& renderer, const CameraIntrinsics& camera, const CameraPose& view,
                    const Shading& shading, std::span<const VisibleSolid> moving = {}) {
  Picture picture(camera);
  RenderScratch scratch;
  renderer.render(camera, view, shading, picture.images(), scratch, moving);
  return picture;
}

/// Compares pictures pixel by pixel with the ray tracer's.
struct Comparison {
  int pixels = 0;
  int grazing = 0;
  int other_level = 0;
  int other_texel = 0;
  int wrong = 0;
  int colour_alone = 0;  // of the wrong ones: the same thing at the same depth
  std::string first_wrong;

  void compare(const RayTracer& tracer, const CameraIntrinsics& camera, const Picture& picture) {
    for (int row = 0; row < camera.height; ++row) {
      for (int column = 0; column < camera.width; ++column) {
        ++pixels;
        const int at = row * camera.width + column;
        const auto i = static_cast<std::size_t>(at);
        if (agrees(tracer, column + 0.5, row + 0.5, picture, i)) continue;
        if (near_edge(tracer, column + 0.5, row + 0.5)) {
          ++grazing;
          continue;
        }
        ++wrong;
        colour_alone += shows_the_same(tracer.cast(column + 0.5, row + 0.5), picture, i) ? 1 : 0;
        if (first_wrong.empty()) describe(tracer, column, row, picture, i);
      }
    }
  }

  static bool shows_the_same(const Hit& hit, const Picture& picture, std::size_t i) {
    const auto depth = static_cast<double>(picture.depth[i]);
    if (picture.ids[i] != hit.id) return false;
    return hit.id == kNothingId ? depth == 0.0 : std::fabs(depth - hit.depth) <= 1e-4 * hit.depth;
  }

  bool agrees(const RayTracer& tracer, double u, double v, const Picture& picture, std::size_t i) {
    const Hit hit = tracer.cast(u, v);
    if (!shows_the_same(hit, picture, i)) return false;
    const auto shows = [&](const RayTracer::Off& other) {
      const Colour colour = tracer.colour(u, v, hit, other);
      const auto off = [&](float expected, std::size_t channel) {
        return std::fabs(static_cast<float>(picture.colour[3 * i + channel]) - expected);
      };
      return std::max({off(colour.b, 0), off(colour.g, 1), off(colour.r, 2)}) <= 3.0F;
    };
    if (shows({})) return true;
    // rounding may take a neighbouring texel, or level
    for (const double x : {-kTexel, 0.0, kTexel}) {
      for (const double y : {-kTexel, 0.0, kTexel}) {
        if (!shows({0, {x, y}})) continue;
        ++other_texel;
        return true;
      }
    }
    if (!shows({-1, {}}) && !shows({1, {}})) return false;
    ++other_level;
    return true;
  }

  static bool near_edge(const RayTracer& tracer, double u, double v) {
    const Hit hit = tracer.cast(u, v);
    for (const double du : {-kGraze, 0.0, kGraze}) {
      for (const double dv : {-kGraze, 0.0, kGraze}) {
        const Hit other = tracer.cast(u + du, v + dv);
        if (std::tie(other.id, other.solid, other.face) != std::tie(hit.id, hit.solid, hit.face)) return true;
        const Colour here = tracer.colour(u, v, hit, {});
        const Colour there = tracer.colour(u + du, v + dv, other, {});
        if (std::fabs(here.b - there.b) + std::fabs(here.g - there.g) + std::fabs(here.r - there.r) > 4.0F) return true;
      }
    }
    return false;
  }

  void describe(const RayTracer& tracer, int column, int row, const Picture& picture, std::size_t i) {
    const Hit hit = tracer.cast(column + 0.5, row + 0.5);
    const Colour colour = tracer.colour(column + 0.5, row + 0.5, hit, {});
    first_wrong = "pixel (" + std::to_string(column) + ", " + std::to_string(row) + "): id " +
                  std::to_string(picture.ids[i]) + " at " + std::to_string(picture.depth[i]) + " m, colour " +
                  std::to_string(picture.colour[3 * i]) + " " + std::to_string(picture.colour[3 * i + 1]) + " " +
                  std::to_string(picture.colour[3 * i + 2]) + "; truly id " + std::to_string(hit.id) + " at " +
                  std::to_string(hit.depth) + " m, face " + std::to_string(hit.face) + ", " + std::to_string(colour.b) +
                  " " + std::to_string(colour.g) + " " + std::to_string(colour.r);
  }
};

}  // namespace threewe::sim
