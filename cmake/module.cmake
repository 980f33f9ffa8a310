# A module is src/<module>, with what users call of it in include/threewe/<module>, built as the library
# threewe_<module> of its own; libthreewe is all of their objects in one.

# What the sources include and nobody links: libraries that are headers alone.
find_package(Eigen3 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tl-expected REQUIRED)
set(THREEWE_INCLUDED Eigen3::Eigen nlohmann_json::nlohmann_json tl::expected)

# Defines the library of one module. Files are found by themselves, also in the named FOLDERS within the module; a module
# without sources is its headers. Its sources are compiled a few at a time (THREEWE_FAST_BUILD), except for those named ALONE,
# whose anonymous namespaces have names of others, and those that Highway compiles once for each vector target.
function(threewe_module module)
  cmake_parse_arguments(ARG "" "" "USES;FOLDERS;ALONE" ${ARGN})
  string(REPLACE "/" "_" name ${module})
  set(target threewe_${name})

  list(TRANSFORM ARG_FOLDERS REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/src/${module}/\\1/*.cpp" OUTPUT_VARIABLE folders)
  file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/${module}/*.cpp" ${folders})
  if(sources)
    add_library(${target} STATIC ${sources})
    target_link_libraries(${target} PRIVATE threewe_warnings)
    set(scope PUBLIC)
    set_property(GLOBAL APPEND PROPERTY threewe_objects $<TARGET_OBJECTS:${target}>)
    if(module STREQUAL "core")
      threewe_precompile(threewe_core)
    else()
      threewe_precompile(${target} REUSE_FROM threewe_core)
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ${THREEWE_FAST_BUILD} UNITY_BUILD_BATCH_SIZE 8)
    if(THREEWE_FAST_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU") # which takes sources for headers then
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
    foreach(source IN LISTS sources)
      cmake_path(GET source STEM stem)
      file(STRINGS "${source}" highway REGEX "define HWY_TARGET_INCLUDE")
      if(highway OR stem IN_LIST ARG_ALONE)
        set_source_files_properties("${source}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endforeach()
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()

  string(REPLACE "/" "_" uses "${ARG_USES}")
  list(TRANSFORM uses PREPEND threewe_)
  target_link_libraries(${target} ${scope} threewe_flags ${THREEWE_INCLUDED} ${THREEWE_LINKED} ${uses})
  set_property(GLOBAL APPEND PROPERTY threewe_modules ${module})
endfunction()

# Defines libthreewe and how it, its headers, its assets and its CMake package are installed. An outside project gets
# C++20 and the folder of the headers from it; what a static library links itself comes for the linker alone.
function(threewe_library)
  get_property(objects GLOBAL PROPERTY threewe_objects)
  add_library(threewe ${objects})
  add_library(threewe::threewe ALIAS threewe)
  set_target_properties(threewe PROPERTIES LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION})
  target_compile_features(threewe PUBLIC cxx_std_20)
  target_include_directories(threewe PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(threewe PRIVATE ${THREEWE_LINKED})

  # for programs of ours, which may include what is in src and are compiled as the library is
  add_library(threewe_inside INTERFACE)
  target_link_libraries(threewe_inside INTERFACE threewe threewe_flags ${THREEWE_INCLUDED} ${THREEWE_LINKED})

  # where assets are: in a wheel beside the module, while developing beside the sources, else where they are installed;
  # and as seen from the folders of libraries and of programs, for an installation that was moved
  set(assets "${CMAKE_INSTALL_FULL_DATADIR}/threewe/assets")
  file(RELATIVE_PATH from_library "${CMAKE_INSTALL_FULL_LIBDIR}" "${assets}")
  file(RELATIVE_PATH from_program "${CMAKE_INSTALL_FULL_BINDIR}" "${assets}")
  if(SKBUILD)
    set(assets "assets")
  elseif(THREEWE_DEVELOPER)
    set(assets "${PROJECT_SOURCE_DIR}/assets")
  endif()
  set_property(SOURCE "${PROJECT_SOURCE_DIR}/src/core/assets.cpp"
               PROPERTY COMPILE_DEFINITIONS "THREEWE_ASSET_DIR=\"${assets}\""
                        "THREEWE_ASSETS_FROM_LIBRARY=\"${from_library}\""
                        "THREEWE_ASSETS_FROM_PROGRAM=\"${from_program}\"")

  include(CMakePackageConfigHelpers)
  set(package "${CMAKE_INSTALL_LIBDIR}/cmake/threewe")
  write_basic_package_version_file(threewe-config-version.cmake COMPATIBILITY SameMinorVersion)
  get_target_property(kind threewe TYPE)
  configure_package_config_file(cmake/threewe-config.cmake.in threewe-config.cmake INSTALL_DESTINATION ${package}
                                PATH_VARS CMAKE_INSTALL_DATADIR NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  install(TARGETS threewe EXPORT threewe)
  install(EXPORT threewe DESTINATION ${package} NAMESPACE threewe:: FILE threewe-targets.cmake)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/threewe-config.cmake" "${PROJECT_SOURCE_DIR}/cmake/dependencies.cmake"
                "${CMAKE_CURRENT_BINARY_DIR}/threewe-config-version.cmake" DESTINATION ${package})
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/assets" DESTINATION ${CMAKE_INSTALL_DATADIR}/threewe OPTIONAL)
endfunction()
