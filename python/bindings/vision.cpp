// The object detector.
#include "vision/box_detector.hpp"
#include "vision/detector.hpp"

#include <nanobind/stl/array.h>

#include "bindings.hpp"
#include "color_shares.hpp"
#include "value.hpp"

using namespace threewe;
using vision::BoxLayout, vision::Detection, vision::Detector;

namespace {

std::vector<std::string> colors() { return {vision::color_names().begin(), vision::color_names().end()}; }

using Picture = nb::ndarray<nb::numpy, const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig>;
using Rows = nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

/// A function of Python's as a finder of boxes: it is called with the picture, whichever thread looks.
vision::BoxFinder finder_of(nb::callable function) {
  const auto held = std::shared_ptr<nb::callable>(new nb::callable(std::move(function)), [](nb::callable* callable) {
    const nb::gil_scoped_acquire python;
    delete callable;
  });
  return [held](std::span<const std::uint8_t> pixels, const CameraIntrinsics& camera) {
    const nb::gil_scoped_acquire python;
    const auto height = static_cast<std::size_t>(camera.height);
    const auto width = static_cast<std::size_t>(camera.width);
    const Picture picture(pixels.data(), {height, width, 3}, nb::none());
    const auto rows = nb::cast<Rows>((*held)(nb::cast(picture, nb::rv_policy::copy)));
    return vision::BoxRows(rows.data(), rows.data() + rows.size());
  };
}

}  // namespace

void init_vision(nb::module_& m) {
  nb::class_<Detection>(m, "Detection", "One thing in a picture.")
      .def_prop_ro(
          "color", [](const Detection& d) { return std::string(vision::color_names()[d.color()]); },
          "the basic color term of most of what is seen of it")
      .def_prop_ro(
          "colors", [](const Detection& d) { return color_shares(d.colors); },
          "by the names of the basic color terms that it has, the share of each in what is seen of it")
      .def_ro("kind_index", &Detection::kind, "index into the detector's labels")
      .def_ro("scores", &Detection::scores, "(labels,) probability of each label")
      .def_ro("confidence", &Detection::confidence, "0 to 1, that it is of its kind")
      .def_prop_ro(
          "box", [](const Detection& d) { return std::array{d.x_min, d.y_min, d.x_max, d.y_max}; },
          "[px] x and y from, x and y to (excluded)")
      .def_ro("cells", &Detection::cells, "how many cells of 1/40 of the view's width show it")
      .def_ro("bearing", &Detection::bearing, "[rad] from the camera's axis to its centre, to the left")
      .def_ro("distance", &Detection::distance, "[m] along the camera's axis to its centre");
  nb::class_<Detector>(m, "Detector", "Object detector in integer arithmetic: the same bits on every machine.")
      .def_static("load", &Detector::load, "name"_a = "indoor_v1",
                  "Reads one that is shipped, or a file that ends in .safetensors. Raises ConfigError.")
      .def_static(
          "of_boxes",
          [](const BoxLayout& layout, nb::callable find) { return box_detector(layout, finder_of(std::move(find))); },
          "layout"_a, "find"_a,
          nb::sig("def of_boxes(layout: BoxLayout, find: collections.abc.Callable[..., object]) -> Detector"),
          "One of a function that is given a picture, and returns (N, 4 + labels) float32: boxes [px] and scores.")
      .def_prop_ro("labels", &Detector::labels, "what it can tell apart; the first is the background")
      .def_prop_ro("radii", &Detector::radii, "[m] of the circle that things of each label usually fit in")
      .def_prop_ro("description", &Detector::description, "what it was trained on")
      .def(
          "detect",
          [](const Detector& self,
             const nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>& picture,
             const CameraIntrinsics& camera) {
            const nb::gil_scoped_release other_threads_run;
            return self.detect({picture.data(), picture.size()}, camera);
          },
          "picture"_a, "camera"_a,
          "The things in a (H, W, 3) uint8 BGR picture of a level camera, largest first. Raises ContractError.");
  nb::class_<BoxLayout>(m, "BoxLayout", "What the outputs of a network mean that finds boxes in pictures.")
      .def_static(
          "load", [](const std::string& path) { return BoxLayout::load(path); }, "path"_a,
          "Reads a YAML file. Raises ConfigError with file:line.")
      .def_ro("labels", &BoxLayout::labels, "in the order of the network's scores; empty: not used")
      .def_ro("radii", &BoxLayout::radii, "[m]")
      .def_ro("rgb", &BoxLayout::rgb, "order of the input's channels; else BGR")
      .def_ro("scale", &BoxLayout::scale, "by which pixels are divided first")
      .def_ro("mean", &BoxLayout::mean, "of each channel after that, which is taken away")
      .def_ro("deviation", &BoxLayout::deviation, "by which it is divided then")
      .def_ro("centers", &BoxLayout::centers, "boxes are centre and size; else two corners")
      .def_ro("confidence", &BoxLayout::confidence, "least score of a box")
      .def_ro("overlap", &BoxLayout::overlap, "above which two boxes are of one thing");
  m.def("color_names", &colors, "The eleven basic color terms.");
  m.def(
      "color_of",
      [](std::uint8_t blue, std::uint8_t green, std::uint8_t red) {
        return std::string(vision::color_names()[vision::color_of(blue, green, red)]);
      },
      "blue"_a, "green"_a, "red"_a, "The color term of a pixel, each of 0 to 255.");
}
