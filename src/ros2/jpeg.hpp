// JPEG pictures, read and written by libjpeg-turbo, which is loaded when the first one comes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "threewe/hardware/profile.hpp"

namespace threewe::ros2 {

/// Width and height, or what is wrong: no JPEG, or no library, with the package to install.
tl::expected<ImageSize, std::string> jpeg_size(std::span<const std::uint8_t> jpeg);
/// Shape (H, W, 3): blue, green, red. Throws ContractError where it cannot be decoded.
std::vector<std::uint8_t> decode_jpeg(std::span<const std::uint8_t> jpeg);
/// Of a picture of shape (H, W, 3): blue, green, red. Throws ContractError without the library, naming the package.
std::vector<std::uint8_t> encode_jpeg(std::span<const std::uint8_t> bgr, const ImageSize& size);

}  // namespace threewe::ros2
