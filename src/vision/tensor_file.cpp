#include "vision/tensor_file.hpp"

#include <bit>
#include <cstring>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "threewe/core/errors.hpp"

namespace threewe::vision {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "safetensors files are little-endian");

template <class Integer>
std::vector<std::int32_t> widened(const char* from, std::size_t count) {
  std::vector<Integer> values(count);
  std::memcpy(values.data(), from, count * sizeof(Integer));
  return {values.begin(), values.end()};
}

}  // namespace

TensorFile TensorFile::load(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) throw ConfigError(fmt::format("{}: {}", file.string(), error.message()));
  if (size > kLargestTensorFile)
    throw ConfigError(fmt::format("{}: {} bytes are too many; at most {}", file.string(), size, kLargestTensorFile));
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(size, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return parse(bytes, file.string());
}

TensorFile TensorFile::parse(const std::string& bytes, const std::string& name) {
  TensorFile file;
  file.name_ = name;
  std::uint64_t length = 0;
  if (bytes.size() < sizeof(length)) file.fail("it is cut off");
  std::memcpy(&length, bytes.data(), sizeof(length));
  if (length > bytes.size() - sizeof(length)) file.fail("its header is cut off, or it is no safetensors file");
  const std::size_t begin = sizeof(length) + length;
  const std::size_t room = bytes.size() - begin;
  try {
    const json header = json::parse(bytes.data() + sizeof(length), bytes.data() + begin);
    for (const auto& [key, value] : header.items()) {
      if (key == "__metadata__") {
        file.texts_ = value.get<std::map<std::string, std::string>>();
        continue;
      }
      const auto type = value.at("dtype").get<std::string>();
      const auto [from, to] = value.at("data_offsets").get<std::pair<std::size_t, std::size_t>>();
      Array array{value.at("shape").get<std::vector<std::size_t>>(), {}};
      if (type != "I16" && type != "I32") file.fail(fmt::format("'{}' is of type {}; I16 or I32 is read", key, type));
      const std::size_t size = type == "I16" ? 2 : 4;
      if (to > room || from > to) file.fail(fmt::format("'{}' is cut off", key));
      std::size_t count = 1;
      for (const std::size_t n : array.shape) {
        if (n != 0 && count > room / n) file.fail(fmt::format("'{}' is larger than the file", key));
        count *= n;
      }
      if (count * size != to - from) file.fail(fmt::format("'{}' has not the size of its shape", key));
      const char* data = bytes.data() + begin + from;
      array.values = size == 2 ? widened<std::int16_t>(data, count) : widened<std::int32_t>(data, count);
      file.arrays_.emplace(key, std::move(array));
    }
  } catch (const json::exception& error) {
    file.fail(fmt::format("its header is no header of a safetensors file: {}", error.what()));
  }
  return file;
}

const std::string& TensorFile::text(const std::string& key) const {
  const auto found = texts_.find(key);
  if (found == texts_.end()) fail(fmt::format("its metadata has no '{}'", key));
  return found->second;
}

const std::vector<std::int32_t>& TensorFile::array(const std::string& name,
                                                   const std::vector<std::size_t>& shape) const {
  const auto found = arrays_.find(name);
  if (found == arrays_.end()) fail(fmt::format("it has no array '{}'", name));
  if (found->second.shape != shape)
    fail(fmt::format("'{}' has the shape [{}] instead of [{}]", name, fmt::join(found->second.shape, ", "),
                     fmt::join(shape, ", ")));
  return found->second.values;
}

void TensorFile::fail(const std::string& what) const { throw ConfigError(fmt::format("{}: {}", name_, what)); }

}  // namespace threewe::vision
