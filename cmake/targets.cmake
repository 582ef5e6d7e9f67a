# How every target of prehend is declared, so that folders stay one call long.

add_library(prehend_compile_flags INTERFACE)
target_include_directories(prehend_compile_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(prehend_compile_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
# GCC 12 warns wrongly of uninitialised members of std::variant and std::optional when it inlines.
target_compile_options(prehend_compile_flags INTERFACE
                       $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
if(PREHEND_SANITIZE)
  target_compile_options(prehend_compile_flags INTERFACE
                         -fsanitize=${PREHEND_SANITIZE} -fno-omit-frame-pointer -g)
  target_link_options(prehend_compile_flags INTERFACE -fsanitize=${PREHEND_SANITIZE})
  # Eigen allocates differently under AddressSanitizer; memory that the installed PCL allocated
  # could not be freed here.
  target_compile_definitions(prehend_compile_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(PREHEND_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "PREHEND_BUILD_FUZZERS needs clang (apt install clang); use the preset fuzz")
  endif()
  # A finding of the undefined-behaviour sanitizer ends the program, so that libFuzzer keeps it.
  target_compile_options(prehend_compile_flags INTERFACE
                         -fsanitize=fuzzer-no-link -fno-sanitize-recover=all)
  target_link_options(prehend_compile_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# prehend_library(NAME SOURCES a.cpp b.cpp DEPENDS prehend::geometry ... [PRIVATE_DEPENDS ...])
# Declares the static library prehend_NAME with the alias prehend::NAME.
function(prehend_library NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(prehend_${NAME} STATIC ${ARG_SOURCES})
  add_library(prehend::${NAME} ALIAS prehend_${NAME})
  target_link_libraries(prehend_${NAME} PUBLIC prehend_compile_flags ${ARG_DEPENDS}
                                        PRIVATE ${ARG_PRIVATE_DEPENDS})
endfunction()

# prehend_program(NAME SOURCES a.cpp DEPENDS ...): an executable build/bin/NAME.
function(prehend_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE prehend_compile_flags ${ARG_DEPENDS})
endfunction()

# prehend_node(NAME SOURCES main.cpp ... DEPENDS ...)
# A node's program (it has a RegisteredNodeProgram NAME): an executable build/bin/NAME, and objects
# that the container links too.
function(prehend_node NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(prehend_node_${NAME} OBJECT ${ARG_SOURCES})
  target_link_libraries(prehend_node_${NAME} PUBLIC prehend_compile_flags ${ARG_DEPENDS})
  add_executable(${NAME} ${PROJECT_SOURCE_DIR}/nodes/node_main.cpp)
  target_link_libraries(${NAME} PRIVATE prehend_node_${NAME} prehend::graph)
  set_property(GLOBAL APPEND PROPERTY PREHEND_NODES prehend_node_${NAME})
endfunction()

# prehend_test(NAME SOURCES a_test.cpp DEPENDS ... [TIMEOUT seconds] [SERIAL])
# A GoogleTest program build/bin/test_NAME and one CTest test of the same name. Tests run with the
# source tree as working directory. Where the folder ../shared/data of real recordings exists, its
# path is in the environment variable PREHEND_SHARED_DATA. SERIAL: never beside another test.
function(prehend_test NAME)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(test_${NAME} ${ARG_SOURCES})
  target_link_libraries(test_${NAME} PRIVATE prehend_compile_flags ${ARG_DEPENDS}
                                             GTest::gtest GTest::gmock GTest::gtest_main)
  add_test(NAME ${NAME} COMMAND test_${NAME} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${NAME} PROPERTIES TIMEOUT ${ARG_TIMEOUT}
                       ENVIRONMENT "PREHEND_SHARED_DATA=${PREHEND_SHARED_DATA};PREHEND_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  if(ARG_SERIAL)
    set_tests_properties(${NAME} PROPERTIES RUN_SERIAL ON)
  endif()
endfunction()

set(PREHEND_SHARED_DATA "")
if(EXISTS ${PROJECT_SOURCE_DIR}/../shared/data/README.md)
  set(PREHEND_SHARED_DATA ${PROJECT_SOURCE_DIR}/../shared/data)
endif()
