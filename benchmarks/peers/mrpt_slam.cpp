// MRPT: ICP-SLAM, and a particle filter of ten maps, on a recorded log (needs Debian's libmrpt-slam-dev). Settings are
// those that MRPT ships for its programs of these names, in share/mrpt/config_files of its sources: icp-slam's
// icp-slam_demo_classic.ini, and rbpf-slam's gridmapping_RBPF_ICPbased_intel.ini, made for a SICK of 180 degrees.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/random.h>
#include <mrpt/slam/CMetricMapBuilderICP.h>
#include <mrpt/slam/CMetricMapBuilderRBPF.h>
#include <mrpt/version.h>

#include <deque>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "world.hpp"

namespace {

using mrpt::poses::CPose2D;

struct Entry {
  double time = 0.0;
  CPose2D odometry;
  std::vector<float> ranges;  // from the right to the left
};

struct Log {
  std::string name;
  double aperture = 0.0, range_max = 0.0;
  CPose2D base_from_lidar;
  std::vector<Entry> entries;
};

Log read_log(const char* path) {
  Log log;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word;
    double x = 0.0;
    double y = 0.0;
    double theta = 0.0;
    words >> word;
    if (word == "log") {
      words >> log.name >> log.aperture >> log.range_max >> x >> y >> theta;
      log.base_from_lidar = {x, y, theta};
    } else if (word == "scan") {
      Entry& entry = log.entries.emplace_back();
      words >> entry.time >> x >> y >> theta;
      entry.odometry = {x, y, theta};
      for (float range; words >> range;) entry.ranges.push_back(range);
    }
  }
  return log;
}

auto at(double time) { return mrpt::Clock::fromDouble(1e6 + time); }

mrpt::obs::CObservation2DRangeScan::Ptr seen(const Log& log, const Entry& entry) {
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  scan->sensorLabel = "lidar";
  scan->timestamp = at(entry.time);
  scan->aperture = static_cast<float>(log.aperture);
  scan->maxRange = static_cast<float>(log.range_max);
  scan->sensorPose = mrpt::poses::CPose3D(log.base_from_lidar);
  scan->resizeScan(entry.ranges.size());
  for (std::size_t i = 0; i < entry.ranges.size(); ++i) {
    scan->setScanRange(i, entry.ranges[i]);
    scan->setScanRangeValidity(i, entry.ranges[i] > 0.0F && entry.ranges[i] < scan->maxRange);
  }
  return scan;
}

void add(mrpt::slam::CMetricMapBuilderICP& builder, const Log& log, const Entry& entry, const CPose2D&) {
  auto odometry = mrpt::obs::CObservationOdometry::Create();
  odometry->sensorLabel = "odometry";
  odometry->timestamp = at(entry.time);
  odometry->odometry = entry.odometry;
  builder.processObservation(odometry);
  builder.processObservation(seen(log, entry));
}

void add(mrpt::slam::CMetricMapBuilderRBPF& builder, const Log& log, const Entry& entry, const CPose2D& moved) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.timestamp = at(entry.time);
  movement.computeFromOdometry(moved, {});
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  mrpt::obs::CSensoryFrame frame;
  frame.insert(seen(log, entry));
  builder.processActionObservation(actions, frame);
}

// Where the best of the particles was at each scan, as it has it in the end.
std::vector<CPose2D> likeliest_path(const mrpt::slam::CMetricMapBuilderRBPF& builder) {
  std::deque<mrpt::math::TPose3D> path;
  builder.getCurrentMostLikelyPath(path);
  path.pop_front();  // where it was before the first
  std::vector<CPose2D> poses;
  for (const mrpt::math::TPose3D& pose : path) poses.emplace_back(pose.x, pose.y, pose.yaw);
  return poses;
}

// Maps the whole log and prints the CPU time, and where the robot was at each scan.
template <class Builder>
void report(const Log& log, const std::string& name, const std::string& differs, Builder& builder) {
  std::vector<CPose2D> poses;
  const double begin = peers::cpu_seconds();
  CPose2D before = log.entries.front().odometry;
  for (const Entry& entry : log.entries) {
    add(builder, log, entry, entry.odometry - before);
    poses.emplace_back(builder.getCurrentPoseEstimation()->getMeanVal());
    before = entry.odometry;
  }
  if constexpr (std::is_same_v<Builder, mrpt::slam::CMetricMapBuilderRBPF>) poses = likeliest_path(builder);
  const double seconds = peers::cpu_seconds() - begin;
  if (poses.size() != log.entries.size()) throw std::length_error(name + " has not a pose for each scan");
  std::printf("{\"kind\": \"slam\", \"who\": \"MRPT %u.%u.%u, %s\", \"differs\": \"%s\", ", MRPT_VERSION >> 8 & 0xF,
              MRPT_VERSION >> 4 & 0xF, MRPT_VERSION & 0xF, name.c_str(), differs.c_str());
  std::printf("\"size\": \"%s\", \"seconds\": [%.6g], \"poses\": [", log.name.c_str(), seconds);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::printf("%s[%.6f, %.6f, %.6f, %.8f]", i ? ", " : "", log.entries[i].time, poses[i].x(), poses[i].y(),
                poses[i].phi());
  }
  std::printf("]}\n");
  std::fflush(stdout);
}

constexpr const char* kPointsMap = R"(
pointsMap_count = 1
likelihoodMapSelection = -1
[MappingApplication_pointsMap_00_insertOpts]
minDistBetweenLaserPoints = 0.05
fuseWithExisting = false
isPlanarMap = 1
[MappingApplication_pointsMap_00_likelihoodOpts]
max_corr_distance = 5.0
sigma_dist = 0.05
)";

void report_icp(const Log& log, int decimation, const std::string& differs) {
  const mrpt::config::CConfigFileMemory settings(R"(
[ICP]
ICP_algorithm = icpClassic
maxIterations = 80
minAbsStep_trans = 1e-6
minAbsStep_rot = 1e-6
thresholdDist = 0.3
thresholdAng_DEG = 5
ALFA = 0.8
smallestThresholdDist = 0.05
onlyUniqueRobust = true
corresponding_points_decimation = )" + std::to_string(decimation) +
                                                 R"(
[MappingApplication]
localizationLinDistance = 0.2
localizationAngDistance = 5
insertionLinDistance = 1.2
insertionAngDistance = 45.0
minICPgoodnessToAccept = 0.40
matchAgainstTheGrid = 0
)" + kPointsMap);
  mrpt::slam::CMetricMapBuilderICP builder;
  builder.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  builder.ICP_params.loadFromConfigFile(settings, "ICP");
  builder.ICP_options.loadFromConfigFile(settings, "MappingApplication");
  builder.initialize();
  report(log, decimation == 1 ? "ICP-SLAM, all points" : "ICP-SLAM", differs, builder);
}

void report_rbpf(const Log& log) {
  const mrpt::config::CConfigFileMemory settings(std::string(R"(
[MappingApplication]
insertionLinDistance = 2.0
insertionAngDistance_deg = 30.0
localizeLinDistance = 0.20
localizeAngDistance_deg = 10.0
PF_algorithm = 2
adaptiveSampleSize = 0
resamplingMethod = 0
sampleSize = 10
BETA = 0.50
pfAuxFilterOptimal_MaximumSearchSamples = 250
pfOptimalProposal_mapSelection = 3
ICPGlobalAlign_MinQuality = 0.80
ICP_algorithm = 1
maxIterations = 60
thresholdDist = 1.00
thresholdAng_DEG = 5
ALFA = 0.50
smallestThresholdDist = 0.10
)") + kPointsMap);
  mrpt::slam::CMetricMapBuilderRBPF::TConstructionOptions options;
  options.loadFromConfigFile(settings, "MappingApplication");
  options.verbosity_level = mrpt::system::LVL_ERROR;
  mrpt::random::getRandomGenerator().randomize(1);
  mrpt::slam::CMetricMapBuilderRBPF builder(options);
  report(log, "RBPF-SLAM", "ten particles, each with a map of points; ICP; C++", builder);
}

}  // namespace

// Logs, of which the first is mapped by the particle filter too, for that takes long.
int main(int count, char** paths) {
  for (int i = 1; i < count; ++i) {
    const Log log = read_log(paths[i]);
    report_icp(log, 5, "one map of points, every fifth point matched; closes no loops; C++");
    report_icp(log, 1, "the same, every point matched; C++");
    if (i == 1) report_rbpf(log);
  }
}
