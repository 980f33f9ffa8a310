// Stand-in for Nav2 with SLAM Toolbox or AMCL: another process, on another DDS, that drives the stand-in for a robot.
//
//   ros2_nav2 DOMAIN [--scene NAME] [--profile NAME] [--humble] [--amcl] [--cyclone]
//
// It serves the actions navigate_to_pose, follow_path and follow_waypoints, and publishes /map, /plan and the transform
// map -> odom, with the covariance of the pose. Where the robot is it knows from `ros2_robot --truth`. With --humble
// types are of Humble and have no hash, else of Jazzy. With --cyclone requests and replies begin with a header, as
// those of ROS 2 on Cyclone DDS do. It prints "ready", then "VX VY OMEGA" for each initial pose that it is given.
//
// Lines of its input say how it treats goals from then on:
//
//   normal         plans, drives, and is there within 0.25 m and 0.25 rad
//   reject         takes none
//   fail CODE      aborts, with an error code, once it has driven a little; a waypoint is missed with it
//   miss CODE      the first of several waypoints is missed with that code, the others are driven to
//   cancel         ends them as cancelled, by itself
//   slow SECONDS   takes that long to answer
//   deaf           does not answer requests any more
//   mute           drives on without feedback
//   lost           drives, but says no more where the robot is
//
// It ends with its input, and prints what it was asked for.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>
#include <functional>
#include <iostream>
#include <mutex>
#include <optional>
#include <queue>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "node.hpp"
#include "robotPubSubTypes.h"
#include "threewe/export/export.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/scene/scene.hpp"

using namespace threewe;
using Clock = std::chrono::steady_clock;

namespace {

namespace geometry = geometry_msgs::msg::dds_;
namespace nav2 = nav2_msgs::action::dds_;
using eprosima::fastrtps::rtps::SampleIdentity;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Ok = eprosima::fastrtps::types::ReturnCode_t;
using Id = std::array<std::uint8_t, 16>;

constexpr auto kPeriod = std::chrono::milliseconds(20);
constexpr double kSpeed = 0.35;      // [m/s]
constexpr double kTurning = 0.9;     // [rad/s]
constexpr double kTolerance = 0.25;  // [m] and [rad], as Nav2's by default
constexpr double kLookahead = 0.35;  // [m]

// What Jazzy's nodes state, as PyPI's rosbags computes it.
constexpr const char* kPoseHash = "RIHS01_c59f178c377de5318919c00bdbf7884cb3b185acfdffceba6c9f161e0aa3cc81";
constexpr const char* kWaypointsHash = "RIHS01_7ab1988a42cff9cf0effe22d523680ba5c9053d6c52bfeafd06df5ddd3e68604";
constexpr const char* kPathHash = "RIHS01_b5ec36b035c915310afffc3cb4941ce7c8ba34221c00ebfd8db911af5e381bde";

std::atomic<bool> g_ended = false;

struct Options {
  unsigned domain = 0;
  std::string scene = "office_v2";
  std::string profile = "3we_standard_v2";
  bool humble = false;
  bool amcl = false;
  bool cyclone = false;
};

// Who asked, where that is part of a request and of its reply.
struct Header {
  std::array<unsigned char, 16> bytes{};
};
template <typename T>
struct Headed {
  Header header;
  T message;
};

/// A type that begins with such a header, where it is asked for; the rest is aligned as if it were not there.
template <typename Support, bool with_header>
class ServiceSupport : public Support {
 public:
  using Message = Headed<typename Support::type>;
  ServiceSupport() { this->m_typeSize += sizeof(Header); }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    auto& headed = *static_cast<Message*>(data);
    if (!Support::serialize(&headed.message, payload)) return false;
    if (!with_header) return true;
    std::memmove(payload->data + 20, payload->data + 4, payload->length - 4);
    std::memcpy(payload->data + 4, headed.header.bytes.data(), 16);
    payload->length += 16;
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    auto& headed = *static_cast<Message*>(data);
    if (!with_header) return Support::deserialize(payload, &headed.message);
    std::memcpy(headed.header.bytes.data(), payload->data + 4, 16);
    SerializedPayload_t rest(payload->length - 16);
    rest.encapsulation = payload->encapsulation;
    rest.length = payload->length - 16;
    std::memcpy(rest.data, payload->data, 4);
    std::memcpy(rest.data + 4, payload->data + 20, payload->length - 20);
    return Support::deserialize(&rest, &headed.message);
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    const auto size = Support::getSerializedSizeProvider(&static_cast<Message*>(data)->message);
    return [size] { return size() + 16; };
  }
  void* createData() override { return new Message(); }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
};

/// A request that has not been answered, and how to.
struct Asker {
  SampleIdentity identity;
  Header header;
};

/// One service. Requests are handed over in Fast DDS's threads.
template <typename Request, typename Reply, bool with_header>
class Service : public fast::DataReaderListener {
 public:
  using RequestSupport = ServiceSupport<Request, with_header>;
  using ReplySupport = ServiceSupport<Reply, with_header>;
  using Handler = std::function<void(const Asker&, const typename Request::type&)>;
  Service(Node& node, const std::string& name, const std::string& type, const std::string& hash, Handler handler)
      : handler_(std::move(handler)) {
    const std::string data = (with_header ? std::string("serviceid=1.2.3;") : "") +
                             (hash.empty() ? std::string() : "typehash=" + hash + ";");
    writer_ = node.offer<ReplySupport>("rr/" + name + "Reply", type + "_Response_", false, data);
    node.take<RequestSupport>("rq/" + name + "Request", type + "_Request_", *this, data);
  }
  void on_data_available(fast::DataReader* reader) override {
    typename RequestSupport::Message request;
    fast::SampleInfo info;
    while (reader->take_next_sample(&request, &info) == Ok::RETCODE_OK) {
      if (!info.valid_data) continue;
      // as rmw_fastrtps: by the reader of the replies where the client names it, else by the writer of the request
      SampleIdentity identity = info.sample_identity;
      if (info.related_sample_identity.writer_guid() != eprosima::fastrtps::rtps::GUID_t::unknown()) {
        identity.writer_guid() = info.related_sample_identity.writer_guid();
      }
      handler_({identity, request.header}, request.message);
    }
  }
  void reply(const Asker& asker, const typename Reply::type& message) {
    typename ReplySupport::Message reply{asker.header, message};
    eprosima::fastrtps::rtps::WriteParams params;
    if (!with_header) params.related_sample_identity(asker.identity);
    writer_->write(&reply, params);
  }

 private:
  Handler handler_;
  fast::DataWriter* writer_;
};

/// Hands over what arrives on a topic.
template <typename Support>
class Listener : public fast::DataReaderListener {
 public:
  explicit Listener(std::function<void(const typename Support::type&)> handler) : handler_(std::move(handler)) {}
  void on_data_available(fast::DataReader* reader) override {
    typename Support::type message;
    fast::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == Ok::RETCODE_OK) {
      if (info.valid_data) handler_(message);
    }
  }

 private:
  std::function<void(const typename Support::type&)> handler_;
};

void fill(geometry::Pose_& to, const Pose2D& pose) {
  to.position().x(pose.x);
  to.position().y(pose.y);
  to.orientation().z(std::sin(0.5 * pose.theta));
  to.orientation().w(std::cos(0.5 * pose.theta));
}

Pose2D pose_of(const geometry::Pose_& pose) {
  return {pose.position().x(), pose.position().y(), 2.0 * std::atan2(pose.orientation().z(), pose.orientation().w())};
}

/// Breadth-first search over the cells that the robot's middle may be in.
class Planner {
 public:
  Planner(map::OccupancyGrid grid, double radius) : grid_(std::move(grid)), closed_(grid_.data.size()) {
    const int reach = static_cast<int>(radius / grid_.resolution) + 1;
    for (int y = 0; y < grid_.height; ++y) {
      for (int x = 0; x < grid_.width; ++x) {
        if (grid_.at({x, y}) < map::OccupancyGrid::kOccupiedThreshold) continue;
        for (int dy = -reach; dy <= reach; ++dy) {
          for (int dx = -reach; dx <= reach; ++dx) {
            const map::Cell cell{x + dx, y + dy};
            if (dx * dx + dy * dy <= reach * reach && grid_.contains(cell)) closed_[grid_.index(cell)] = true;
          }
        }
      }
    }
  }
  std::vector<Vec2> plan(Vec2 from, Vec2 to) const {
    const map::Cell start = grid_.cell(from);
    const map::Cell goal = grid_.cell(to);
    if (!grid_.contains(start) || !grid_.contains(goal)) return {};
    std::vector<int> parent(grid_.data.size(), -1);
    std::queue<map::Cell> open;
    open.push(goal);  // backwards, so that parents lead to the goal
    parent[grid_.index(goal)] = static_cast<int>(grid_.index(goal));
    while (!open.empty() && parent[grid_.index(start)] < 0) {
      const map::Cell cell = open.front();
      open.pop();
      for (int k = 0; k < 8; ++k) {
        constexpr std::array<int, 8> kX{1, -1, 0, 0, 1, 1, -1, -1};
        constexpr std::array<int, 8> kY{0, 0, 1, -1, 1, -1, 1, -1};
        const map::Cell next{cell.x + kX[static_cast<std::size_t>(k)], cell.y + kY[static_cast<std::size_t>(k)]};
        if (!grid_.contains(next) || parent[grid_.index(next)] >= 0) continue;
        if (closed_[grid_.index(next)] && !(next == start)) continue;
        parent[grid_.index(next)] = static_cast<int>(grid_.index(cell));
        open.push(next);
      }
    }
    if (parent[grid_.index(start)] < 0) return {};
    std::vector<Vec2> path{from};
    for (std::size_t at = grid_.index(start); at != grid_.index(goal);) {
      at = static_cast<std::size_t>(parent[at]);
      const auto width = static_cast<std::size_t>(grid_.width);
      path.push_back(grid_.center({static_cast<int>(at % width), static_cast<int>(at / width)}));
    }
    path.back() = to;
    return path;
  }
  const map::OccupancyGrid& grid() const { return grid_; }

 private:
  map::OccupancyGrid grid_;
  std::vector<bool> closed_;
};

double length_of(const std::vector<Vec2>& path, std::size_t from) {
  double length = 0.0;
  for (std::size_t i = from + 1; i < path.size(); ++i) length += distance(path[i - 1], path[i]);
  return length;
}

/// How goals are treated.
struct Mode {
  std::string name = "normal";
  double value = 0.0;
};

enum class Action { to_pose, along_path, to_waypoints };

/// A goal, of any action.
struct Goal {
  Id id{};
  Action action = Action::to_pose;
  std::vector<Pose2D> waypoints;
  std::size_t waypoint = 0;                         // to which it drives
  std::vector<std::pair<std::size_t, int>> missed;  // waypoints, and why
  std::vector<Vec2> path;
  double theta = 0.0;
  std::size_t passed = 0;  // of the path's points
  Clock::time_point began{};
  int status = 2;
  int code = 0;
  std::string message;
  std::optional<Asker> asks;  // for the result
};

template <bool humble, bool with_header>
class Nav2 {
  using PoseGoal = nav2::NavigateToPose_SendGoal_Request_PubSubType;
  using PathGoal = std::conditional_t<humble, nav2::Humble_FollowPath_SendGoal_Request_PubSubType,
                                      nav2::FollowPath_SendGoal_Request_PubSubType>;
  using WaypointsGoal = std::conditional_t<humble, nav2::Humble_FollowWaypoints_SendGoal_Request_PubSubType,
                                           nav2::FollowWaypoints_SendGoal_Request_PubSubType>;
  using WaypointsResult = std::conditional_t<humble, nav2::Humble_FollowWaypoints_GetResult_Response_PubSubType,
                                             nav2::FollowWaypoints_GetResult_Response_PubSubType>;
  using PoseResult = std::conditional_t<humble, nav2::Humble_GetResult_Response_PubSubType,
                                        nav2::NavigateToPose_GetResult_Response_PubSubType>;
  using PathResult = std::conditional_t<humble, nav2::Humble_GetResult_Response_PubSubType,
                                        nav2::FollowPath_GetResult_Response_PubSubType>;
  using Answer = nav2::SendGoal_Response_PubSubType;
  using Asked = nav2::GetResult_Request_PubSubType;
  using CancelRequest = action_msgs::srv::dds_::CancelGoal_Request_PubSubType;
  using CancelResponse = action_msgs::srv::dds_::CancelGoal_Response_PubSubType;
  using StatusType = action_msgs::msg::dds_::GoalStatusArray_PubSubType;
  using Transforms = tf2_msgs::msg::dds_::TFMessage_PubSubType;
  using Estimate = geometry::PoseWithCovarianceStamped_PubSubType;
  template <typename Request, typename Reply>
  using ServiceOf = Service<Request, Reply, with_header>;

 public:
  explicit Nav2(const Options& options)
      : options_(options),
        node_(options.domain),
        planner_(exports::map_of(scene::Scene::load(options.scene), load_profile(options.profile)),
                 load_profile(options.profile).body.footprint.circumscribed_radius()),
        truth_([this](const tf2_msgs::msg::dds_::TFMessage_& message) { note(message); }),
        initial_([](const geometry::PoseWithCovarianceStamped_& message) {
          const Pose2D pose = pose_of(message.pose().pose());
          std::printf("%.3f %.3f %.3f\n", pose.x, pose.y, pose.theta);
          std::fflush(stdout);
        }) {
    const std::string type = "nav2_msgs::action::dds_::";
    const std::string to_pose = "navigate_to_pose/_action/";
    const std::string along = "follow_path/_action/";
    const std::string visit = "follow_waypoints/_action/";
    const std::string visit_type = type + "FollowWaypoints_";
    const std::string pose_type = type + "NavigateToPose_";
    const std::string path_type = type + "FollowPath_";
    const auto hash = [](const char* text) { return humble ? std::string() : std::string(text); };
    send_pose_.emplace(node_, to_pose + "send_goal", pose_type + "SendGoal", "", [this](auto& asker, auto& request) {
      push([this, asker, request] { take_pose(asker, request); });
    });
    send_path_.emplace(node_, along + "send_goal", path_type + "SendGoal", "", [this](auto& asker, auto& request) {
      push([this, asker, request] { take_path(asker, request); });
    });
    result_pose_.emplace(node_, to_pose + "get_result", pose_type + "GetResult", hash(kPoseHash),
                         [this](auto& asker, auto& request) { push([this, asker, request] { ask(asker, request); }); });
    result_path_.emplace(node_, along + "get_result", path_type + "GetResult", hash(kPathHash),
                         [this](auto& asker, auto& request) { push([this, asker, request] { ask(asker, request); }); });
    send_visit_.emplace(node_, visit + "send_goal", visit_type + "SendGoal", "", [this](auto& asker, auto& request) {
      push([this, asker, request] { take_waypoints(asker, request); });
    });
    result_visit_.emplace(
        node_, visit + "get_result", visit_type + "GetResult", hash(kWaypointsHash),
        [this](auto& asker, auto& request) { push([this, asker, request] { ask(asker, request); }); });
    const std::string cancel_type = "action_msgs::srv::dds_::CancelGoal";
    cancel_pose_.emplace(node_, to_pose + "cancel_goal", cancel_type, "", [this](auto& asker, auto& request) {
      push([this, asker, request] { cancel(*cancel_pose_, asker, request); });
    });
    cancel_path_.emplace(node_, along + "cancel_goal", cancel_type, "", [this](auto& asker, auto& request) {
      push([this, asker, request] { cancel(*cancel_path_, asker, request); });
    });
    cancel_visit_.emplace(node_, visit + "cancel_goal", cancel_type, "", [this](auto& asker, auto& request) {
      push([this, asker, request] { cancel(*cancel_visit_, asker, request); });
    });
    status_visit_ = node_.offer<StatusType>("rt/" + visit + "status", kStatusName, true);
    feedback_visit_ = node_.offer<nav2::FollowWaypoints_FeedbackMessage_PubSubType>(
        "rt/" + visit + "feedback", visit_type + "FeedbackMessage_", false);
    status_pose_ = node_.offer<StatusType>("rt/" + to_pose + "status", kStatusName, true);
    status_path_ = node_.offer<StatusType>("rt/" + along + "status", kStatusName, true);
    feedback_pose_ = node_.offer<nav2::NavigateToPose_FeedbackMessage_PubSubType>(
        "rt/" + to_pose + "feedback", pose_type + "FeedbackMessage_", false);
    feedback_path_ = node_.offer<nav2::FollowPath_FeedbackMessage_PubSubType>("rt/" + along + "feedback",
                                                                              path_type + "FeedbackMessage_", false);
    plan_ = node_.offer<nav_msgs::msg::dds_::Path_PubSubType>("rt/plan", "nav_msgs::msg::dds_::Path_", false);
    map_ = node_.offer<nav_msgs::msg::dds_::OccupancyGrid_PubSubType>("rt/map", "nav_msgs::msg::dds_::OccupancyGrid_",
                                                                      true);
    transforms_ = node_.offer<Transforms>("rt/tf", "tf2_msgs::msg::dds_::TFMessage_", false);
    estimate_ = node_.offer<Estimate>(options.amcl ? "rt/amcl_pose" : "rt/pose", kEstimateName, options.amcl);
    commands_ = node_.advertise<geometry::Twist_PubSubType>("/cmd_vel", "geometry_msgs::msg::dds_::Twist_", true);
    node_.take<Transforms>("rt/ground_truth", "tf2_msgs::msg::dds_::TFMessage_", truth_);
    if (options.amcl) node_.take<Estimate>("rt/initialpose", kEstimateName, initial_);
    send_map();
  }

  void set(Mode mode) {
    push([this, mode] { mode_ = mode; });
  }

  void run() {
    for (int tick = 0; !g_ended; ++tick) {
      std::this_thread::sleep_for(kPeriod);
      if (tick % 2 == 0 && mode_.name != "lost") say_where(tick);
      for (auto next = pop(); next; next = pop()) next();
      if (goal_ && goal_->status == 2) drive();
    }
  }
  std::string json() const {
    return fmt::format(R"({{"goals": {}, "cancelled": {}, "twists": {}}})", goals_, cancelled_, twists_);
  }

 private:
  static constexpr const char* kStatusName = "action_msgs::msg::dds_::GoalStatusArray_";
  static constexpr const char* kEstimateName = "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_";

  // What is to be done in the one thread that does anything.
  void push(std::function<void()> task) {
    const std::scoped_lock lock(mutex_);
    tasks_.push_back({Clock::now(), std::move(task)});
  }
  std::function<void()> pop() {
    const std::scoped_lock lock(mutex_);
    if (tasks_.empty()) return {};
    const double late = mode_.name == "slow" ? mode_.value : 0.0;
    if (Clock::now() - tasks_.front().first < std::chrono::duration<double>(late)) return {};
    auto task = std::move(tasks_.front().second);
    tasks_.pop_front();
    return task;
  }

  // Where the robot is.
  void note(const tf2_msgs::msg::dds_::TFMessage_& message) {
    const auto pose = [](const geometry::TransformStamped_& stamped) {
      const auto& t = stamped.transform();
      return Pose2D{t.translation().x(), t.translation().y(), 2.0 * std::atan2(t.rotation().z(), t.rotation().w())};
    };
    const std::scoped_lock lock(mutex_);
    map_from_base_ = pose(message.transforms()[0]);
    map_from_odom_ = pose(message.transforms()[1]);
  }
  Pose2D here() {
    const std::scoped_lock lock(mutex_);
    return map_from_base_.value_or(Pose2D{});
  }
  void say_where(int tick) {
    const std::scoped_lock lock(mutex_);
    if (!map_from_base_) return;
    tf2_msgs::msg::dds_::TFMessage_ message;
    auto& transform = message.transforms().emplace_back();
    transform.header().frame_id("map");
    transform.child_frame_id("odom");
    transform.transform().translation().x(map_from_odom_.x);
    transform.transform().translation().y(map_from_odom_.y);
    transform.transform().rotation().z(std::sin(0.5 * map_from_odom_.theta));
    transform.transform().rotation().w(std::cos(0.5 * map_from_odom_.theta));
    transforms_->write(&message);
    if (tick % 10 != 0) return;
    geometry::PoseWithCovarianceStamped_ estimate;
    estimate.header().frame_id("map");
    fill(estimate.pose().pose(), *map_from_base_);
    estimate.pose().covariance()[0] = estimate.pose().covariance()[7] = 0.0004;
    estimate.pose().covariance()[1] = estimate.pose().covariance()[6] = 0.0001;
    estimate.pose().covariance()[35] = 0.0002;
    estimate_->write(&estimate);
  }
  void send_map() {
    const map::OccupancyGrid& grid = planner_.grid();
    nav_msgs::msg::dds_::OccupancyGrid_ message;
    message.header().frame_id("map");
    message.info().resolution(static_cast<float>(grid.resolution));
    message.info().width(static_cast<std::uint32_t>(grid.width));
    message.info().height(static_cast<std::uint32_t>(grid.height));
    fill(message.info().origin(), {grid.origin.x, grid.origin.y, 0.0});
    for (const std::int8_t value : grid.data) message.data().push_back(static_cast<std::uint8_t>(value));
    map_->write(&message);
  }

  // Goals.
  template <typename S, typename R>
  bool answer(S& service, const Asker& asker, const R& request) {
    if (mode_.name == "deaf") return false;
    typename Answer::type response;
    response.accepted(mode_.name != "reject");
    if (response.accepted()) {
      ++goals_;
      if (goal_ && goal_->status == 2) finish(6, 0, "preempted");
      goal_.emplace();
      goal_->id = request.goal_id().uuid();
      goal_->began = Clock::now();
    }
    service.reply(asker, response);
    return response.accepted();
  }
  void take_pose(const Asker& asker, const typename PoseGoal::type& request) {
    if (!answer(*send_pose_, asker, request)) return;
    send_status();
    if (!plan_to(pose_of(request.pose().pose()))) finish(6, 208, "no path");
  }
  void take_waypoints(const Asker& asker, const typename WaypointsGoal::type& request) {
    if (!answer(*send_visit_, asker, request)) return;
    goal_->action = Action::to_waypoints;
    for (const auto& stamped : request.poses()) goal_->waypoints.push_back(pose_of(stamped.pose()));
    send_status();
    if (goal_->waypoints.empty()) return finish(6, 602, "no waypoints");
    begin_waypoint();
  }
  /// As Nav2 does by default: the first that is missed ends the goal, which itself states no error.
  void begin_waypoint() {
    if (goal_->waypoint == goal_->waypoints.size()) return finish(4, 0, "");
    if (!plan_to(goal_->waypoints[goal_->waypoint])) miss(208);
  }
  void miss(int code) {
    goal_->missed.emplace_back(goal_->waypoint, code);
    finish(6, 0, "");
  }
  bool plan_to(const Pose2D& goal) {
    goal_->theta = goal.theta;
    goal_->passed = 0;
    goal_->path = planner_.plan(here().position(), goal.position());
    if (goal_->path.empty()) return false;
    nav_msgs::msg::dds_::Path_ plan;
    plan.header().frame_id("map");
    for (const Vec2 point : goal_->path) fill(plan.poses().emplace_back().pose(), {point.x, point.y, 0.0});
    plan_->write(&plan);
    return true;
  }
  void take_path(const Asker& asker, const typename PathGoal::type& request) {
    if (!answer(*send_path_, asker, request)) return;
    goal_->action = Action::along_path;
    for (const auto& stamped : request.path().poses()) goal_->path.push_back(pose_of(stamped.pose()).position());
    send_status();
    if (goal_->path.empty()) return finish(6, 103, "empty path");
    goal_->theta = pose_of(request.path().poses().back().pose()).theta;
  }
  void ask(const Asker& asker, const typename Asked::type& request) {
    if (mode_.name == "deaf") return;
    if (goal_ && goal_->id == request.goal_id().uuid()) {
      goal_->asks = asker;
      if (goal_->status != 2) send_result();
    }
  }
  template <typename S>
  void cancel(S& service, const Asker& asker, const typename CancelRequest::type& request) {
    if (mode_.name == "deaf") return;
    typename CancelResponse::type response;
    if (goal_ && goal_->status == 2 && goal_->id == request.goal_info().goal_id().uuid()) {
      ++cancelled_;
      response.goals_canceling().push_back(request.goal_info());
      service.reply(asker, response);
      return finish(5, 0, "");
    }
    response.return_code(2);  // it does not know the goal
    service.reply(asker, response);
  }
  void finish(int status, int code, const std::string& message) {
    goal_->status = status;
    goal_->code = code;
    goal_->message = message;
    send_velocity(0.0, 0.0);
    send_status();
    send_result();
  }
  void send_status() {
    typename StatusType::type status;
    auto& goal = status.status_list().emplace_back();
    goal.goal_info().goal_id().uuid(goal_->id);
    goal.status(static_cast<std::uint8_t>(goal_->status));
    (goal_->action == Action::to_pose      ? status_pose_
     : goal_->action == Action::along_path ? status_path_
                                           : status_visit_)
        ->write(&status);
  }
  void send_result() {
    if (!goal_->asks || mode_.name == "deaf") return;
    const auto with_error = [&](auto response) {
      response.status(static_cast<std::uint8_t>(goal_->status));
      if constexpr (!humble) {
        response.error_code(static_cast<std::uint16_t>(goal_->code));
        response.error_msg(goal_->message);
      }
      return response;
    };
    if (goal_->action == Action::to_waypoints) {
      auto response = with_error(typename WaypointsResult::type());
      for (const auto& [index, code] : goal_->missed) {
        if constexpr (humble) {
          response.missed_waypoints().push_back(static_cast<std::int32_t>(index));
        } else {
          auto& missed = response.missed_waypoints().emplace_back();
          missed.index(static_cast<std::uint32_t>(index));
          missed.error_code(static_cast<std::uint16_t>(code));
        }
      }
      result_visit_->reply(*goal_->asks, response);
    } else if (goal_->action == Action::along_path) {
      result_path_->reply(*goal_->asks, with_error(typename PathResult::type()));
    } else {
      result_pose_->reply(*goal_->asks, with_error(typename PoseResult::type()));
    }
    goal_->asks.reset();
  }
  void send_velocity(double vx, double omega) {
    geometry::Twist_ twist;
    twist.linear().x(vx);
    twist.angular().z(omega);
    commands_->write(&twist);
    ++twists_;
  }
  void send_feedback(double left) {
    if (mode_.name == "mute" || mode_.name == "deaf") return;
    if (goal_->action == Action::to_waypoints) {
      nav2::FollowWaypoints_FeedbackMessage_ message;
      message.goal_id().uuid(goal_->id);
      message.current_waypoint(static_cast<std::uint32_t>(goal_->waypoint));
      feedback_visit_->write(&message);
    } else if (goal_->action == Action::along_path) {
      nav2::FollowPath_FeedbackMessage_ message;
      message.goal_id().uuid(goal_->id);
      message.distance_to_goal(static_cast<float>(left));
      message.speed(static_cast<float>(kSpeed));
      feedback_path_->write(&message);
    } else {
      nav2::NavigateToPose_FeedbackMessage_ message;
      message.goal_id().uuid(goal_->id);
      message.distance_remaining(static_cast<float>(left));
      message.estimated_time_remaining().sec(static_cast<std::int32_t>(left / kSpeed));
      fill(message.current_pose().pose(), here());
      feedback_pose_->write(&message);
    }
  }

  /// Pure pursuit: turns towards a point ahead on the path, and drives as far as it looks there.
  void drive() {
    const auto since = std::chrono::duration<double>(Clock::now() - goal_->began).count();
    const int code = static_cast<int>(mode_.value);
    const bool visits = goal_->action == Action::to_waypoints;
    if (mode_.name == "fail" && since > 0.3) return visits ? miss(code) : finish(6, code, "as it was asked to");
    if (mode_.name == "miss" && since > 0.3 && visits && goal_->waypoint == 0) {
      goal_->missed.emplace_back(goal_->waypoint++, code);
      return begin_waypoint();
    }
    if (mode_.name == "cancel" && since > 0.3) return finish(5, 0, "");
    const Pose2D pose = here();
    const std::vector<Vec2>& path = goal_->path;
    while (goal_->passed + 1 < path.size() && distance(path[goal_->passed], pose.position()) < kLookahead) {
      ++goal_->passed;
    }
    const double away = distance(path.back(), pose.position());
    send_feedback(std::max(away, length_of(path, goal_->passed)));
    const bool arrived = goal_->passed + 1 == path.size() && away < kTolerance;
    const Vec2 ahead = path[goal_->passed];
    const double turn = arrived ? wrap_angle(goal_->theta - pose.theta)
                                : wrap_angle(std::atan2(ahead.y - pose.y, ahead.x - pose.x) - pose.theta);
    if (arrived && (goal_->action == Action::along_path || std::abs(turn) < kTolerance)) {
      if (!visits) return finish(4, 0, "");
      ++goal_->waypoint;
      return begin_waypoint();
    }
    const double forward = arrived ? 0.0 : kSpeed * std::max(0.0, 1.0 - std::abs(turn));
    send_velocity(forward, std::clamp(2.0 * turn, -kTurning, kTurning));
  }

  const Options options_;
  std::mutex mutex_;
  std::deque<std::pair<Clock::time_point, std::function<void()>>> tasks_;
  std::optional<Pose2D> map_from_base_;
  Pose2D map_from_odom_;
  Mode mode_;
  std::optional<Goal> goal_;
  int goals_ = 0, cancelled_ = 0, twists_ = 0;
  Node node_;
  Planner planner_;
  Listener<Transforms> truth_;
  Listener<Estimate> initial_;
  std::optional<ServiceOf<PoseGoal, Answer>> send_pose_;
  std::optional<ServiceOf<PathGoal, Answer>> send_path_;
  std::optional<ServiceOf<WaypointsGoal, Answer>> send_visit_;
  std::optional<ServiceOf<Asked, WaypointsResult>> result_visit_;
  std::optional<ServiceOf<Asked, PoseResult>> result_pose_;
  std::optional<ServiceOf<Asked, PathResult>> result_path_;
  std::optional<ServiceOf<CancelRequest, CancelResponse>> cancel_pose_, cancel_path_, cancel_visit_;
  fast::DataWriter *status_pose_, *status_path_, *status_visit_, *feedback_pose_, *feedback_path_, *feedback_visit_,
      *plan_, *map_, *transforms_, *estimate_, *commands_;
};

template <bool humble, bool with_header>
void run(const Options& options) {
  Nav2<humble, with_header> nav2(options);
  std::puts("ready");
  std::fflush(stdout);
  std::thread reader([&] {
    for (std::string line; std::getline(std::cin, line);) {
      Mode mode;
      std::istringstream(line) >> mode.name >> mode.value;
      nav2.set(mode);
    }
    g_ended = true;
  });
  nav2.run();
  reader.join();
  std::puts(nav2.json().c_str());
}

Options parse(int count, char** arguments) {
  Options options;
  options.domain = static_cast<unsigned>(std::stoul(arguments[1]));
  for (int i = 2; i < count; ++i) {
    const std::string_view name = arguments[i];
    if (name == "--humble") {
      options.humble = true;
    } else if (name == "--amcl") {
      options.amcl = true;
    } else if (name == "--cyclone") {
      options.cyclone = true;
    } else if (++i == count) {
      throw std::runtime_error("a value is missing");
    } else if (name == "--scene") {
      options.scene = arguments[i];
    } else if (name == "--profile") {
      options.profile = arguments[i];
    } else {
      throw std::runtime_error("unknown option");
    }
  }
  return options;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fputs("usage: ros2_nav2 DOMAIN [--scene NAME] [--profile NAME] [--humble] [--amcl] [--cyclone]\n", stderr);
    return 2;
  }
  try {
    const Options options = parse(count, arguments);
    if (options.humble) {
      options.cyclone ? run<true, true>(options) : run<true, false>(options);
    } else {
      options.cyclone ? run<false, true>(options) : run<false, false>(options);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_nav2: %s\n", error.what());
    return 1;
  }
  return 0;
}
