#include "usd_text.hpp"
#include "core/exact.hpp"

#include <cctype>

namespace threewe::exports {

std::string usd_tuple(const Vec3& v) { return fmt::format("({}, {}, {})", text(v.x), text(v.y), text(v.z)); }
std::string usd_tuple(const Quaternion& q) {
  return fmt::format("({}, {}, {}, {})", text(q.w), text(q.x), text(q.y), text(q.z));
}

std::string UsdNames::of(const std::string& name) {
  std::string prim;
  for (const char c : name) prim += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (prim.empty() || std::isdigit(static_cast<unsigned char>(prim.front())) != 0) prim.insert(0, 1, '_');
  std::string unique = prim;
  for (int i = 2; !taken_.insert(unique).second; ++i) unique = fmt::format("{}_{}", prim, i);
  return unique;
}

UsdText::UsdText() {
  out_ =
      "#usda 1.0\n(\n    defaultPrim = \"World\"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1\n"
      "    upAxis = \"Z\"\n)\n";
}

void UsdText::open(const char* type, const std::string& name, const std::vector<const char*>& schemas) {
  line("def {} \"{}\"{}", type, name, schemas.empty() ? "" : " (");
  if (!schemas.empty()) {
    std::string list;
    for (const char* schema : schemas) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", schema);
    line("    prepend apiSchemas = [{}]", list);
    line(")");
  }
  line("{{");
  ++depth_;
}

void UsdText::close() {
  --depth_;
  line("}}");
}

void UsdText::place(const Transform& pose, const Vec3* scale) {
  line("double3 xformOp:translate = {}", usd_tuple(pose.position));
  line("quatd xformOp:orient = {}", usd_tuple(pose.rotation));
  if (scale != nullptr) line("double3 xformOp:scale = {}", usd_tuple(*scale));
  line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"{}]",
       scale != nullptr ? ", \"xformOp:scale\"" : "");
}

void UsdText::extent(const Vec3& half) { line("float3[] extent = [{}, {}]", usd_tuple(-1.0 * half), usd_tuple(half)); }

void UsdText::ellipsoid_mesh(const Vec3& semi_axes) {
  constexpr int kRings = 9;
  constexpr int kSides = 16;
  std::string points;
  const auto add_point = [&](const Vec3& unit) {
    const Vec3 point{semi_axes.x * unit.x, semi_axes.y * unit.y, semi_axes.z * unit.z};
    points += (points.empty() ? "" : ", ") + usd_tuple(point);
  };
  add_point({-1, 0, 0});
  for (int ring = 1; ring <= kRings; ++ring) {
    const auto [s, c] = exact::sincos(exact::kPi * ring / (kRings + 1));
    for (int side = 0; side < kSides; ++side) {
      const auto around = exact::sincos(2 * exact::kPi * side / kSides);
      add_point({-c, s * around.cos, s * around.sin});
    }
  }
  add_point({1, 0, 0});

  std::string counts;
  std::string corners;
  const auto add_face = [&](std::initializer_list<int> face) {
    counts += fmt::format("{}{}", counts.empty() ? "" : ", ", face.size());
    for (const int corner : face) corners += fmt::format("{}{}", corners.empty() ? "" : ", ", corner);
  };
  const auto at = [](int ring, int side) { return 1 + (ring - 1) * kSides + side % kSides; };
  constexpr int kLast = 1 + kRings * kSides;
  for (int side = 0; side < kSides; ++side) {
    add_face({0, at(1, side + 1), at(1, side)});
    for (int ring = 1; ring < kRings; ++ring) {
      add_face({at(ring, side), at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)});
    }
    add_face({at(kRings, side), at(kRings, side + 1), kLast});
  }
  line("point3f[] points = [{}]", points);
  line("int[] faceVertexCounts = [{}]", counts);
  line("int[] faceVertexIndices = [{}]", corners);
  line("uniform token subdivisionScheme = \"none\"");
  extent(semi_axes);
}

std::string UsdText::finish() { return std::move(out_); }

void UsdText::add(const std::string& line) { out_ += std::string(4 * depth_, ' ') + line + "\n"; }

}  // namespace threewe::exports
