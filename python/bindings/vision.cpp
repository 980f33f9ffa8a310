// The object detector.
#include "vision/detector.hpp"

#include <nanobind/stl/array.h>

#include "bindings.hpp"
#include "value.hpp"

using namespace threewe;
using vision::Detection, vision::Detector;

namespace {

std::vector<std::string> colors() { return {vision::color_names().begin(), vision::color_names().end()}; }

}  // namespace

void init_vision(nb::module_& m) {
  nb::class_<Detection>(m, "Detection", "One thing in a picture.")
      .def_prop_ro(
          "color", [](const Detection& d) { return std::string(vision::color_names()[d.color]); },
          "the basic color term of most of what is seen of it")
      .def_ro("color_share", &Detection::color_share, "0 to 1, how much of it is of that color")
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
  m.def("color_names", &colors, "The eleven basic color terms.");
  m.def(
      "color_of",
      [](std::uint8_t blue, std::uint8_t green, std::uint8_t red) {
        return std::string(vision::color_names()[vision::color_of(blue, green, red)]);
      },
      "blue"_a, "green"_a, "red"_a, "The color term of a pixel, each of 0 to 255.");
}
