// Object detector: the things that a camera's picture shows, with kind, color, bearing and distance of each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/camera.hpp"

namespace threewe::vision {

/// One thing in a picture.
struct Detection {
  std::size_t kind = 0;       ///< index into `Detector::labels`, never 0: that is the background
  std::vector<float> scores;  ///< probability of each label, shape (labels,)
  float confidence = 0.0F;    ///< that it is of this kind
  int x_min = 0;              ///< [px] the box around it in the picture, the last ones excluded
  int y_min = 0;
  int x_max = 0;
  int y_max = 0;
  int cells = 0;             ///< how many of the detector's cells, 1/40 of the view's width each, show it
  double bearing = 0.0;      ///< [rad] from the camera's axis to the thing's centre, to the left
  double distance = 0.0;     ///< [m] along the camera's axis to the thing's centre
  std::uint8_t color = 0;    ///< index into `color_names`, of most of what is seen of it
  float color_share = 0.0F;  ///< how much of it is of that color
};

/// The eleven basic color terms.
std::span<const std::string_view> color_names();
/// The color term of a pixel, index into `color_names`.
std::uint8_t color_of(std::uint8_t blue, std::uint8_t green, std::uint8_t red);

/// Convolutional network in integer arithmetic, and what makes things of its outputs. The same bits on every machine.
/// Copies share the weights.
class Detector {
 public:
  /// Reads assets/detectors/NAME.safetensors, or a file that ends in .safetensors. Throws ConfigError.
  static Detector load(std::string_view name = "indoor_v1");

  /// What it can tell apart; the first is the background.
  const std::vector<std::string>& labels() const;
  /// The radius [m] of the circle that things of each label usually fit in; 0 where it is not known.
  const std::vector<double>& radii() const;
  /// What it was trained on, in words.
  const std::string& description() const;
  /// The things that a picture (H, W, 3), blue, green and red, of a level camera shows, largest first. Throws
  /// ContractError for a picture whose size is not that of its intrinsics.
  std::vector<Detection> detect(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) const;

 private:
  struct Model;
  explicit Detector(std::shared_ptr<const Model> model);
  std::shared_ptr<const Model> model_;
};

}  // namespace threewe::vision
