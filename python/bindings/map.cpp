// Maps.
#include <nanobind/stl/pair.h>

#include "as_array.hpp"
#include "bindings.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/map/ros_map.hpp"
#include "threewe/map/zone.hpp"
#include "value.hpp"

using namespace threewe;
using map::Cell, map::OccupancyGrid;

void init_map(nb::module_& m) {
  nb::class_<map::Zone>(m, "Zone",
                        "A polygon on the floor, in `map`, to keep out of; with a `speed_limit` to drive slowly in.")
      .def(Value())
      .def(
          "__init__",
          [](map::Zone* self, std::vector<Vec2> corners, std::optional<double> speed_limit) {
            new (self) map::Zone{std::move(corners), speed_limit};
          },
          "corners"_a, nb::kw_only(), "speed_limit"_a = nb::none())
      .def_ro("corners", &map::Zone::corners, "(x, y) [m], in order; the last is joined to the first")
      .def_ro("speed_limit", &map::Zone::speed_limit, "[m/s] while any part of the body is in it, or None")
      .def("contains", &map::Zone::contains, "point"_a, "Whether a point (x, y) [m] lies inside.")
      .def("__repr__", [](const map::Zone& zone) {
        return zone.speed_limit ? fmt::format("Zone({} corners, {:.2f} m/s)", zone.corners.size(), *zone.speed_limit)
                                : fmt::format("Zone({} corners, keep out)", zone.corners.size());
      });
  nb::class_<OccupancyGrid>(
      m, "OccupancyGrid",
      "What is free, occupied and unknown, as ROS defines it: -1 unknown, 0 free to 100 occupied.\n\n"
      "Row-major; cell (0, 0) has its lower left corner at `origin`, axes along the map frame's.")
      .def(Value())
      .def(
          "__init__",
          [](OccupancyGrid* self,
             const nb::ndarray<const std::int8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>& data, double resolution,
             Vec2 origin) {
            if (!map::fits_a_grid(static_cast<double>(data.shape(1)), static_cast<double>(data.shape(0)))) {
              throw ContractError(
                  fmt::format("data must have at most 8192 cells a side and 16.7 million in all, not {}"
                              " x {}",
                              data.shape(0), data.shape(1)));
            }
            OccupancyGrid grid{static_cast<int>(data.shape(1)), static_cast<int>(data.shape(0)), resolution, origin,
                               std::vector<std::int8_t>(data.data(), data.data() + data.size())};
            check_bounds(grid);
            new (self) OccupancyGrid(std::move(grid));
          },
          "data"_a, "resolution"_a = 0.05, "origin"_a = Vec2{})
      .def_prop_ro(
          "data",
          [](const OccupancyGrid& grid) {
            return ArrayView<std::int8_t, nb::ndim<2>>(
                grid.data.data(), {static_cast<std::size_t>(grid.height), static_cast<std::size_t>(grid.width)});
          },
          nb::rv_policy::reference_internal, "(H, W) int8: -1 unknown, 0 free to 100 occupied; row 0 is the lowest y")
      .def(AsArray("`data`", [](nb::handle grid) { return nb::object(grid.attr("data")); }))
      .def_ro("width", &OccupancyGrid::width, "cells along x")
      .def_ro("height", &OccupancyGrid::height, "cells along y")
      .def_ro("resolution", &OccupancyGrid::resolution, "[m] a cell")
      .def_ro("origin", &OccupancyGrid::origin, "(x, y) [m] of the corner of cell (0, 0)")
      .def(
          "cell",
          [](const OccupancyGrid& grid, Vec2 point) {
            const Cell cell = grid.cell(point);
            return std::pair(cell.y, cell.x);
          },
          "point"_a, "(row, column) of the cell that holds the point (x, y) [m]; may lie outside the grid.")
      .def(
          "at", [](const OccupancyGrid& grid, Vec2 point) { return grid.at(grid.cell(point)); }, "point"_a,
          "The value at a point (x, y) [m]; -1 outside the grid.")
      .def("__repr__", [](const OccupancyGrid& grid) {
        std::size_t known = 0;
        for (const std::int8_t value : grid.data) known += value != OccupancyGrid::kUnknown ? 1 : 0;
        const double area = static_cast<double>(known) * grid.resolution * grid.resolution;
        return fmt::format("OccupancyGrid({} x {} cells of {:.2f} m, {:.1f} m^2 known)", grid.width, grid.height,
                           grid.resolution, area);
      });
  m.def(
      "load_map", [](const std::string& path) { return map::load_ros_map(path); }, "path"_a, WithoutGil(),
      "Reads a map as ROS has maps: a file that ends in .yaml, and the picture that it names.");
  m.def(
      "save_map", [](const OccupancyGrid& grid, const std::string& path) { map::save_ros_map(grid, path); }, "grid"_a,
      "path"_a, WithoutGil(), "Writes a map as ROS has maps: `path`, which ends in .yaml, and the picture beside it.");
}
