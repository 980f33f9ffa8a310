// Object detector: the things that a camera's picture shows, with kind, color, bearing and distance of each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
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
  int cells = 0;                   ///< how many of the detector's cells, 1/40 of the view's width each, show it
  double bearing = 0.0;            ///< [rad] from the camera's axis to the thing's centre, to the left
  double distance = 0.0;           ///< [m] along the camera's axis to the thing's centre
  std::array<float, 11> colors{};  ///< share of each of `color_names` in what is seen of it

  /// The color term that most of it has, index into `color_names`.
  std::size_t color() const;
};

/// The eleven basic color terms.
std::span<const std::string_view> color_names();
/// The color term of a pixel, index into `color_names`.
std::uint8_t color_of(std::uint8_t blue, std::uint8_t green, std::uint8_t red);

/// What finds things in pictures. Const once made.
struct DetectorModel {
  virtual ~DetectorModel() = default;
  /// The things that a picture of the size of its intrinsics shows, largest first.
  virtual std::vector<Detection> detect(std::span<const std::uint8_t> picture,
                                        const CameraIntrinsics& camera) const = 0;

  std::vector<std::string> labels;  ///< what it can tell apart; the first is the background
  std::vector<double> radii;        ///< [m] of each label
  std::string description;          ///< what it was trained on
};

/// A model, as those who use it see it. The one that ships is a convolutional network in integer arithmetic, and what
/// makes things of its outputs: the same bits on every machine. Copies share the model.
class Detector {
 public:
  /// Of a model of one's own.
  explicit Detector(std::shared_ptr<const DetectorModel> model) : model_(std::move(model)) {}
  /// Reads assets/detectors/NAME.safetensors, or a file that ends in .safetensors. Throws ConfigError.
  static Detector load(std::string_view name = "indoor_v1");

  /// What it can tell apart; the first is the background.
  const std::vector<std::string>& labels() const { return model_->labels; }
  /// The radius [m] of the circle that things of each label usually fit in; 0 where it is not known.
  const std::vector<double>& radii() const { return model_->radii; }
  /// What it was trained on, in words.
  const std::string& description() const { return model_->description; }
  /// The things that a picture (H, W, 3), blue, green and red, of a level camera shows, largest first. Throws
  /// ContractError for a picture whose size is not that of its intrinsics.
  std::vector<Detection> detect(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) const;

 private:
  std::shared_ptr<const DetectorModel> model_;
};

}  // namespace threewe::vision
