// Umbrella header: everything a program that drives a robot needs.
#pragma once

#include "threewe/core/errors.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/robot/results.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/robot/warning.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/semantics/things.hpp"
