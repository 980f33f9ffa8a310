// The trail of a robot whose front-end drifts: round and round in one room.
#include "slam/keyframe_graph.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/tiny_world.hpp"

namespace threewe::slam {
namespace {

using threewe::testing::add_box;
using threewe::testing::tiny_range;
using threewe::testing::TinyWall;

/// A hall with a pillar and cabinets along its walls, and a robot that goes round it on a circle.
class Hall {
 public:
  /// `lost`: the front-end takes 5 % too much for each step, and knows that it may be far off.
  explicit Hall(std::uint64_t seed, bool lost = false) : draw_(seed), lost_(lost) {
    add_box(walls_, {-6, -5}, {6, 5});
    add_box(walls_, {-0.4, -0.3}, {0.4, 0.3});
    for (int i = 0; i < 5; ++i) {
      const Vec2 corner{-5.5 + 2.2 * i, i % 2 == 0 ? 4.0 : -5.0};
      add_box(walls_, corner, corner + Vec2{draw_(0.4, 1.2), draw_(0.4, 0.9)});
    }
  }

  Pose2D truth() const { return truth_; }
  /// Half a metre on; the front-end slips about as much as was measured.
  FrontEndScan next() {
    const double turn = 0.5 / kRadius;
    truth_ = integrate(truth_, {0.5, 0.0, turn}, 1.0);
    local_ = integrate(
        local_, {(lost_ ? 0.525 : 0.5) + draw_(-0.01, 0.01), draw_(-0.01, 0.01), turn + draw_(-0.002, 0.002)}, 1.0);
    FrontEndScan point{from_seconds(static_cast<double>(++steps_)), local_, Matrix3::Zero(), {}, 0.0};
    if (lost_) point.covariance.diagonal() << 0.05 * steps_, 0.05 * steps_, 0.0;
    for (int i = 0; i < 180; ++i) {
      const double angle = (i - 90) * exact::kPi / 180.0;
      const double range = tiny_range(walls_, truth_.position(), truth_.theta + angle, 30.0) + draw_(-0.015, 0.015);
      point.beams.push_back({{}, rotate({1.0, 0.0}, angle), range, true});
    }
    return point;
  }

 private:
  static constexpr double kRadius = 3.0;
  Draw draw_;
  bool lost_;
  std::vector<TinyWall> walls_;
  Pose2D truth_{kRadius, 0.0, 0.5 * exact::kPi};
  Pose2D local_;
  int steps_ = 0;
};

std::size_t beams_in(const KeyframeGraphData& keyframe_graph) {
  std::size_t count = 0;
  for (const Keyframe& keyframe : keyframe_graph.keyframes) {
    for (const Keyframe::Scan& scan : keyframe.scans) count += scan.beams.beams.size();
  }
  return count;
}

TEST_CASE("in a bounded place memory is bounded, and the map stays right") {
  for (std::uint64_t seed = 0; seed < cases(3); ++seed) {
    CAPTURE(seed);
    Hall hall(seed);
    const FrontEndScan first = hall.next();
    const Pose2D hall_from_map = hall.truth();
    KeyframeGraph keyframe_graph;
    keyframe_graph.add(first);
    std::vector<Pose2D> truth{{}};
    std::vector<std::size_t> beams;
    for (int i = 1; i < 1200; ++i) {
      const FrontEndScan point = hall.next();
      const Pose2D found = keyframe_graph.add(point);
      truth.push_back(inverse(hall_from_map) * hall.truth());
      CHECK(distance(found.position(), truth.back().position()) < 0.15);
      if (i % 300 == 299) beams.push_back(beams_in(keyframe_graph.data()));
    }
    // 600 m of way; what is kept is that of some rounds of 19 m, and no more after the second quarter
    CHECK(static_cast<double>(beams[3]) < 1.15 * static_cast<double>(beams[1]));
    CHECK(beams[3] < 180U * 400U);
    const KeyframeGraphData& data = keyframe_graph.data();
    CHECK(data.keyframes.size() == data.graph.poses().size());
    CHECK(data.keyframes.size() < 220);
    REQUIRE(data.steps.size() == 1200);
    double sum = 0.0;
    for (std::size_t i = 0; i < data.steps.size(); ++i) {
      sum += distance(data.pose_of(data.steps[i]).position(), truth[i].position());
    }
    CHECK(sum / 1200.0 < 0.06);
  }
}

TEST_CASE("who has lost the way for metres finds it again, when two closures agree") {
  for (std::uint64_t seed = 0; seed < cases(5); ++seed) {
    CAPTURE(seed);
    Hall hall(seed, true);
    const FrontEndScan first = hall.next();
    const Pose2D hall_from_map = hall.truth();
    KeyframeGraph keyframe_graph;
    keyframe_graph.add(first);
    std::vector<Pose2D> truth{{}};
    double farthest = 0.0;
    for (int i = 1; i < 120; ++i) {
      const FrontEndScan point = hall.next();
      truth.push_back(inverse(hall_from_map) * hall.truth());
      farthest = std::max(farthest, distance(keyframe_graph.add(point).position(), truth.back().position()));
    }
    CHECK(farthest > 0.25);
    const KeyframeGraphData& data = keyframe_graph.data();
    int closures = 0;
    for (const Constraint& c : data.graph.constraints()) {
      if (!c.doubtful) continue;
      ++closures;
      const auto truth_of = [&](int keyframe) {
        const Time stamp = data.keyframes[static_cast<std::size_t>(keyframe)].stamp;
        return truth[static_cast<std::size_t>((stamp - data.keyframes.front().stamp) / 1s)];
      };
      const Pose2D off = inverse(inverse(truth_of(c.from)) * truth_of(c.to)) * c.from_from_to;
      CHECK(norm(off.position()) < 0.2);  // the front-end's metres are 5 % too long, and bend what is compared
      CHECK(std::fabs(off.theta) < 0.05);
    }
    CHECK(closures >= 2);
  }
}

TEST_CASE("dropping a submap moves nothing, and all that is left hangs together") {
  for (std::uint64_t seed = 0; seed < cases(5); ++seed) {
    CAPTURE(seed);
    Hall hall(seed);
    KeyframeGraph keyframe_graph;
    for (int i = 0; i < 300; ++i) keyframe_graph.add(hall.next());
    KeyframeGraphData data = keyframe_graph.data();
    std::vector<Pose2D> before;
    for (const TrajectoryStep& step : data.steps) before.push_back(data.pose_of(step));
    int dropped = 0;
    // other ways lead along all of it: as if the robot had gone round some more
    const auto copies = [&](const KeyframeGraphData& d) {
      KeyframeGraphData more = d;
      for (int k = 0; k <= d.newest(); ++k) {
        const int node = more.graph.add_node(d.pose_of(k));
        more.graph.add_constraint({node - 1, node, inverse(more.pose_of(node - 1)) * more.pose_of(node)});
        more.keyframes.push_back(d.keyframes[static_cast<std::size_t>(k)]);
        more.keyframes.back().driven = more.driven_at(node - 1) + 1.0;
        more.extend_submaps(Params::Graph{}.submap_length);
      }
      return more;
    };
    data = copies(data);
    while (data.prune({})) {
      ++dropped;
      for (std::size_t i = 0; i < before.size(); ++i) {
        const Pose2D now = data.pose_of(data.steps[i]);
        CHECK(distance(now.position(), before[i].position()) < 1e-9);
        CHECK(std::fabs(wrap_angle(now.theta - before[i].theta)) < 1e-9);
      }
      REQUIRE(data.graph.poses().size() == data.keyframes.size());
      int next = 0;
      for (const Submap& submap : data.submaps) {
        CHECK(submap.first == next);
        CHECK(submap.last >= submap.first);
        next = submap.last + 1;
      }
      CHECK(next == data.newest() + 1);
      CHECK_NOTHROW(data.graph.solve(0));  // which wants every node to hang together with the first
    }
    CHECK(dropped > 0);
  }
}

}  // namespace
}  // namespace threewe::slam
