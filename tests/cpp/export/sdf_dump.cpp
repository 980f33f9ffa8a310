// Loads SDF as strictly as libsdformat can and prints what it found: sdf_dump FILE MODELS_FOLDER
#include <iostream>
#include <string>

#include <sdf/sdf.hh>

namespace {

void print(const ignition::math::Pose3d& pose) {
  std::cout << ' ' << pose.Pos() << ' ' << pose.Rot().Roll() << ' ' << pose.Rot().Pitch() << ' ' << pose.Rot().Yaw();
}

void print(const sdf::Geometry& geometry) {
  if (const sdf::Box* box = geometry.BoxShape()) std::cout << " box " << box->Size();
  if (const sdf::Cylinder* cylinder = geometry.CylinderShape()) {
    std::cout << " cylinder " << cylinder->Radius() << ' ' << cylinder->Radius() << ' ' << cylinder->Length();
  }
  if (const sdf::Sphere* sphere = geometry.SphereShape()) std::cout << " sphere " << sphere->Radius() << " 0 0";
  if (const sdf::Ellipsoid* ellipsoid = geometry.EllipsoidShape()) std::cout << " ellipsoid " << ellipsoid->Radii();
}

void print(const sdf::Model& model) {
  for (uint64_t i = 0; i < model.LinkCount(); ++i) {
    const sdf::Link& link = *model.LinkByIndex(i);
    std::cout << "link " << model.Name() << ' ' << link.Name() << ' ' << link.Inertial().MassMatrix().Mass() << ' '
              << link.Inertial().MassMatrix().DiagonalMoments();
    print(link.Inertial().Pose());
    print(link.RawPose());
    std::cout << '\n';
    for (uint64_t k = 0; k < link.CollisionCount(); ++k) {
      const sdf::Collision& collision = *link.CollisionByIndex(k);
      std::cout << "collision " << model.Name() << ' ' << collision.Name();
      print(*collision.Geom());
      print(collision.RawPose());
      std::cout << '\n';
    }
    for (uint64_t k = 0; k < link.SensorCount(); ++k) {
      const sdf::Sensor& sensor = *link.SensorByIndex(k);
      std::cout << "sensor " << sensor.Name() << ' ' << sensor.TypeStr() << ' ' << sensor.UpdateRate();
      print(sensor.RawPose());
      std::cout << '\n';
    }
  }
  for (uint64_t i = 0; i < model.JointCount(); ++i) {
    const sdf::Joint& joint = *model.JointByIndex(i);
    std::cout << "joint " << joint.Name() << ' ' << joint.ParentLinkName() << ' ' << joint.ChildLinkName() << ' '
              << joint.Axis()->Xyz() << '\n';
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  sdf::ParserConfig config = sdf::ParserConfig::GlobalConfig();
  config.SetWarningsPolicy(sdf::EnforcementPolicy::ERR);
  config.SetUnrecognizedElementsPolicy(sdf::EnforcementPolicy::ERR);
  config.AddURIPath("model://", arguments[2]);
  std::cout.precision(17);
  sdf::Root root;
  for (const sdf::Error& error : root.Load(arguments[1], config)) std::cout << "error " << error << '\n';
  if (root.Model() != nullptr) print(*root.Model());
  for (uint64_t w = 0; w < root.WorldCount(); ++w) {
    const sdf::World& world = *root.WorldByIndex(w);
    for (uint64_t i = 0; i < world.ModelCount(); ++i) print(*world.ModelByIndex(i));
  }
  return 0;
}
