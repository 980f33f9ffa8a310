// Camera renderer: colour, depth and semantics in one pass, of a place made of vertical prisms.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "threewe/core/camera.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::sim {

/// What a pixel shows. Object i of the scene is `kFirstObjectId + i`.
inline constexpr std::int16_t kNothingId = 0;  ///< sky, or nothing
inline constexpr std::int16_t kFloorId = 1;
inline constexpr std::int16_t kWallId = 2;
inline constexpr std::int16_t kCeilingId = 3;
inline constexpr std::int16_t kFirstObjectId = 4;

/// What surfaces are made of: each has a texture of its own.
enum class Material : std::uint8_t {
  floor_wood,
  floor_tile,
  floor_carpet,
  floor_concrete,
  floor_vinyl,
  shading,
  trim,
  ceiling,
  sky,
  wood,
  metal,
  plastic,
  fabric,
  leaf,
  ceramic,
  glass,
  stone,
  paper,
  floor_grass,
  floor_gravel,
  floor_paving,
  floor_asphalt,
  cardboard,
  brick,
  roof,
  window,
  picture,
  skin,
  rubber,
};

/// Blue, green, red, 0 to 255.
struct Colour {
  float b = 0.0F;
  float g = 0.0F;
  float r = 0.0F;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// A prism as the camera sees it. `id` is what its pixels say.
struct VisibleSolid {
  scene::Solid solid;
  Material material{};
  std::int16_t id = kNothingId;
  Colour colour{};  ///< of a moving solid; those of the scene are coloured by `Shading`
};

/// How things look in an episode: seed and episode name their colours.
struct Shading {
  std::uint64_t seed = 0;
  std::uint32_t episode = 0;
  std::uint32_t texture = 0;      ///< 0: what surfaces are made of; else which other patterns they wear
  Colour gain{1.0F, 1.0F, 1.0F};  ///< what each channel is multiplied by, 0 to `kMostGain`
  float detail = 1.0F;            ///< of textures, shadows, tints of walls, windows and skirting: 1 all of them, 0 none
};
inline constexpr float kMostGain = 50.0F;

/// Where a level camera is: its eye in the scene's frame, looking along the heading.
struct CameraPose {
  Pose2D pose;
  double height = 0.0;  ///< [m] above the floor, positive
};

/// Where pixels go, row by row. An empty span is left out, and costs nothing.
struct Images {
  std::span<std::uint8_t> colour;  ///< (H, W, 3) BGR
  std::span<float> depth;          ///< (H, W) [m] along the optical axis; 0 where there is nothing
  std::span<std::int16_t> ids;     ///< (H, W)
};

/// Working memory of one thread. Keeps its size from picture to picture; holds nothing between them.
class RenderScratch {
 public:
  RenderScratch();
  ~RenderScratch();
  RenderScratch(RenderScratch&&) noexcept;
  RenderScratch& operator=(RenderScratch&&) noexcept;

  struct Buffers;

 private:
  friend class Renderer;
  std::unique_ptr<Buffers> buffers_;
};

namespace view {
struct Place;
}

/// Draws a scene. Const once made: threads may share one.
///
/// A pixel shows what the ray through its centre meets first. Solids are seen from outside: a ray that begins inside
/// one leaves it unhindered. The bits depend on neither machine nor thread.
class Renderer {
 public:
  explicit Renderer(const scene::Scene& scene);

  /// The colour of a solid of the scene: a pure function of seed, episode, and the index and material of its object.
  Colour colour(const Shading& shading, std::size_t solid) const;

  /// Fills the images. `moving` are solids that are elsewhere at every call: people, other robots. Throws ConfigError
  /// for an impossible camera, a height that is not above the floor, a gain or detail out of range, or images of the
  /// wrong size.
  void render(const CameraIntrinsics& camera, const CameraPose& view, const Shading& shading, const Images& images,
              RenderScratch& scratch, std::span<const VisibleSolid> moving = {}) const;

  /// All that stands in the scene: its walls, a lintel over each doorway, the prisms of its objects.
  const std::vector<VisibleSolid>& solids() const;
  /// Height [m] of the ceiling; infinity under the sky.
  double ceiling() const;

 private:
  std::shared_ptr<const view::Place> place_;  // copies share it
};

}  // namespace threewe::sim
