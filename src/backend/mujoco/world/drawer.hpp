// Camera images drawn by MuJoCo's renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "backend/mujoco/world/gl.hpp"
#include "backend/mujoco/world/library.hpp"
#include "backend/simulated/engine.hpp"
#include "export/shape.hpp"
#include "export/transform.hpp"

namespace threewe::backend::mujoco {

/// Draws moments of one world, any thread one at a time. What stands and drives is drawn as physics has it, people and
/// lintels as the embedded camera shows them, all in the episode's colours and, where textures are drawn, its patterns.
class Drawer {
 public:
  /// `compiled` is copied. Drawing is set up when a picture is first looked at.
  Drawer(std::shared_ptr<const sim::Model> world, const mjModel& compiled);
  Drawer(const Drawer&) = delete;
  Drawer& operator=(const Drawer&) = delete;
  ~Drawer();

  /// See `simulated::Engine`. Throw HardwareError where nothing can be drawn.
  RGBDImage picture(const simulated::WorldCapture& capture);
  SemanticImage look(const simulated::WorldCapture& capture, const CameraIntrinsics& camera,
                     const sim::CameraPose& view, bool with_itself);

 private:
  struct Free {
    const Library* library;
    void operator()(mjModel* model) const { library->mj_deleteModel(model); }
    void operator()(mjData* data) const { library->mj_deleteData(data); }
  };
  /// What a geom of the model is in pictures.
  struct Appearance {
    std::int16_t id = 0;
    int solid = -1;  // of `sim::Renderer::solids`, whose colour it has; -1: its own
    int robot = -1;  // that it belongs to
    bool shown = false;
  };
  struct Pixels {
    std::span<std::uint8_t> color;
    std::span<float> depth;
    std::span<std::int16_t> ids;
  };

  Appearance appearance_of(int geom) const;
  void set_up();
  void compose(const simulated::WorldCapture& capture, std::size_t without);
  void add(mjtGeom type, const exports::Vec3& half, const exports::Transform& pose, std::int16_t id,
           const exports::Color& color);
  void add_solid(const sim::VisibleSolid& solid, const exports::Color& color);
  void add_ground();
  void light();
  void draw(const CameraIntrinsics& camera, const exports::Transform& scene_from_camera, const Pixels& pixels,
            const models::Variation& variation);
  void wear(const CameraIntrinsics& camera, const exports::Transform& scene_from_camera, const Pixels& pixels,
            const models::Variation& variation);
  void render(const CameraIntrinsics& camera);
  void read_colors(const CameraIntrinsics& camera, const Pixels& pixels);
  void read_ids(const CameraIntrinsics& camera, std::span<std::int16_t> ids);
  exports::Transform base(std::size_t robot) const;

  const Library& mj_;
  std::shared_ptr<const sim::Model> world_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  std::vector<Appearance> appearances_;  // of each geom
  exports::Color wall_;

  std::mutex mutex_;
  std::optional<GlContext> gl_;
  std::unique_ptr<mjrContext> context_;
  std::unique_ptr<mjvScene> scene_;
  // working memory
  std::vector<sim::VisibleSolid> people_;
  std::vector<std::uint8_t> rgb_;
  std::vector<float> depth_;  // 1 near the eye, 0 far off
};

}  // namespace threewe::backend::mujoco
