#include "ros2/dds/library.hpp"

#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>
#include <fmt/format.h>

#include "ros2/real.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

[[noreturn]] void fail(std::string_view what) {
  throw ConfigError(fmt::format("backend 'real' needs Cyclone DDS {}: {}\n{}", DDS_VERSION, what, kInstall));
}

template <typename Function>
void find(void* handle, Function& function, const char* name) {
  function = reinterpret_cast<Function>(::dlsym(handle, name));
  if (function == nullptr) fail(fmt::format("the library has no {}", name));
}

// Structs of Cyclone's are ours to fill in: another version may have them otherwise. Its files are named by version.
void check_version(const void* function) {
  Dl_info info{};
  if (::dladdr(function, &info) == 0) fail("its file is not known");
  std::error_code error;
  const std::string file = std::filesystem::canonical(info.dli_fname, error).filename().string();
  if (!file.ends_with(DDS_VERSION)) fail(fmt::format("found {}", error ? info.dli_fname : file));
}

Library load() {
  // by the name that Debian and Ubuntu gave it, then by that of others
  void* handle = ::dlopen("libddsc.so.0debian", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) handle = ::dlopen("libddsc.so.0", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail(::dlerror());

  Library found{};
  find(handle, found.dds_create_domain, "dds_create_domain");
  check_version(reinterpret_cast<const void*>(found.dds_create_domain));
  find(handle, found.dds_create_participant, "dds_create_participant");
  find(handle, found.dds_create_topic_sertype, "dds_create_topic_sertype");
  find(handle, found.dds_create_reader, "dds_create_reader");
  find(handle, found.dds_create_writer, "dds_create_writer");
  find(handle, found.dds_delete, "dds_delete");
  find(handle, found.dds_create_listener, "dds_create_listener");
  find(handle, found.dds_delete_listener, "dds_delete_listener");
  find(handle, found.dds_lset_data_available, "dds_lset_data_available");
  find(handle, found.dds_create_qos, "dds_create_qos");
  find(handle, found.dds_delete_qos, "dds_delete_qos");
  find(handle, found.dds_qset_reliability, "dds_qset_reliability");
  find(handle, found.dds_qset_durability, "dds_qset_durability");
  find(handle, found.dds_qset_durability_service, "dds_qset_durability_service");
  find(handle, found.dds_qset_history, "dds_qset_history");
  find(handle, found.dds_qset_userdata, "dds_qset_userdata");
  find(handle, found.dds_qset_writer_data_lifecycle, "dds_qset_writer_data_lifecycle");
  find(handle, found.dds_qget_reliability, "dds_qget_reliability");
  find(handle, found.dds_qget_durability, "dds_qget_durability");
  find(handle, found.dds_qget_userdata, "dds_qget_userdata");
  find(handle, found.dds_read, "dds_read");
  find(handle, found.dds_return_loan, "dds_return_loan");
  find(handle, found.dds_takecdr, "dds_takecdr");
  find(handle, found.dds_write, "dds_write");
  find(handle, found.dds_wait_for_acks, "dds_wait_for_acks");
  find(handle, found.dds_get_guid, "dds_get_guid");
  find(handle, found.dds_strretcode, "dds_strretcode");
  find(handle, found.dds_free, "dds_free");
  find(handle, found.dds_qset_prop, "dds_qset_prop");
  find(handle, found.dds_set_log_sink, "dds_set_log_sink");
  find(handle, found.dds_get_matched_publications, "dds_get_matched_publications");
  find(handle, found.dds_get_matched_subscriptions, "dds_get_matched_subscriptions");
  find(handle, found.ddsi_sertype_v0, "ddsi_sertype_v0");
  find(handle, found.ddsi_sertype_init, "ddsi_sertype_init");
  find(handle, found.ddsi_sertype_fini, "ddsi_sertype_fini");
  find(handle, found.ddsi_serdata_init, "ddsi_serdata_init");
  return found;
}

}  // namespace

const Library& library() {
  static const Library loaded = load();  // tried again by the next call where it throws
  return loaded;
}

std::int32_t checked(std::int32_t value, std::string_view what) {
  if (value >= 0) return value;
  throw ConnectionError(fmt::format("Cyclone DDS: {}: {}", what, library().dds_strretcode(value)));
}

}  // namespace threewe::ros2
