// Cyclone DDS's functions, found in its library when they are first needed.
#pragma once

#include <string_view>

// its headers are C, with what our warnings do not like
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>
#include <dds/version.h>
#pragma GCC diagnostic pop

namespace threewe::ros2 {

/// What we call of Cyclone DDS, under its own names.
struct Library {
  decltype(&::dds_create_domain) dds_create_domain;
  decltype(&::dds_create_participant) dds_create_participant;
  decltype(&::dds_create_topic_sertype) dds_create_topic_sertype;
  decltype(&::dds_create_reader) dds_create_reader;
  decltype(&::dds_create_writer) dds_create_writer;
  decltype(&::dds_delete) dds_delete;
  decltype(&::dds_create_listener) dds_create_listener;
  decltype(&::dds_delete_listener) dds_delete_listener;
  decltype(&::dds_lset_data_available) dds_lset_data_available;
  decltype(&::dds_create_qos) dds_create_qos;
  decltype(&::dds_delete_qos) dds_delete_qos;
  decltype(&::dds_qset_reliability) dds_qset_reliability;
  decltype(&::dds_qset_durability) dds_qset_durability;
  decltype(&::dds_qset_durability_service) dds_qset_durability_service;
  decltype(&::dds_qset_history) dds_qset_history;
  decltype(&::dds_qset_userdata) dds_qset_userdata;
  decltype(&::dds_qset_writer_data_lifecycle) dds_qset_writer_data_lifecycle;
  decltype(&::dds_qget_reliability) dds_qget_reliability;
  decltype(&::dds_qget_durability) dds_qget_durability;
  decltype(&::dds_qget_userdata) dds_qget_userdata;
  decltype(&::dds_read) dds_read;
  decltype(&::dds_return_loan) dds_return_loan;
  decltype(&::dds_takecdr) dds_takecdr;
  decltype(&::dds_write) dds_write;
  decltype(&::dds_wait_for_acks) dds_wait_for_acks;
  decltype(&::dds_get_guid) dds_get_guid;
  decltype(&::dds_strretcode) dds_strretcode;
  decltype(&::dds_free) dds_free;
  decltype(&::dds_qset_prop) dds_qset_prop;
  decltype(&::dds_set_log_sink) dds_set_log_sink;
  decltype(&::dds_get_matched_publications) dds_get_matched_publications;
  decltype(&::dds_get_matched_subscriptions) dds_get_matched_subscriptions;
  decltype(&::ddsi_sertype_v0) ddsi_sertype_v0;
  decltype(&::ddsi_sertype_init) ddsi_sertype_init;
  decltype(&::ddsi_sertype_fini) ddsi_sertype_fini;
  decltype(&::ddsi_serdata_init) ddsi_serdata_init;
};

/// Loads the library once; it stays. Throws ConfigError, naming the package to install, where it is not there or is of
/// another version than the headers that we were compiled with.
const Library& library();

/// The value, or ConnectionError with what Cyclone DDS could not do where it is an error.
std::int32_t checked(std::int32_t value, std::string_view what);

}  // namespace threewe::ros2
