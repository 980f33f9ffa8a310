#include "ros2/enclave.hpp"

#include <array>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

// A file of an enclave, and the property that names it.
struct File {
  const char* name;
  const char* property;
};
constexpr std::array<File, 6> kFiles{{{"identity_ca.cert.pem", "dds.sec.auth.identity_ca"},
                                      {"cert.pem", "dds.sec.auth.identity_certificate"},
                                      {"key.pem", "dds.sec.auth.private_key"},
                                      {"permissions_ca.cert.pem", "dds.sec.access.permissions_ca"},
                                      {"governance.p7s", "dds.sec.access.governance"},
                                      {"permissions.p7s", "dds.sec.access.permissions"}}};

// A part of DDS security that Cyclone DDS loads: its properties, its library, and how that is begun and ended.
struct Plugin {
  const char* property;
  const char* library;
  const char* subject;
};
constexpr std::array<Plugin, 3> kPlugins{{{"dds.sec.auth", "dds_security_auth", "authentication"},
                                          {"dds.sec.access", "dds_security_ac", "access_control"},
                                          {"dds.sec.crypto", "dds_security_crypto", "crypto"}}};

}  // namespace

std::optional<Enclave> read_enclave(const std::function<const char*(const char* name)>& environment) {
  const auto text = [&](const char* name) {
    const char* value = environment(name);
    return std::string(value == nullptr ? "" : value);
  };
  const std::string enable = text("ROS_SECURITY_ENABLE");
  if (enable.empty() || enable == "false") return std::nullopt;
  if (enable != "true") {
    throw ConfigError(fmt::format("ROS_SECURITY_ENABLE is '{}'; it must be true or false", enable));
  }
  const std::string keystore = text("ROS_SECURITY_KEYSTORE");
  if (keystore.empty()) {
    throw ConfigError("ROS_SECURITY_ENABLE is true, and ROS_SECURITY_KEYSTORE names no folder of keys");
  }
  Enclave enclave;
  enclave.name = text("ROS_SECURITY_ENCLAVE_OVERRIDE");
  if (enclave.name.empty()) enclave.name.push_back('/');
  if (!enclave.name.starts_with('/') || enclave.name.find("..") != std::string::npos) {
    throw ConfigError(
        fmt::format("ROS_SECURITY_ENCLAVE_OVERRIDE is '{}'; it must be a name such as /robot", enclave.name));
  }
  enclave.folder = std::filesystem::path(keystore) / "enclaves" / enclave.name.substr(1);
  std::error_code error;
  if (!std::filesystem::is_directory(enclave.folder, error)) {
    throw ConfigError(fmt::format(
        "ROS_SECURITY_KEYSTORE has no enclave '{}': there is no folder {}; `ros2 security create_enclave` makes one",
        enclave.name, enclave.folder.string()));
  }
  for (const File& file : kFiles) {
    if (std::filesystem::is_regular_file(enclave.folder / file.name, error)) continue;
    throw ConfigError(
        fmt::format("the security enclave '{}' has no {}, in {}", enclave.name, file.name, enclave.folder.string()));
  }
  return enclave;
}

std::vector<std::pair<std::string, std::string>> security_properties(const Enclave& enclave) {
  std::vector<std::pair<std::string, std::string>> properties;
  for (const File& file : kFiles) {
    properties.emplace_back(file.property, fmt::format("file:{}", (enclave.folder / file.name).string()));
  }
  for (const Plugin& plugin : kPlugins) {
    const std::string library = fmt::format("{}.library.", plugin.property);
    properties.emplace_back(library + "path", plugin.library);
    properties.emplace_back(library + "init", fmt::format("init_{}", plugin.subject));
    properties.emplace_back(library + "finalize", fmt::format("finalize_{}", plugin.subject));
  }
  return properties;
}

}  // namespace threewe::ros2
