// Where keys are, by the environment.
#include "ros2/enclave.hpp"

#include <unistd.h>

#include <fstream>
#include <map>

#include <doctest/doctest.h>

#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

std::optional<Enclave> read(const std::map<std::string, std::string>& variables) {
  return read_enclave([&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

TEST_CASE("an enclave is a folder of the keystore, whose files become properties") {
  const auto store = std::filesystem::temp_directory_path() / ("threewe_keys_" + std::to_string(::getpid()));
  const auto folder = store / "enclaves" / "robot";
  std::filesystem::create_directories(folder);
  const std::map<std::string, std::string> variables{{"ROS_SECURITY_ENABLE", "true"},
                                                     {"ROS_SECURITY_KEYSTORE", store.string()},
                                                     {"ROS_SECURITY_ENCLAVE_OVERRIDE", "/robot"}};
  CHECK_THROWS_WITH_AS(read(variables),
                       ("the security enclave '/robot' has no identity_ca.cert.pem, in " + folder.string()).c_str(),
                       ConfigError);
  for (const char* name : {"identity_ca.cert.pem", "cert.pem", "key.pem", "permissions_ca.cert.pem", "governance.p7s",
                           "permissions.p7s"}) {
    std::ofstream(folder / name) << "x";
  }
  const auto enclave = read(variables);
  REQUIRE(enclave);
  CHECK(enclave->name == "/robot");
  const auto properties = security_properties(*enclave);
  CHECK(properties.size() == 15);
  CHECK(properties[2].first == "dds.sec.auth.private_key");
  CHECK(properties[2].second == "file:" + (folder / "key.pem").string());
  std::filesystem::remove_all(store);
}

TEST_CASE("security that is off needs nothing, and half of it is an error") {
  CHECK_FALSE(read({}));
  CHECK_FALSE(read({{"ROS_SECURITY_ENABLE", "false"}, {"ROS_SECURITY_KEYSTORE", "/nowhere"}}));
  CHECK_THROWS_AS(read({{"ROS_SECURITY_ENABLE", "True"}}), ConfigError);
  CHECK_THROWS_AS(read({{"ROS_SECURITY_ENABLE", "true"}}), ConfigError);
  CHECK_THROWS_AS(read({{"ROS_SECURITY_ENABLE", "true"}, {"ROS_SECURITY_KEYSTORE", "/nowhere"}}), ConfigError);
}

}  // namespace
}  // namespace threewe::ros2
