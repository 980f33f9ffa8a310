# Cyclone DDS's headers, from Debian's package cyclonedds-dev: the backend `real` is compiled where they are. Its library
# is not linked but loaded when a world is made, so that ours runs without. Both must be of one version, since we fill in
# structs of Cyclone's.
set(THREEWE_ROS2_FOLDERS)
find_path(THREEWE_CYCLONEDDS_INCLUDE_DIR dds/ddsi/ddsi_sertype.h)
if(THREEWE_CYCLONEDDS_INCLUDE_DIR)
  list(APPEND THREEWE_ROS2_FOLDERS dds)
else()
  message(STATUS "Cyclone DDS's headers not found, the backend 'real' is left out: apt install cyclonedds-dev")
endif()

# libjpeg-turbo's header, from Debian's package libturbojpeg0-dev, for pictures that come compressed; loaded likewise.
find_path(THREEWE_TURBOJPEG_INCLUDE_DIR turbojpeg.h)

# Gives a target the headers, and tells it what is compiled.
function(threewe_use_ros2_libraries target)
  if(THREEWE_TURBOJPEG_INCLUDE_DIR)
    target_include_directories(${target} SYSTEM PRIVATE "${THREEWE_TURBOJPEG_INCLUDE_DIR}")
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_TURBOJPEG=1)
    target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  else()
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_TURBOJPEG=0)
  endif()
  if("dds" IN_LIST THREEWE_ROS2_FOLDERS)
    target_include_directories(${target} SYSTEM PRIVATE "${THREEWE_CYCLONEDDS_INCLUDE_DIR}")
    # as Debian compiled the library: it changes structs
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_CYCLONEDDS=1 DDS_NDEBUG)
    target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  else()
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_CYCLONEDDS=0)
  endif()
endfunction()
