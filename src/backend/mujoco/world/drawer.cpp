#include "backend/mujoco/world/drawer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "backend/mujoco/world/patterns.hpp"
#include "backend/mujoco/world/physics.hpp"
#include "core/exact.hpp"
#include "models/camera.hpp"
#include "sim/actor_geometry.hpp"
#include "sim/renderer/materials.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Transform;
using exports::Vec3;

constexpr double kNear = 0.01;    // [m]
constexpr double kFar = 1000.0;   // [m]
constexpr double kHorizon = 400;  // [m] that the ground reaches
constexpr float kLamps = 0.2F;    // how much brighter ceilings are than what else is seen from below

exports::Color color_of(const sim::Colour& colour) { return {colour.r / 255.0F, colour.g / 255.0F, colour.b / 255.0F}; }

void shading(mjvGeom& geom, const exports::Color& color) {
  geom.rgba[0] = static_cast<float>(color.red);
  geom.rgba[1] = static_cast<float>(color.green);
  geom.rgba[2] = static_cast<float>(color.blue);
  geom.rgba[3] = 1.0F;
}

Transform upright(const Pose2D& pose, double height) {
  return {{pose.x, pose.y, height}, exports::about_z(pose.theta)};
}

std::size_t pixels_of(const CameraIntrinsics& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

// By the episode's light and exposure.
void brighten(const sim::CapturePose& state, std::span<std::uint8_t> color) {
  const std::array<double, 3> gains = models::color_gains(state.variation, state.key);
  if (gains == std::array{1.0, 1.0, 1.0}) return;
  for (std::size_t i = 0; i < color.size(); ++i) {
    color[i] = static_cast<std::uint8_t>(std::min(std::lround(gains[i % 3] * color[i]), 255L));
  }
}

double depth_of(float nearness) { return kNear * kFar / (kNear + static_cast<double>(nearness) * (kFar - kNear)); }

void put(const Vec3& v, float* out) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

}  // namespace

Drawer::Drawer(std::shared_ptr<const sim::Model> world, const mjModel& compiled)
    : mj_(library()), world_(std::move(world)), model_(mj_.mj_copyModel(nullptr, &compiled), Free{&mj_}) {
  const sim::Colour shading = world_->scene->ceiling ? sim::view::wall_colour(0) : sim::view::kBrick;
  wall_ = color_of(shading);
  // a pixel shows what the ray through its middle meets
  model_->vis.quality.offsamples = 0;
  model_->vis.quality.shadowsize = 0;
  // round enough: what is 1 m wide is off by 1 mm
  model_->vis.quality.numslices = 48;
  model_->vis.quality.numstacks = 4;
}

// What the renderer holds ends with the context that it drew in.
Drawer::~Drawer() {
  if (scene_) mj_.mjv_freeScene(scene_.get());
}

// By the names that exported models have.
Drawer::Appearance Drawer::appearance_of(int geom) const {
  const char* text = mj_.mj_id2name(model_.get(), mjOBJ_GEOM, geom);
  const std::string_view name = text == nullptr ? "" : text;
  const auto begins = [name](std::string_view with) { return name.starts_with(with); };
  const scene::Scene& scene = *world_->scene;
  for (std::size_t i = 0; i < world_->robots.size(); ++i) {
    if (begins(robot_name(i) + "/")) return {sim::robot_id(scene, i), -1, static_cast<int>(i), true};
  }
  if (begins("person/")) return {};
  if (begins("floor_")) return {sim::kFloorId, -1, -1, true};
  if (begins("wall_")) return {sim::kWallId, -1, -1, true};
  if (begins("ceiling")) return {sim::kCeilingId, -1, -1, true};

  const std::size_t slash = name.rfind('/');
  if (slash == std::string_view::npos) return {};
  const auto object = std::ranges::find(scene.objects, name.substr(0, slash), &scene::Object::name);
  if (object == scene.objects.end()) return {};
  const auto id = static_cast<std::int16_t>(sim::kFirstObjectId + (object - scene.objects.begin()));
  const std::vector<sim::VisibleSolid>& solids = world_->renderer().solids();
  const auto first = std::ranges::find(solids, id, &sim::VisibleSolid::id) - solids.begin();
  return {id, static_cast<int>(first) + std::stoi(std::string(name.substr(slash + 1))), -1, true};
}

void Drawer::set_up() {
  if (scene_) return;
  appearances_.clear();
  for (int geom = 0; geom < model_->ngeom; ++geom) appearances_.push_back(appearance_of(geom));
  data_ = {mj_.mj_makeData(model_.get()), Free{&mj_}};
  gl_.emplace();
  static std::mutex finding;  // MuJoCo keeps OpenGL's functions for all contexts, and finds them anew for each
  const std::scoped_lock lock(finding);
  const GlContext::Current current(*gl_);
  context_ = std::make_unique<mjrContext>();
  mj_.mjr_defaultContext(context_.get());
  try {
    mj_.mjr_makeContext(model_.get(), context_.get(), mjFONTSCALE_100);
  } catch (const ContractError& error) {
    throw HardwareError(fmt::format("backend 'mujoco' cannot draw what cameras see: {}", error.what()));
  }
  context_->readDepthMap = mjDEPTH_ZEROFAR;

  constexpr std::size_t kPartsOfAPerson = 30;
  const std::size_t most =
      appearances_.size() + world_->renderer().solids().size() + kPartsOfAPerson * world_->scene->people.size() + 100;
  scene_ = std::make_unique<mjvScene>();
  mj_.mjv_defaultScene(scene_.get());
  mj_.mjv_makeScene(model_.get(), scene_.get(), static_cast<int>(most));
}

RGBDImage Drawer::picture(const simulated::WorldCapture& capture) {
  const sim::CapturePose& state = capture.state;
  const std::size_t robot = state.key.robot;
  const CameraSpec spec = models::varied(*world_->robots[robot].profile.camera, state.variation);
  RGBDImage picture{spec.intrinsics(), {}, {}};
  picture.color.resize(3 * pixels_of(picture.intrinsics));
  if (spec.depth) picture.depth.resize(pixels_of(picture.intrinsics));

  const std::scoped_lock lock(mutex_);
  const ErrorsThrown errors;
  set_up();
  compose(capture, robot);
  const Transform base_from_camera = upright(spec.base_from_camera, spec.mount_height);
  draw(picture.intrinsics, base(robot) * base_from_camera, {picture.color, picture.depth, {}}, state.variation);
  brighten(state, picture.color);
  models::add_color_noise(spec, state.key, state.step, picture.color);
  if (spec.depth) models::measure_depth(*spec.depth, state.key, state.step, picture.depth);
  return picture;
}

SemanticImage Drawer::look(const simulated::WorldCapture& capture, const CameraIntrinsics& camera,
                           const sim::CameraPose& view, bool with_itself) {
  check(camera);
  const std::size_t pixels = pixels_of(camera);
  SemanticImage truth{{camera, std::vector<std::uint8_t>(3 * pixels), std::vector<float>(pixels)},
                      std::vector<std::int16_t>(pixels),
                      sim::id_names(*world_)};
  const std::scoped_lock lock(mutex_);
  const ErrorsThrown errors;
  set_up();
  compose(capture, with_itself ? world_->robots.size() : capture.state.key.robot);
  draw(camera, upright(view.pose, view.height), {truth.image.color, truth.image.depth, truth.ids},
       capture.state.variation);
  brighten(capture.state, truth.image.color);
  return truth;
}

// All that is in sight, but for the robot `without`.
void Drawer::compose(const simulated::WorldCapture& capture, std::size_t without) {
  mj_.mj_setState(model_.get(), data_.get(), capture.physics.data(), mjSTATE_INTEGRATION);
  mj_.mj_kinematics(model_.get(), data_.get());
  mjvOption option;
  mj_.mjv_defaultOption(&option);
  std::ranges::fill(option.geomgroup, mjtByte{1});
  std::ranges::fill(option.sitegroup, mjtByte{0});
  std::ranges::fill(option.flags, mjtByte{0});
  option.flags[mjVIS_STATIC] = 1;
  mjvCamera free_camera;
  mj_.mjv_defaultCamera(&free_camera);
  mj_.mjv_updateScene(model_.get(), data_.get(), &option, nullptr, &free_camera, mjCAT_ALL, scene_.get());

  const sim::Shading colors{capture.state.key.seed, capture.state.key.episode};
  int kept = 0;
  for (int i = 0; i < scene_->ngeom; ++i) {
    mjvGeom& geom = scene_->geoms[i];
    if (geom.objtype != mjOBJ_GEOM) continue;
    const Appearance& appearance = appearances_[static_cast<std::size_t>(geom.objid)];
    const bool seen = appearance.shown && geom.rgba[3] > 0.0F && !std::cmp_equal(appearance.robot, without);
    if (!seen) continue;
    if (appearance.solid >= 0) {
      shading(geom, color_of(world_->renderer().colour(colors, static_cast<std::size_t>(appearance.solid))));
    }
    if (appearance.id == sim::kWallId) shading(geom, wall_);
    if (appearance.id == sim::kCeilingId) geom.emission = kLamps;
    geom.segid = appearance.id;
    geom.specular = 0.0F;
    geom.reflectance = 0.0F;
    scene_->geoms[kept++] = geom;
  }
  scene_->ngeom = kept;

  add_ground();
  for (const sim::VisibleSolid& solid : world_->renderer().solids()) {
    if (solid.id == sim::kWallId && solid.solid.z_min > 0.0) add_solid(solid, wall_);  // a lintel
  }
  sim::find_actors(*world_, {}, 0, capture.state.people, colors.seed, colors.episode, people_);
  for (const sim::VisibleSolid& part : people_) add_solid(part, color_of(part.colour));
  light();
}

void Drawer::add(mjtGeom type, const Vec3& half, const Transform& pose, std::int16_t id, const exports::Color& color) {
  mjvGeom& geom = scene_->geoms[scene_->ngeom++];
  const std::array<double, 3> size{half.x, half.y, half.z};
  const std::array<double, 3> position{pose.position.x, pose.position.y, pose.position.z};
  const Vec3 x = rotated(pose.rotation, {1.0, 0.0, 0.0});
  const Vec3 y = rotated(pose.rotation, {0.0, 1.0, 0.0});
  const Vec3 z = rotated(pose.rotation, {0.0, 0.0, 1.0});
  const std::array<double, 9> axes{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
  mj_.mjv_initGeom(&geom, type, size.data(), position.data(), axes.data(), nullptr);
  shading(geom, color);
  geom.category = mjCAT_STATIC;
  geom.segid = id;
  geom.specular = 0.0F;
}

Transform Drawer::base(std::size_t robot) const {
  const int body = mj_.mj_name2id(model_.get(), mjOBJ_BODY, (robot_name(robot) + "/base_link").c_str());
  return placement(data_->qpos + model_->jnt_qposadr[model_->body_jntadr[body]]);
}

void Drawer::add_solid(const sim::VisibleSolid& visible, const exports::Color& color) {
  const scene::Solid& solid = visible.solid;
  const double half_height = 0.5 * (solid.z_max - solid.z_min);
  Transform pose{{solid.center.x, solid.center.y, solid.z_min + half_height}, {}};
  if (solid.shape == scene::Solid::Shape::disc) {
    add(mjGEOM_CYLINDER, {solid.radius, half_height, half_height}, pose, visible.id, color);
    return;
  }
  const Vec2 along = solid.corners[1] - solid.corners[0];
  pose.rotation = exports::about_z(exact::atan2(along.y, along.x));
  add(mjGEOM_BOX, {0.5 * norm(along), 0.5 * distance(solid.corners[1], solid.corners[2]), half_height}, pose,
      visible.id, color);
}

// Beyond the floors of the model, as far as the eye can see.
void Drawer::add_ground() {
  const scene::Scene& scene = *world_->scene;
  constexpr double kBelow = 5e-4;  // [m]
  constexpr double kThickness = 0.1;
  const Vec2 middle = 0.5 * (scene.min + scene.max);
  add(mjGEOM_BOX, {kHorizon, kHorizon, kThickness}, {{middle.x, middle.y, -kThickness - kBelow}, {}}, sim::kFloorId,
      exports::color_of(scene.ceiling ? "concrete" : "grass"));
}

// From above, with little shade.
void Drawer::light() {
  mjvLight sun{};
  sun.id = -1;
  sun.type = mjLIGHT_DIRECTIONAL;
  sun.texid = -1;
  put({0.28, 0.19, -0.94}, sun.dir);
  sun.attenuation[0] = 1.0F;
  sun.cutoff = 180.0F;
  std::ranges::fill(sun.ambient, 0.80F);
  std::ranges::fill(sun.diffuse, 0.24F);
  scene_->nlight = 1;
  scene_->lights[0] = sun;
}

void Drawer::draw(const CameraIntrinsics& camera, const Transform& scene_from_camera, const Pixels& pixels,
                  const models::Variation& variation) {
  mjvGLCamera view{};
  put(scene_from_camera.position, view.pos);
  put(rotated(scene_from_camera.rotation, {1.0, 0.0, 0.0}), view.forward);
  put(rotated(scene_from_camera.rotation, {0.0, 0.0, 1.0}), view.up);
  view.frustum_center = static_cast<float>(kNear * (0.5 * camera.width - camera.cx) / camera.fx);
  view.frustum_bottom = static_cast<float>(-kNear * (camera.height - camera.cy) / camera.fy);
  view.frustum_top = static_cast<float>(kNear * camera.cy / camera.fy);
  view.frustum_width = static_cast<float>(0.5 * kNear * camera.width / camera.fx);
  view.frustum_near = static_cast<float>(kNear);
  view.frustum_far = static_cast<float>(kFar);
  scene_->camera[0] = scene_->camera[1] = view;

  const GlContext::Current current(*gl_);
  if (context_->offWidth != camera.width || context_->offHeight != camera.height) {
    mj_.mjr_resizeOffscreen(camera.width, camera.height, context_.get());
  }
  mj_.mjr_setBuffer(mjFB_OFFSCREEN, context_.get());
  if (!pixels.color.empty() || !pixels.depth.empty()) read_colors(camera, pixels);
  if (!pixels.ids.empty()) read_ids(camera, pixels.ids);
  if (variation.texture != 0.0) wear(camera, scene_from_camera, pixels, variation);
}

// MuJoCo paints plainly; patterns come on top of what it painted.
void Drawer::wear(const CameraIntrinsics& camera, const Transform& scene_from_camera, const Pixels& pixels,
                  const models::Variation& variation) {
  std::vector<std::int16_t> ids(pixels_of(camera));
  std::vector<float> depth(ids.size());
  read_ids(camera, ids);
  const auto width = static_cast<std::size_t>(camera.width);
  const auto height = static_cast<std::size_t>(camera.height);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const float nearness = depth_[(height - 1 - i / width) * width + i % width];
    if (nearness > 0.0F) depth[i] = static_cast<float>(depth_of(nearness));
  }
  wear_patterns(*world_, variation, camera, scene_from_camera, {ids, depth}, pixels.color);
}

void Drawer::render(const CameraIntrinsics& camera) {
  const mjrRect all{0, 0, camera.width, camera.height};
  rgb_.resize(3 * pixels_of(camera));
  depth_.resize(pixels_of(camera));
  mj_.mjr_render(all, scene_.get(), context_.get());
  mj_.mjr_readPixels(rgb_.data(), depth_.data(), all, context_.get());
}

// MuJoCo's first row is the lowest.
void Drawer::read_colors(const CameraIntrinsics& camera, const Pixels& pixels) {
  std::ranges::fill(scene_->flags, mjtByte{0});
  scene_->flags[mjRND_CULL_FACE] = 1;
  render(camera);
  const auto width = static_cast<std::size_t>(camera.width);
  const auto height = static_cast<std::size_t>(camera.height);
  for (std::size_t row = 0; row < height; ++row) {
    const double slope = (camera.cy - (static_cast<double>(row) + 0.5)) / camera.fy;
    const sim::Colour sky = sim::view::sky_colour(static_cast<float>(slope));
    const std::array<float, 3> nothing{sky.b, sky.g, sky.r};
    for (std::size_t column = 0; column < width; ++column) {
      const std::size_t from = (height - 1 - row) * width + column;
      const std::size_t to = row * width + column;
      const float nearness = depth_[from];
      for (std::size_t i = 0; i < 3; ++i) {
        pixels.color[3 * to + i] =
            nearness > 0.0F ? rgb_[3 * from + 2 - i] : static_cast<std::uint8_t>(std::lround(nothing[i]));
      }
      if (pixels.depth.empty()) continue;
      pixels.depth[to] = nearness > 0.0F ? static_cast<float>(depth_of(nearness)) : 0.0F;
    }
  }
}

// MuJoCo paints each pixel in the number of what it shows plus one, its lowest byte in red.
void Drawer::read_ids(const CameraIntrinsics& camera, std::span<std::int16_t> ids) {
  std::ranges::fill(scene_->flags, mjtByte{0});
  scene_->flags[mjRND_CULL_FACE] = scene_->flags[mjRND_SEGMENT] = scene_->flags[mjRND_IDCOLOR] = 1;
  render(camera);
  const auto width = static_cast<std::size_t>(camera.width);
  const auto height = static_cast<std::size_t>(camera.height);
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t column = 0; column < width; ++column) {
      const std::uint8_t* rgb = &rgb_[3 * ((height - 1 - row) * width + column)];
      const int id = rgb[0] + 256 * rgb[1] - 1;
      ids[row * width + column] = static_cast<std::int16_t>(std::max(id, 0));
    }
  }
}

}  // namespace threewe::backend::mujoco
