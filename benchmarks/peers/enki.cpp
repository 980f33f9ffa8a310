// Enki: a round robot on two wheels with a camera all round, whose pixels serve as a lidar (needs Debian's
// libenki-dev). It counts in centimetres.
#include <enki/PhysicalEngine.h>
#include <enki/interactions/CircularCam.h>
#include <enki/robots/DifferentialWheeled.h>

#include <memory>
#include <utility>

#include "world.hpp"

namespace {

constexpr double kScale = 100.0;  // [1/m]
constexpr double kRoom = 60.0;    // [m] of its world, whose corner is the origin
constexpr double kTrack = 18.0;   // [cm]

struct Robot : Enki::DifferentialWheeled {
  std::unique_ptr<Enki::OmniCam> lidar;

  Robot(int beams, double range) : DifferentialWheeled(kTrack, 100.0, 0.0) {
    setCylindric(13.0, 10.0, 2500.0);
    if (beams == 0) return;
    lidar = std::make_unique<Enki::OmniCam>(this, 13.5, static_cast<unsigned>(beams / 2));
    lidar->setRange(kScale * range);
    addLocalInteraction(lidar.get());
  }
};

Enki::Point place(double x, double y) { return {kScale * (x + 0.5 * kRoom), kScale * (y + 0.5 * kRoom)}; }

// Corners counter-clockwise, of a disc twelve.
Enki::Polygon outline(const peers::Solid& solid) {
  Enki::Polygon corners;
  const auto add = [&](double along, double across) {
    const double c = std::cos(solid.theta);
    const double s = std::sin(solid.theta);
    corners.push_back(place(solid.x + c * along - s * across, solid.y + s * along + c * across));
  };
  if (solid.radius > 0.0) {
    for (int i = 0; i < 12; ++i) add(solid.radius * std::cos(i * M_PI / 6), solid.radius * std::sin(i * M_PI / 6));
  } else {
    const double l = 0.5 * solid.length;
    const double w = 0.5 * solid.width;
    for (const auto& [along, across] : {std::pair{-l, -w}, {l, -w}, {l, w}, {-l, w}}) add(along, across);
  }
  return corners;
}

// All in one object that does not move: Enki tries every pair of objects in every step, which takes 12 ms with 362.
void furnish(Enki::World& office, const peers::World& world) {
  constexpr double kHeight = 150.0;  // [cm]
  constexpr double kFixed = -1.0;    // its mass
  Enki::PhysicalObject::Hull hull;
  for (const peers::Solid& solid : cut(world)) hull.emplace_back(outline(solid), kHeight);
  auto everything = std::make_unique<Enki::PhysicalObject>();
  everything->setCustomHull(hull, kFixed);
  office.addObject(everything.release());  // which deletes it
}

void time_drives(const peers::World& world, int beams) {
  Enki::World office(kScale * kRoom, kScale * kRoom);
  furnish(office, world);
  auto* robot = new Robot(beams, world.lidar_range);
  office.addObject(robot);  // which deletes it

  const auto begin = [&](const peers::Place& pose) {
    robot->pos = place(pose.x, pose.y);
    robot->angle = pose.theta;
    robot->leftSpeed = kScale * peers::kForward - 0.5 * kTrack * peers::kTurn;
    robot->rightSpeed = kScale * peers::kForward + 0.5 * kTrack * peers::kTurn;
  };
  double sum = 0.0;
  for (std::size_t i = 0; robot->lidar && i < peers::kLookedAt; ++i) {
    begin(world.poses[i]);
    office.step(1e-9, 1);
    for (const double square : robot->lidar->zbuffer) sum += std::min(world.lidar_range, std::sqrt(square) / kScale);
  }
  std::string fields =
      "\"kind\": \"step\", \"who\": \"Enki 1.6.99, C++\", \"substeps\": " + std::to_string(world.substeps) +
      ", \"period\": " + std::to_string(world.period()) + ", \"range\": " + std::to_string(world.lidar_range) +
      ", \"differs\": \"speed of the wheels set at once, contact in 2D with all outlines; scan by projection\"";
  if (beams > 0) fields += ", \"mean_range\": " + std::to_string(sum / (beams * static_cast<double>(peers::kLookedAt)));
  peers::report(fields, std::to_string(beams), static_cast<double>(peers::kFew) * peers::kRun, [&] {
    for (std::size_t i = 0; i < peers::kFew; ++i) {
      begin(world.poses[i]);
      for (int step = 0; step < peers::kRun; ++step) office.step(world.period(), static_cast<unsigned>(world.substeps));
    }
  });
}

}  // namespace

int main(int, char** argv) {
  const peers::World world = peers::read_world(argv[1]);
  for (const int beams : {0, 64, 360}) time_drives(world, beams);
}
