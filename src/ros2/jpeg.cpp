#include "ros2/jpeg.hpp"

#include <memory>

#include <dlfcn.h>
#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#if THREEWE_WITH_TURBOJPEG
#include <turbojpeg.h>
#endif

namespace threewe::ros2 {
namespace {

constexpr const char* kMissing = "a compressed image, which needs libjpeg-turbo: apt install libturbojpeg0";

}  // namespace

#if THREEWE_WITH_TURBOJPEG

namespace {

struct Library {
  decltype(&::tjInitDecompress) init = nullptr;
  decltype(&::tjDecompressHeader3) header = nullptr;
  decltype(&::tjDecompress2) decompress = nullptr;
  decltype(&::tjInitCompress) init_compressor = nullptr;
  decltype(&::tjCompress2) compress = nullptr;
  decltype(&::tjFree) free = nullptr;
  decltype(&::tjDestroy) destroy = nullptr;
  decltype(&::tjGetErrorStr2) error = nullptr;
  decltype(&::tjGetErrorCode) error_code = nullptr;
};

// Its interface has been the same since version 1.2, in libraries of this name.
Library load() {
  Library found;
  void* handle = ::dlopen("libturbojpeg.so.0", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) return found;
  const auto find = [handle]<typename Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    return function != nullptr;
  };
  const bool complete = find(found.init, "tjInitDecompress") && find(found.header, "tjDecompressHeader3") &&
                        find(found.decompress, "tjDecompress2") && find(found.destroy, "tjDestroy") &&
                        find(found.init_compressor, "tjInitCompress") && find(found.compress, "tjCompress2") &&
                        find(found.free, "tjFree") && find(found.error, "tjGetErrorStr2") &&
                        find(found.error_code, "tjGetErrorCode");
  return complete ? found : Library{};
}

const Library& library() {
  static const Library loaded = load();
  return loaded;
}

struct Destroyer {
  void operator()(void* decoder) const { library().destroy(decoder); }
};
using Decoder = std::unique_ptr<void, Destroyer>;

tl::expected<ImageSize, std::string> size_in(const Decoder& decoder, std::span<const std::uint8_t> jpeg) {
  ImageSize size;
  int subsampling = 0;
  int colors = 0;
  if (library().header(decoder.get(), jpeg.data(), jpeg.size(), &size.width, &size.height, &subsampling, &colors) !=
      0) {
    return tl::unexpected(fmt::format("no JPEG: {}", library().error(decoder.get())));
  }
  return size;
}

}  // namespace

tl::expected<ImageSize, std::string> jpeg_size(std::span<const std::uint8_t> jpeg) {
  if (library().init == nullptr) return tl::unexpected(std::string(kMissing));
  return size_in(Decoder(library().init()), jpeg);
}

std::vector<std::uint8_t> decode_jpeg(std::span<const std::uint8_t> jpeg) {
  if (library().init == nullptr) throw ContractError(kMissing);
  const Decoder decoder(library().init());
  const auto size = size_in(decoder, jpeg);
  if (!size) throw ContractError(size.error());
  const auto [width, height] = *size;
  std::vector<std::uint8_t> bgr(std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const int failed =
      library().decompress(decoder.get(), jpeg.data(), jpeg.size(), bgr.data(), width, 3 * width, height, TJPF_BGR, 0);
  // a warning is of data that is missing or wrong, in whose place there is grey: better than none
  if (failed != 0 && library().error_code(decoder.get()) != TJERR_WARNING) {
    throw ContractError(fmt::format("no JPEG: {}", library().error(decoder.get())));
  }
  return bgr;
}

std::vector<std::uint8_t> encode_jpeg(std::span<const std::uint8_t> bgr, const ImageSize& size) {
  if (library().init == nullptr) throw ContractError(kMissing);
  constexpr int kQuality = 90;  // of 100
  const Decoder compressor(library().init_compressor());
  unsigned char* made = nullptr;
  unsigned long length = 0;  // NOLINT(google-runtime-int): as the library has it
  const int failed = library().compress(compressor.get(), bgr.data(), size.width, 3 * size.width, size.height, TJPF_BGR,
                                        &made, &length, TJSAMP_420, kQuality, 0);
  const std::unique_ptr<unsigned char, decltype(library().free)> owner(made, library().free);
  if (failed != 0) throw ContractError(fmt::format("no JPEG was made: {}", library().error(compressor.get())));
  return {made, made + length};
}

#else

tl::expected<ImageSize, std::string> jpeg_size(std::span<const std::uint8_t>) {
  return tl::unexpected(
      std::string("a compressed image, and this build of threewe was made without turbojpeg.h: apt "
                  "install libturbojpeg0-dev, then build threewe again"));
}

std::vector<std::uint8_t> decode_jpeg(std::span<const std::uint8_t>) { throw ContractError(kMissing); }

std::vector<std::uint8_t> encode_jpeg(std::span<const std::uint8_t>, const ImageSize&) {
  throw ContractError(kMissing);
}

#endif

}  // namespace threewe::ros2
