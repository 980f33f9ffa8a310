#include "backend/mock/mock_truth.hpp"

#include "threewe/core/errors.hpp"

namespace threewe::backend::mock {

Pose2D MockTruth::sample_free_pose(std::uint64_t) const { throw ContractError("sample_free_pose: not there yet"); }

double MockTruth::geodesic(Vec2, Vec2) const { throw ContractError("geodesic: not there yet"); }

}  // namespace threewe::backend::mock
