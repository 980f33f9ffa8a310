#include "backend/mujoco/world/compile.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "sim/people.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

[[noreturn]] void refuse(const char* what) { throw ConfigError(fmt::format("MuJoCo refuses the model: {}", what)); }

// They would look in each of MuJoCo's steps.
void delete_rangefinders(const Library& mj, mjSpec* spec) {
  std::vector<mjsElement*> rangefinders;
  for (mjsElement* sensor = mj.mjs_firstElement(spec, mjOBJ_SENSOR); sensor != nullptr;
       sensor = mj.mjs_nextElement(spec, sensor)) {
    if (mj.mjs_asSensor(sensor)->type == mjSENS_RANGEFINDER) rangefinders.push_back(sensor);
  }
  for (mjsElement* rangefinder : rangefinders) mj.mjs_delete(spec, rangefinder);
}

void reach(mjsGeom& cylinder, double radius, double from, double to) {
  cylinder.pos[2] = 0.5 * (from + to);
  cylinder.size[0] = radius;
  cylinder.size[1] = 0.5 * (to - from);
}

// An exported person is a cylinder; robots meet two legs below its knees.
void add_legs(const Library& mj, mjSpec* spec, const scene::Person& person) {
  const PersonBodies names = bodies_of(person);
  mjsGeom* trunk = mj.mjs_asGeom(mj.mjs_findElement(spec, mjOBJ_GEOM, names.trunk.c_str()));
  for (const std::string& name : names.legs) {
    mjsBody* leg = mj.mjs_addBody(mj.mjs_findBody(spec, "world"), nullptr);
    mj.mjs_setName(leg->element, name.c_str());
    leg->mocap = true;
    mjsGeom* geom = mj.mjs_addGeom(leg, nullptr);
    mj.mjs_setName(geom->element, name.c_str());
    geom->type = trunk->type;
    geom->contype = trunk->contype;
    geom->conaffinity = trunk->conaffinity;
    geom->group = trunk->group;
    std::copy_n(trunk->friction, 3, geom->friction);
    std::copy_n(trunk->solref, mjNREF, geom->solref);
    std::copy_n(trunk->rgba, 4, geom->rgba);
    reach(*geom, person.radius / 0.25 * sim::kLegRadius, 0.0, sim::kKneeHeight);
  }
  reach(*trunk, person.radius, sim::kKneeHeight, sim::kPersonHeight);
}

}  // namespace

PersonBodies bodies_of(const scene::Person& person) {
  const std::string trunk = "person/" + person.name;
  return {trunk, {trunk + "/left_leg", trunk + "/right_leg"}};
}

mjModel* compile(const Library& mj, const std::string& mjcf, std::span<const scene::Person> people) {
  std::array<char, 1000> error{};
  const auto discard = [&mj](mjSpec* read) { mj.mj_deleteSpec(read); };
  const std::unique_ptr<mjSpec, decltype(discard)> spec(
      mj.mj_parseXMLString(mjcf.c_str(), nullptr, error.data(), error.size()), discard);
  if (!spec) refuse(error.data());
  delete_rangefinders(mj, spec.get());
  for (const scene::Person& person : people) add_legs(mj, spec.get(), person);
  mjModel* model = mj.mj_compile(spec.get(), nullptr);
  if (model == nullptr) refuse(mj.mjs_getError(spec.get()));
  // the user gets an error for what has come apart; it is not silently put back to the start
  model->opt.disableflags |= mjDSBL_AUTORESET;
  return model;
}

}  // namespace threewe::backend::mujoco
