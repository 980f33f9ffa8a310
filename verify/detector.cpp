// What the object detector makes of pictures from a scene that it has not seen:
//
//   verify_detector SEED            on every vector target that this machine has, a hash of all that it finds
//   verify_detector SEED --time     what one look takes [ms of one thread's CPU time]
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/targets.hpp"
#include "hash.hpp"
#include "number.hpp"
#include "seconds.hpp"
#include "threewe/robot/robot.hpp"
#include "vision/detector.hpp"

using namespace threewe;

namespace {

constexpr int kPictures = 10;
constexpr int kLooks = 5;  // at each

// What a robot's camera shows at free poses of the office, noise and all.
std::vector<RGBDImage> take_pictures(std::uint64_t seed) {
  std::vector<RGBDImage> pictures;
  Robot robot({.seed = seed});
  for (std::uint64_t i = 0; i < kPictures; ++i) {
    robot.world().reset({.seed = seed, .poses = {robot.simulation()->sample_free_pose(seed + i)}});
    robot.world().settle();
    pictures.push_back(robot.get_camera_image());
  }
  return pictures;
}

std::uint64_t hash_of(const vision::Detector& detector, const std::vector<RGBDImage>& pictures) {
  Hash hash;
  std::uint64_t found = 0;
  for (const RGBDImage& picture : pictures) {
    for (const vision::Detection& thing : detector.detect(picture.color, picture.intrinsics)) {
      ++found;
      hash.add(std::span(thing.scores));
      for (const int edge : {thing.x_min, thing.y_min, thing.x_max, thing.y_max, thing.cells})
        hash.add(static_cast<std::uint64_t>(edge));
      hash.add(thing.bearing);
      hash.add(thing.distance);
      hash.add(std::uint64_t{thing.kind});
      hash.add(std::span(thing.colors));
    }
  }
  if (found == 0) std::fputs("nothing was found: that is no comparison\n", stderr);
  return found == 0 ? 0 : hash.value();
}

// The median of all looks.
double milliseconds(const vision::Detector& detector, const std::vector<RGBDImage>& pictures) {
  std::vector<double> times;
  for (int i = 0; i < kLooks; ++i) {
    for (const RGBDImage& picture : pictures) {
      const double before = seconds_by(CLOCK_THREAD_CPUTIME_ID);
      (void)detector.detect(picture.color, picture.intrinsics);
      times.push_back(1e3 * (seconds_by(CLOCK_THREAD_CPUTIME_ID) - before));
    }
  }
  std::ranges::nth_element(times, times.begin() + kPictures * kLooks / 2);
  return times[kPictures * kLooks / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc > 1 ? argv[1] : "");
  const bool timed = argc == 3 && std::strcmp(argv[2], "--time") == 0;
  if (!seed || (argc == 3 && !timed) || argc > 3) {
    std::fputs("usage: verify_detector SEED [--time]\n", stderr);
    return 2;
  }
  const vision::Detector detector = vision::Detector::load();
  const std::vector<RGBDImage> pictures = take_pictures(*seed);
  if (timed) {
    std::printf("milliseconds %.3f\n", milliseconds(detector, pictures));
    return 0;
  }
  for (const std::string& target : available_targets()) {
    force_target(target);
    const std::uint64_t hash = hash_of(detector, pictures);
    if (hash == 0) return 1;
    print_hash(target, hash);
  }
  return 0;
}
