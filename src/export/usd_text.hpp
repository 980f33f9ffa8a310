// USD text writer: prims within prims, indented.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "xml.hpp"

namespace threewe::exports {

std::string usd_tuple(const Vec3& v);
std::string usd_tuple(const Quaternion& q);

/// Names as prims may have them, each once.
class UsdNames {
 public:
  std::string of(const std::string& name);

 private:
  std::set<std::string> taken_;
};

/// A layer that is being written.
class UsdText {
 public:
  UsdText();
  /// Begins a prim of a type, with schemas applied to it.
  void open(const char* type, const std::string& name, const std::vector<const char*>& schemas = {});
  void close();
  template <typename... Parts>
  void line(fmt::format_string<Parts...> form, Parts&&... parts) {
    add(fmt::format(form, std::forward<Parts>(parts)...));
  }
  /// Where the prim is in its parent, scaled where `scale` is given.
  void place(const Transform& pose, const Vec3* scale = nullptr);
  /// Half of the box that holds the prim's shape.
  void extent(const Vec3& half);
  /// The points and faces of an ellipsoid, its poles on the x axis: a polyhedron whose corners lie on it.
  void ellipsoid_mesh(const Vec3& semi_axes);
  std::string finish();

 private:
  void add(const std::string& line);
  std::string out_;
  std::size_t depth_ = 0;
};

}  // namespace threewe::exports
