// Maps that Slam.save kept: each is read, drawn and gone on with.
#include "fuzz.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/slam/slam.hpp"

THREEWE_FUZZER(slam)(std::string_view text) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.slam";
  fuzz::write(file, text);
  fuzz::read(
      text,
      [&] {
        slam::Slam slam = slam::Slam::load(file);
        const Time last = slam.trajectory().back().stamp;
        for (int i = 1; i < 3; ++i) {
          slam.add(last + i * 1s, {-1.5, 0.1, 0.0, 0.1, 10.0, std::vector<float>(30, 2.0F)}, {0.5 * i, 0.0, 0.0});
        }
        (void)slam.closures();
      },
      fuzz::kMapMemory);
}
