# What `cmake --install` puts where, and the package that find_package(prehend) finds. Below the prefix:
#
#   bin/prehend                     the command, a link
#   lib/prehend/bin                 the programs, beside each other as they look for each other
#   lib/prehend/lib                 plug-ins: physics engines, the emulated camera's OpenNI2 driver
#   lib/prehend/config, launch, web links to share/prehend, where programs look for their defaults
#   share/prehend                   launch files, robots, scenes, tasks, measured fronts, the viewer's page
#   include/prehend, lib/prehend/archives, lib/cmake/prehend   the library, for find_package
#   lib/libprehend.so.*, lib/pkgconfig/prehend.pc              the same in one, for pkg-config
#   share/doc/prehend/html          the documentation site, once `make docs` has made it
#
# Components: programs, ros1, ros2, library, development, documentation, python.

include(CMakePackageConfigHelpers)

set(INSTALLED_TREE lib/prehend)

# prehend_targets_below(VARIABLE FOLDER): all targets declared there and below.
function(prehend_targets_below VARIABLE FOLDER)
  get_property(targets DIRECTORY ${FOLDER} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${FOLDER} PROPERTY SUBDIRECTORIES)
  foreach(folder ${folders})
    prehend_targets_below(below ${folder})
    list(APPEND targets ${below})
  endforeach()
  set(${VARIABLE} ${targets} PARENT_SCOPE)
endfunction()

if(NOT PREHEND_SANITIZE AND NOT PREHEND_BUILD_FUZZERS)
  include(cmake/shared_library.cmake)
  install(TARGETS prehend_shared LIBRARY DESTINATION lib COMPONENT library
          NAMELINK_COMPONENT development)
  configure_file(cmake/install/prehend.pc.in ${PROJECT_BINARY_DIR}/install/prehend.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/install/prehend.pc DESTINATION lib/pkgconfig
          COMPONENT development)
endif()

# What needs ROS's libraries is apart, so that nothing else does.
set(ONLY_IN_PROGRAMS prehend_ros_dds prehend_ros_roscpp)

install(TARGETS prehend_compile_flags EXPORT prehend)
foreach(folder msgs prehend drivers nodes tools)
  prehend_targets_below(targets ${PROJECT_SOURCE_DIR}/${folder})
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(is_left_out ${target} EXCLUDE_FROM_ALL)
    if(is_left_out)
      continue()
    endif()
    if(type STREQUAL EXECUTABLE)
      set(component programs)
      if(target MATCHES "^(ros[12])_")
        set(component ${CMAKE_MATCH_1})
      endif()
      set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib/openni2")
      install(TARGETS ${target} RUNTIME DESTINATION ${INSTALLED_TREE}/bin COMPONENT ${component})
    elseif(type STREQUAL MODULE_LIBRARY)
      get_target_property(place ${target} LIBRARY_OUTPUT_DIRECTORY)
      file(RELATIVE_PATH place ${CMAKE_BINARY_DIR} ${place})
      install(TARGETS ${target} LIBRARY DESTINATION ${INSTALLED_TREE}/${place} COMPONENT programs)
    elseif(type STREQUAL STATIC_LIBRARY AND NOT target IN_LIST ONLY_IN_PROGRAMS)
      string(REGEX REPLACE "^prehend_" "" name ${target})
      set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
      install(TARGETS ${target} EXPORT prehend
              ARCHIVE DESTINATION ${INSTALLED_TREE}/archives COMPONENT development)
    endif()
  endforeach()
endforeach()

# OpenNI2's library and drivers, as links, beside our driver.
install(DIRECTORY ${CMAKE_BINARY_DIR}/lib/openni2/ DESTINATION ${INSTALLED_TREE}/lib/openni2
        COMPONENT programs PATTERN "libPrehendCamera*" EXCLUDE)
install(DIRECTORY config launch DESTINATION share/prehend COMPONENT programs)
install(DIRECTORY tools/blender DESTINATION share/prehend COMPONENT programs
        PATTERN __pycache__ EXCLUDE)
install(DIRECTORY web/dist DESTINATION share/prehend/web COMPONENT programs)
install(CODE "
  set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
  file(MAKE_DIRECTORY \"\${prefix}/bin\" \"\${prefix}/${INSTALLED_TREE}\")
  file(CREATE_LINK ../${INSTALLED_TREE}/bin/prehend \"\${prefix}/bin/prehend\" SYMBOLIC)
  foreach(folder config launch web)
    file(CREATE_LINK ../../share/prehend/\${folder} \"\${prefix}/${INSTALLED_TREE}/\${folder}\" SYMBOLIC)
  endforeach()" COMPONENT programs)

foreach(folder prehend drivers msgs)
  install(DIRECTORY ${folder} DESTINATION include/prehend COMPONENT development
          FILES_MATCHING PATTERN "*.h" PATTERN "*.proto" PATTERN example EXCLUDE
          PATTERN json_record.h EXCLUDE)  # needs nlohmann's JSON, and is within the library alone
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/msgs/generated/msgs
                  ${PROJECT_BINARY_DIR}/msgs/foxglove/generated/foxglove
        DESTINATION include/prehend COMPONENT development FILES_MATCHING PATTERN "*.h")
set(PACKAGE_FOLDER lib/cmake/prehend)
install(EXPORT prehend NAMESPACE prehend:: DESTINATION ${PACKAGE_FOLDER} FILE targets.cmake
        COMPONENT development)
install(FILES cmake/dependencies.cmake cmake/install/prehend_node.cmake nodes/node_main.cpp
        DESTINATION ${PACKAGE_FOLDER} COMPONENT development)
configure_package_config_file(cmake/install/prehend-config.cmake.in
                              ${PROJECT_BINARY_DIR}/install/prehend-config.cmake
                              INSTALL_DESTINATION ${PACKAGE_FOLDER})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/install/prehend-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/install/prehend-config.cmake
              ${PROJECT_BINARY_DIR}/install/prehend-config-version.cmake
        DESTINATION ${PACKAGE_FOLDER} COMPONENT development)

install(DIRECTORY ${PROJECT_BINARY_DIR}/documentation_site/html DESTINATION share/doc/prehend
        COMPONENT documentation OPTIONAL)

# Debian packages: `make packages`, or `cpack -G DEB` in the build tree.
file(STRINGS apt-packages.txt development_packages REGEX "-dev$")
list(FILTER development_packages EXCLUDE REGEX
     "gtest|gmock|benchmark|mpi-dev|pybind11|python3|cyclonedds|roscpp|topic-tools|fastrtps|fastcdr")
list(JOIN development_packages ", " development_packages)
set(CPACK_PACKAGE_NAME prehend)
set(CPACK_PACKAGE_VENDOR "the prehend developers")
set(CPACK_PACKAGE_CONTACT "the prehend developers <prehend@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs library development)
if(EXISTS ${PROJECT_BINARY_DIR}/documentation_site/html)
  list(APPEND CPACK_COMPONENTS_ALL documentation)
endif()
foreach(version 1 2)
  if(TARGET ros${version}_bridge)
    list(APPEND CPACK_COMPONENTS_ALL ros${version})
    set(CPACK_DEBIAN_ROS${version}_PACKAGE_NAME prehend-ros${version})
    set(CPACK_DEBIAN_ROS${version}_PACKAGE_SHLIBDEPS ON)
    set(CPACK_DEBIAN_ROS${version}_PACKAGE_DEPENDS prehend)
  endif()
endforeach()
if(TARGET prehend_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-prehend)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "prehend, python3, python3-numpy")
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME prehend)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "gnuplot-nox, graphviz, fonts-dejavu-core")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libprehend${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_NAME prehend-doc)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libprehend-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${CPACK_DEBIAN_LIBRARY_PACKAGE_NAME}, g++, cmake, pkg-config, ${development_packages}")
include(CPack)
