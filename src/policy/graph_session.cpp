#include "policy/graph_session.hpp"

#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::policy {
namespace {

// The C interface is a table of functions that only ever grows at its end: those of version 1 keep their places.
enum Place : std::size_t {
  kGetErrorMessage = 2,
  kCreateEnv = 3,
  kCreateSessionFromArray = 8,
  kRun = 9,
  kCreateSessionOptions = 10,
  kSetSessionLogSeverityLevel = 22,
  kSetIntraOpNumThreads = 24,
  kSetInterOpNumThreads = 25,
  kCreateTensorWithDataAsOrtValue = 49,
  kCreateCpuMemoryInfo = 69,
  kReleaseStatus = 93,
  kReleaseMemoryInfo = 94,
  kReleaseSession = 95,
  kReleaseValue = 96,
  kReleaseSessionOptions = 100,
};
constexpr std::uint32_t kVersion = 1;
constexpr int kFatal = 4;  // what is logged
constexpr int kFloat = 1;  // of an element
constexpr int kArena = 1;  // of an allocator
constexpr int kDefaultMemory = 0;

using Table = void (*const*)();
using Status = void*;  // null where all went well

struct Base {
  Table (*get_api)(std::uint32_t version);
  const char* (*get_version)();
};

// Results that are not there yet. Who drops one need not wait for it; the end of the program does.
class Running {
 public:
  std::shared_future<std::vector<float>> keep(std::shared_future<std::vector<float>> result) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(results_, [](const auto& each) { return each.wait_for(std::chrono::seconds(0)) == kReady; });
    results_.push_back(result);
    return result;
  }

 private:
  static constexpr auto kReady = std::future_status::ready;
  std::mutex mutex_;
  std::vector<std::shared_future<std::vector<float>>> results_;
};

std::size_t size(const TensorShape& tensor) {
  return static_cast<std::size_t>(
      std::accumulate(tensor.lengths.begin(), tensor.lengths.end(), std::int64_t{1}, std::multiplies<>()));
}

}  // namespace

// The functions, and what all sessions share; it stays in memory.
class GraphSession::Runtime {
 public:
  explicit Runtime(const std::filesystem::path& library) {
    void* handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw ConfigError(fmt::format("onnxruntime: {}", ::dlerror()));
    const auto base = reinterpret_cast<const Base* (*)()>(::dlsym(handle, "OrtGetApiBase"));
    if (base == nullptr) throw ConfigError(fmt::format("{}: not onnxruntime: no OrtGetApiBase", library.string()));
    table_ = base()->get_api(kVersion);
    call(kCreateEnv, kFatal, static_cast<const char*>("threewe"), &env_);
    call(kCreateCpuMemoryInfo, kArena, kDefaultMemory, &memory_);
  }

  // Calls a function that returns a status. Throws ThreeweError.
  template <typename... Arguments>
  void call(Place place, Arguments... arguments) const {
    void* const status = at<Status, Arguments...>(place)(arguments...);
    if (status == nullptr) return;
    const std::string message = at<const char*, const void*>(kGetErrorMessage)(status);
    release(kReleaseStatus, status);
    throw ThreeweError(message.substr(0, message.find('\n')));
  }

  void release(Place place, void* thing) const { at<void, void*>(place)(thing); }

  // What a function makes, released by another.
  std::shared_ptr<void> owned(void* thing, Place release_it) const {
    return {thing, [this, release_it](void* one) { release(release_it, one); }};
  }

  std::shared_ptr<void> session(std::span<const std::byte> graph) const {
    void* made = nullptr;
    call(kCreateSessionOptions, &made);
    const auto options = owned(made, kReleaseSessionOptions);
    call(kSetSessionLogSeverityLevel, options.get(), kFatal);
    call(kSetIntraOpNumThreads, options.get(), 1);
    call(kSetInterOpNumThreads, options.get(), 1);
    call(kCreateSessionFromArray, static_cast<const void*>(env_), static_cast<const void*>(graph.data()), graph.size(),
         static_cast<const void*>(options.get()), &made);
    return owned(made, kReleaseSession);
  }

  // A tensor in memory of the caller's.
  std::shared_ptr<void> tensor(std::span<float> values, const std::vector<std::int64_t>& lengths) const {
    void* made = nullptr;
    call(kCreateTensorWithDataAsOrtValue, static_cast<const void*>(memory_), static_cast<void*>(values.data()),
         values.size_bytes(), lengths.data(), lengths.size(), kFloat, &made);
    return owned(made, kReleaseValue);
  }

 private:
  template <typename Result, typename... Arguments>
  Result (*at(Place place) const)(Arguments...) {
    return reinterpret_cast<Result (*)(Arguments...)>(table_[place]);
  }

  Table table_ = nullptr;
  void* env_ = nullptr;
  void* memory_ = nullptr;
};

const GraphSession::Runtime& GraphSession::runtime(const std::filesystem::path& library) {
  static std::mutex mutex;
  static std::map<std::filesystem::path, const Runtime*> loaded;
  const std::scoped_lock lock(mutex);
  const Runtime*& found = loaded[library];
  if (found == nullptr) found = new Runtime(library);  // never deleted: sessions may outlive whatever has an end
  return *found;
}

GraphSession::GraphSession(const std::filesystem::path& library, std::span<const std::byte> graph,
                           std::vector<TensorShape> inputs, TensorShape output)
    : inputs_(std::move(inputs)),
      output_(std::move(output)),
      runtime_(runtime(library)),
      session_(runtime_.session(graph)) {}

std::vector<float> GraphSession::run(const std::vector<GraphInput>& inputs) const {
  if (inputs.size() != inputs_.size()) {
    throw ContractError(fmt::format("the graph takes {} inputs, got {}", inputs_.size(), inputs.size()));
  }
  std::vector<std::vector<float>> values;
  std::vector<std::shared_ptr<void>> tensors;
  std::vector<const char*> names;
  std::vector<const void*> given;
  values.reserve(inputs.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto* picture = std::get_if<PictureInput>(&inputs[i]);
    values.push_back(picture != nullptr ? network_input(*picture) : std::get<std::vector<float>>(inputs[i]));
    if (values.back().size() != size(inputs_[i])) {
      throw ContractError(
          fmt::format("input '{}' has {} numbers, got {}", inputs_[i].name, size(inputs_[i]), values.back().size()));
    }
    tensors.push_back(runtime_.tensor(values.back(), inputs_[i].lengths));
    names.push_back(inputs_[i].name.c_str());
    given.push_back(tensors.back().get());
  }

  std::vector<float> actions(size(output_));
  const std::shared_ptr<void> out = runtime_.tensor(actions, output_.lengths);
  void* out_value = out.get();
  const char* out_name = output_.name.c_str();
  runtime_.call(kRun, session_.get(), static_cast<const void*>(nullptr), static_cast<const char* const*>(names.data()),
                static_cast<const void* const*>(given.data()), given.size(), static_cast<const char* const*>(&out_name),
                std::size_t{1}, &out_value);
  return actions;
}

std::shared_future<std::vector<float>> start(std::shared_ptr<const GraphSession> session,
                                             std::vector<GraphInput> inputs) {
  static Running running;
  auto result = std::async(std::launch::async,
                           [session = std::move(session), inputs = std::move(inputs)] { return session->run(inputs); });
  return running.keep(result.share());
}

std::vector<float> network_input(const PictureInput& picture) {
  const std::size_t n = picture.factor;
  const std::size_t pixels = picture.height * picture.width;
  if (picture.bgr.size() != 3 * n * n * pixels) {
    throw ContractError(fmt::format("a picture of {} times {} x {} pixels has {} bytes, got {}", n, picture.height,
                                    picture.width, 3 * n * n * pixels, picture.bgr.size()));
  }
  std::vector<float> out(3 * pixels);
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      std::array<std::uint32_t, 3> sums{};
      for (std::size_t row = n * y; row < n * (y + 1); ++row) {
        const std::uint8_t* pixel = &picture.bgr[3 * (row * n * picture.width + n * x)];
        for (std::size_t i = 0; i < 3 * n; ++i) sums[i % 3] += pixel[i];
      }
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const float mean = static_cast<float>(sums[picture.rgb ? 2 - channel : channel]) / static_cast<float>(n * n);
        out[channel * pixels + y * picture.width + x] = mean / 255.0F;
      }
    }
  }
  return out;
}

}  // namespace threewe::policy
