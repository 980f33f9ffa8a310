// See: colour and depth of an RGB-D camera, points in space, and what the simulator knows about each pixel.
#include <cmath>
#include <iostream>
#include <string_view>

#include "threewe/threewe.hpp"

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  threewe::Robot robot({.hardware = "3we_depth_v2", .scene = "apartment_v1"});
  (void)robot.wait(robot.rotate(quick ? 0.5 : 2.0));

  // colours are blue, green, red; depth is in metres along the optical axis, 0 where nothing was measured
  const threewe::RGBDImage& image = robot.get_rgbd_image();
  const threewe::CameraIntrinsics& camera = image.intrinsics;
  std::cout << camera.width << " x " << camera.height << " pixels\n";

  // every pixel with depth is a point: x forward, y left, z up, from the camera
  const double height = robot.runtime().profile().camera->mount_height;
  double nearest = 1e9;
  threewe::Vec2 where;
  std::size_t pixel = 0;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const auto x = static_cast<double>(image.depth[pixel++]);
      const double y = -(column + 0.5 - camera.cx) / camera.fx * x;
      const double z = -(row + 0.5 - camera.cy) / camera.fy * x;
      const bool on_floor = z + height < 0.05;
      if (x == 0.0 || on_floor || std::hypot(x, y) >= nearest) continue;
      nearest = std::hypot(x, y);
      where = {x, y};
    }
  }
  std::cout << "nearest thing: " << where.x << " m ahead, " << where.y << " m to the left\n";

  // the truth, which robots never see: for training, and for metrics
  const threewe::SemanticImage truth = robot.simulation()->look();
  const std::size_t middle = truth.ids.size() / 2 + static_cast<std::size_t>(camera.width / 2);
  std::cout << "in the middle: " << truth.names[static_cast<std::size_t>(truth.ids[middle])] << '\n';
}
