#include "backend/mujoco/world/gl.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <dlfcn.h>
#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

// What we call of EGL 1.5 (Khronos), and what these calls take: its headers are on few machines.
using Handle = void*;
using Attribute = std::intptr_t;
constexpr std::int32_t kEnd = 0x3038;               // EGL_NONE
constexpr std::int32_t kSurfaceType = 0x3033;       // EGL_SURFACE_TYPE
constexpr std::int32_t kOffscreen = 0x0001;         // EGL_PBUFFER_BIT
constexpr std::int32_t kRenderableType = 0x3040;    // EGL_RENDERABLE_TYPE
constexpr std::int32_t kDesktopGl = 0x0008;         // EGL_OPENGL_BIT
constexpr std::uint32_t kOpenGl = 0x30A2;           // EGL_OPENGL_API
constexpr std::uint32_t kDevicePlatform = 0x313F;   // EGL_PLATFORM_DEVICE_EXT
constexpr std::uint32_t kSurfacelessMesa = 0x31DD;  // EGL_PLATFORM_SURFACELESS_MESA
constexpr std::int32_t kDrawSurface = 0x3059;       // EGL_DRAW
constexpr std::int32_t kReadSurface = 0x305A;       // EGL_READ
constexpr int kMostDevices = 32;

struct Egl {
  void* (*get_proc_address)(const char*);
  unsigned (*initialize)(Handle display, std::int32_t* major, std::int32_t* minor);
  unsigned (*bind_api)(std::uint32_t api);
  std::uint32_t (*query_api)();
  unsigned (*choose_config)(Handle display, const std::int32_t* attributes, Handle* configs, std::int32_t size,
                            std::int32_t* found);
  Handle (*create_context)(Handle display, Handle config, Handle share, const std::int32_t* attributes);
  unsigned (*destroy_context)(Handle display, Handle context);
  unsigned (*make_current)(Handle display, Handle draw, Handle read, Handle context);
  Handle (*current_display)();
  Handle (*current_surface)(std::int32_t which);
  Handle (*current_context)();
  Handle (*get_platform_display)(std::uint32_t platform, Handle native, const Attribute* attributes);
  unsigned (*query_devices)(std::int32_t size, Handle* devices, std::int32_t* found);  // null where not offered
};

[[noreturn]] void fail(const std::string& what) {
  throw HardwareError(
      fmt::format("backend 'mujoco' cannot draw what cameras see: {}\n{} (or the driver of a graphics card)", what,
                  kInstallRenderer));
}

Egl load() {
  // seen by all: MuJoCo looks for `eglGetProcAddress` among what the process has loaded
  void* library = ::dlopen("libEGL.so.1", RTLD_NOW | RTLD_GLOBAL);
  if (library == nullptr) fail(::dlerror());
  const auto find = [library]<typename Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(library, name));
    if (function == nullptr) fail(fmt::format("libEGL.so.1 has no {}", name));
  };
  Egl egl{};
  find(egl.get_proc_address, "eglGetProcAddress");
  find(egl.initialize, "eglInitialize");
  find(egl.bind_api, "eglBindAPI");
  find(egl.query_api, "eglQueryAPI");
  find(egl.choose_config, "eglChooseConfig");
  find(egl.create_context, "eglCreateContext");
  find(egl.destroy_context, "eglDestroyContext");
  find(egl.make_current, "eglMakeCurrent");
  find(egl.current_display, "eglGetCurrentDisplay");
  find(egl.current_surface, "eglGetCurrentSurface");
  find(egl.current_context, "eglGetCurrentContext");
  find(egl.get_platform_display, "eglGetPlatformDisplay");
  egl.query_devices = reinterpret_cast<decltype(egl.query_devices)>(egl.get_proc_address("eglQueryDevicesEXT"));
  return egl;
}

const Egl& egl() {
  static const Egl loaded = load();
  return loaded;
}

// Where drawing may be possible, best first: graphics cards and Mesa's software renderer as devices, then Mesa alone.
std::vector<Handle> displays() {
  std::vector<Handle> found;
  std::array<Handle, kMostDevices> devices{};
  std::int32_t count = 0;
  if (egl().query_devices == nullptr || egl().query_devices(kMostDevices, devices.data(), &count) == 0) count = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    found.push_back(egl().get_platform_display(kDevicePlatform, devices[static_cast<std::size_t>(i)], nullptr));
  }
  found.push_back(egl().get_platform_display(kSurfacelessMesa, nullptr, nullptr));
  std::erase(found, nullptr);
  return found;
}

// A context for desktop OpenGL; null where the display offers none. A display stays initialized, as others in the
// process may draw on it too.
Handle make_context(Handle display) {
  constexpr std::array<std::int32_t, 5> kWanted{kSurfaceType, kOffscreen, kRenderableType, kDesktopGl, kEnd};
  Handle config = nullptr;
  std::int32_t found = 0;
  if (egl().initialize(display, nullptr, nullptr) == 0) return nullptr;
  if (egl().choose_config(display, kWanted.data(), &config, 1, &found) == 0 || found == 0) return nullptr;
  return egl().create_context(display, config, nullptr, nullptr);
}

}  // namespace

GlContext::GlContext() {
  const std::uint32_t api = egl().query_api();
  if (egl().bind_api(kOpenGl) == 0) fail("EGL offers no OpenGL");
  for (void* display : displays()) {
    context_ = make_context(display);
    if (context_ == nullptr) continue;
    display_ = display;
    break;
  }
  if (api != 0) egl().bind_api(api);
  if (context_ == nullptr) fail("no device that EGL knows offers OpenGL");
}

GlContext::~GlContext() { egl().destroy_context(display_, context_); }

GlContext::Current::Current(const GlContext& context)
    : display_(egl().current_display()),
      draw_(egl().current_surface(kDrawSurface)),
      read_(egl().current_surface(kReadSurface)),
      context_(egl().current_context()),
      own_display_(context.display_) {
  if (egl().make_current(context.display_, nullptr, nullptr, context.context_) == 0) {
    fail("EGL does not let this thread draw");
  }
}

GlContext::Current::~Current() {
  egl().make_current(own_display_, nullptr, nullptr, nullptr);
  if (context_ != nullptr) egl().make_current(display_, draw_, read_, context_);
}

}  // namespace threewe::backend::mujoco
