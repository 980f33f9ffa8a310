// Off-screen OpenGL context by EGL, on a graphics card or in software.
#pragma once

namespace threewe::backend::mujoco {

/// What it takes to draw on Debian and Ubuntu where there is no graphics card.
inline constexpr const char* kInstallRenderer = "apt-get install libegl1 libgl1-mesa-dri";

class GlContext {
 public:
  /// Throws HardwareError, saying what to install, where none can be made.
  GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  ~GlContext();

  /// The thread draws in the context while this lives; then in what it drew in before. One thread at a time.
  class Current {
   public:
    explicit Current(const GlContext& context);
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    ~Current();

   private:
    void* display_;
    void* draw_;
    void* read_;
    void* context_;
    void* own_display_;
  };

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace threewe::backend::mujoco
