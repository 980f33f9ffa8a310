// Session of onnxruntime: a policy's graph, run by the C interface of a library that is loaded at run time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace threewe::policy {

/// A tensor of float32 that a graph takes or gives.
struct TensorShape {
  std::string name;
  std::vector<std::int64_t> lengths;
};

/// A picture of a camera, and what the network takes of it: (3, height, width) 0 to 1, each pixel the mean of those
/// that it stands for.
struct PictureInput {
  std::vector<std::uint8_t> bgr;  ///< rows of pixels, `factor * height` by `factor * width`
  std::size_t height = 0;         ///< [px] of the network's
  std::size_t width = 0;          ///< [px] of the network's
  std::size_t factor = 1;         ///< how many times as large the picture is, both ways
  bool rgb = true;                ///< order of the network's channels; else BGR
};
std::vector<float> network_input(const PictureInput& picture);

/// Numbers of an input, or a picture that becomes them.
using GraphInput = std::variant<std::vector<float>, PictureInput>;

/// One graph on one thread. What it computes depends on nothing but its inputs.
class GraphSession {
 public:
  /// Throws ConfigError where the library is not onnxruntime, or does not take the graph.
  GraphSession(const std::filesystem::path& library, std::span<const std::byte> graph, std::vector<TensorShape> inputs,
               TensorShape output);

  /// The output for inputs in their order; may be called by several threads at a time. Throws ContractError where they
  /// have another length, ThreeweError where onnxruntime fails.
  std::vector<float> run(const std::vector<GraphInput>& inputs) const;

  const TensorShape& output() const { return output_; }

 private:
  class Runtime;
  static const Runtime& runtime(const std::filesystem::path& library);

  std::vector<TensorShape> inputs_;
  TensorShape output_;
  const Runtime& runtime_;
  std::shared_ptr<void> session_;
};

/// Runs a session in a thread of its own. A result that is dropped is not waited for, but by the end of the program.
std::shared_future<std::vector<float>> start(std::shared_ptr<const GraphSession> session,
                                             std::vector<GraphInput> inputs);

}  // namespace threewe::policy
