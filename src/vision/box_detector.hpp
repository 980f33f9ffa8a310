// Layout of a box detector: what the outputs of a network mean that finds boxes in pictures, such as one of the YOLO
// family. The network itself runs elsewhere.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "vision/detector.hpp"

namespace threewe::vision {

/// Of a YAML file. What it leaves out is as here.
struct BoxLayout {
  std::vector<std::string> labels;  ///< in the order of the network's scores; empty: a kind that is not used
  std::vector<double> radii;        ///< [m] of the circle that things of each label usually fit in
  bool rgb = true;                  ///< order of the input's channels; else blue, green, red
  double scale = 255.0;             ///< by which pixels are divided first
  std::array<double, 3> mean{};     ///< of each channel after that, which is taken away
  std::array<double, 3> deviation{1.0, 1.0, 1.0};  ///< by which it is divided then
  bool centers = true;                             ///< boxes are centre and size; else two corners
  double confidence = 0.3;                         ///< least score of a box
  double overlap = 0.5;                            ///< intersection over union above which two boxes are of one thing
  std::string description;                         ///< what it was trained on, in words; may be empty

  /// Reads a file. Throws ConfigError with file:line.
  static BoxLayout load(const std::filesystem::path& file);
};

/// Rows of a network's output, each four numbers of a box [px of the picture] and a score of 0 to 1 for each label.
using BoxRows = std::vector<float>;
/// Finds them in a picture (height, width, 3), blue, green and red.
using BoxFinder = std::function<BoxRows(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera)>;

/// A detector that makes things of such rows. A thing's distance follows from its box's width and the radius of its
/// kind, its color from the middle half of the box. It throws ConfigError for rows of another length, or not finite.
Detector box_detector(const BoxLayout& layout, BoxFinder find);

}  // namespace threewe::vision
