# libprehend.so: all of prehend's library in one, for who links by pkg-config or wants to exchange it. Only what is prehend's
# own (and the messages') is visible. Programs here link the static libraries that it is made of.

set(shared_objects)
set(shared_libraries)
foreach(folder msgs prehend)
  prehend_targets_below(targets ${PROJECT_SOURCE_DIR}/${folder})
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(is_left_out ${target} EXCLUDE_FROM_ALL)
    if(type STREQUAL STATIC_LIBRARY AND NOT is_left_out)
      list(APPEND shared_objects $<TARGET_OBJECTS:${target}>)
      list(APPEND shared_libraries ${target})
    endif()
  endforeach()
endforeach()

set(empty ${PROJECT_BINARY_DIR}/install/shared_library.cpp)
if(NOT EXISTS ${empty})
  file(WRITE ${empty} "")
endif()
add_library(prehend_shared SHARED ${empty} ${shared_objects})
# Of the archives nothing is left to take: they bring what they need of others.
target_link_libraries(prehend_shared PRIVATE prehend_compile_flags ${shared_libraries})
# gold shows what libstdc++ has, too, whatever the list says. The last one said is taken: as a library this is.
target_link_libraries(prehend_shared PRIVATE -fuse-ld=bfd)
target_link_options(prehend_shared PRIVATE
                    "-Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/install/visible_symbols.txt")
set_target_properties(prehend_shared PROPERTIES
  OUTPUT_NAME prehend
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/install/visible_symbols.txt)
