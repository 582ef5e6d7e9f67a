# How every target of prehend is declared, so that folders stay one call long.

add_library(prehend_compile_flags INTERFACE)
# Others who link the installed library get its headers and the language, not its warnings.
target_include_directories(prehend_compile_flags INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                           $<INSTALL_INTERFACE:include/prehend>)
target_compile_features(prehend_compile_flags INTERFACE cxx_std_20)
target_compile_options(prehend_compile_flags INTERFACE
                       "$<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic;-Wshadow>")
# GCC 12 warns wrongly, when it inlines, of uninitialised members of std::variant and std::optional
# (bug 105562) and of copies beyond the ends of std::string (bug 105651).
target_compile_options(prehend_compile_flags INTERFACE
                       "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-restrict>>")
if(PREHEND_FAST_BUILD)
  # In a batch, a .cpp's own types look to GCC as if a header had them.
  target_compile_options(prehend_compile_flags INTERFACE
                         $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>>)
endif()
# Messages of failed tests name files as seen from the source tree.
target_compile_options(prehend_compile_flags INTERFACE
                       "$<BUILD_INTERFACE:-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=>")
# There are some 250 programs: gold (of binutils) links each in a fifth of the time.
include(CheckLinkerFlag)
check_linker_flag(CXX -fuse-ld=gold PREHEND_HAS_GOLD)
if(PREHEND_HAS_GOLD)
  target_link_options(prehend_compile_flags INTERFACE $<BUILD_INTERFACE:-fuse-ld=gold>)
endif()
if(PREHEND_SANITIZE)
  target_compile_options(prehend_compile_flags INTERFACE
                         -fsanitize=${PREHEND_SANITIZE} -fno-sanitize-recover=all
                         -fno-omit-frame-pointer -O1 -g1)  # -O0 takes Eigen ten times as long
  target_link_options(prehend_compile_flags INTERFACE -fsanitize=${PREHEND_SANITIZE})
  # protobuf's headers give maps other members under ThreadSanitizer than the installed library has.
  target_compile_options(prehend_compile_flags INTERFACE -U__SANITIZE_THREAD__)
  if(PREHEND_SANITIZE MATCHES thread)
    # What libstdc++ derives from it: without, it counts references in a way that looks like a race.
    target_compile_definitions(prehend_compile_flags INTERFACE _GLIBCXX_TSAN=1)
  endif()
  # Eigen allocates differently under AddressSanitizer; memory that the installed PCL allocated
  # could not be freed here.
  target_compile_definitions(prehend_compile_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(PREHEND_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "PREHEND_BUILD_FUZZERS needs clang (apt install clang); use the preset fuzz")
  endif()
  target_compile_options(prehend_compile_flags INTERFACE
                         -fsanitize=fuzzer-no-link)
  target_link_options(prehend_compile_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Two thirds of compiling is reading headers and instantiating their templates. So the files of a
# target are compiled in batches, and what nearly all files of a subject include is compiled once.
# Each file must still include what it uses: PREHEND_FAST_BUILD=OFF builds file by file.

# prehend_precompile(SUBJECT DEPENDS ...): cmake/precompiled/SUBJECT.h, compiled once.
function(prehend_precompile SUBJECT)
  cmake_parse_arguments(ARG "" "" "DEPENDS;OPTIONS" ${ARGN})
  if(PREHEND_FAST_BUILD)
    set(empty ${CMAKE_BINARY_DIR}/precompiled/${SUBJECT}.cpp)
    if(NOT EXISTS ${empty})
      file(WRITE ${empty} "")
    endif()
    add_library(prehend_precompiled_${SUBJECT} OBJECT ${empty})
    target_link_libraries(prehend_precompiled_${SUBJECT} PRIVATE prehend_compile_flags ${ARG_DEPENDS})
    target_compile_options(prehend_precompiled_${SUBJECT} PRIVATE ${ARG_OPTIONS})
    target_precompile_headers(prehend_precompiled_${SUBJECT}
                              PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled/${SUBJECT}.h)
  endif()
endfunction()

# For code of which nothing waits: tests, command lines.
if(CMAKE_BUILD_TYPE STREQUAL Release)
  set(PREHEND_QUICK_COMPILING -O1)
endif()

# prehend_build_fast(TARGET SUBJECT): with that precompiled header, none where it is empty. A batch
# has PREHEND_BATCH files: more build faster at first, fewer after a change. A file that includes
# itself again for each vector instruction set (hwy/foreach_target.h) stands alone.
set(PREHEND_BATCH 4 CACHE INTERNAL "Files of a batch")
function(prehend_build_fast TARGET SUBJECT)
  if(NOT PREHEND_FAST_BUILD)
    return()
  endif()
  set_target_properties(${TARGET} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${PREHEND_BATCH})
  get_target_property(sources ${TARGET} SOURCES)
  foreach(source ${sources})
    get_filename_component(file ${source} ABSOLUTE)
    file(STRINGS ${file} again REGEX "hwy/foreach_target.h")
    if(again)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  if(SUBJECT)
    target_precompile_headers(${TARGET} REUSE_FROM prehend_precompiled_${SUBJECT})
  endif()
endfunction()

# prehend_library(NAME SOURCES a.cpp b.cpp DEPENDS prehend::geometry ... [PRIVATE_DEPENDS ...])
# Declares the static library prehend_NAME with the alias prehend::NAME. The variable
# PREHEND_PRECOMPILED of a folder names the precompiled header of its targets.
function(prehend_library NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(prehend_${NAME} STATIC ${ARG_SOURCES})
  add_library(prehend::${NAME} ALIAS prehend_${NAME})
  target_link_libraries(prehend_${NAME} PUBLIC prehend_compile_flags ${ARG_DEPENDS}
                                        PRIVATE ${ARG_PRIVATE_DEPENDS})
  prehend_build_fast(prehend_${NAME} "${PREHEND_PRECOMPILED}")
endfunction()

# prehend_program(NAME SOURCES a.cpp DEPENDS ...): an executable build/bin/NAME.
function(prehend_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE prehend_compile_flags ${ARG_DEPENDS})
  prehend_build_fast(${NAME} "${PREHEND_PRECOMPILED}")
endfunction()

# prehend_node(NAME [ALONE] SOURCES main.cpp ... DEPENDS ...)
# A node's program (it has a RegisteredNodeProgram NAME): an executable build/bin/NAME, and objects
# that the container links too, unless it is ALONE, as its libraries take long to load. In a project
# that has prehend by add_subdirectory, the executable is where that project has its programs, and no
# container links it.
function(prehend_node NAME)
  cmake_parse_arguments(ARG "ALONE" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(prehend_node_${NAME} OBJECT ${ARG_SOURCES})
  target_link_libraries(prehend_node_${NAME} PUBLIC prehend_compile_flags ${ARG_DEPENDS})
  prehend_build_fast(prehend_node_${NAME} "${PREHEND_PRECOMPILED}")
  add_executable(${NAME} $<TARGET_OBJECTS:prehend_node_main>)
  target_link_libraries(${NAME} PRIVATE prehend_node_${NAME} prehend::graph)
  if(NOT ARG_ALONE)
    set_property(GLOBAL APPEND PROPERTY PREHEND_NODES prehend_node_${NAME})
  endif()
endfunction()

# A test of the list PREHEND_QUICK_TESTS gets the label quick, as its shards do, and the target
# quick_tests builds it.
add_custom_target(quick_tests)
function(prehend_quick_test NAME)
  if(NAME IN_LIST PREHEND_QUICK_TESTS)
    set(tests ${ARGN})
    if(NOT tests)
      set(tests ${NAME})
    endif()
    set_tests_properties(${tests} PROPERTIES LABELS quick)
    add_dependencies(quick_tests test_${NAME})
  endif()
endfunction()

# prehend_test(NAME SOURCES a_test.cpp DEPENDS ... [TIMEOUT seconds] [SHARDS n] [SERIAL] [REALTIME]
#              [LAUNCHES])
# A GoogleTest program build/bin/test_NAME and one CTest test of the same name. Tests run with the
# source tree as working directory. Where the folder ../shared/data of real recordings exists, its
# path is in the environment variable PREHEND_SHARED_DATA. SHARDS: n CTest tests NAME_1 ... NAME_n that
# share the program's cases, each with TIMEOUT of its own. Those with the longest begin first. SERIAL:
# never beside another test. LAUNCHES: whole graphs, which keep all processors busy: one such at a time.
# REALTIME: what it tests keeps pace with a clock (devices, emulators, leases), so that a machine that
# is held up can make it late: such tests run after all others, as many at a time as there are
# processors, and only they may run a second time.
function(prehend_test NAME)
  cmake_parse_arguments(ARG "SERIAL;REALTIME;LAUNCHES" "TIMEOUT;SHARDS" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set(cost ${ARG_TIMEOUT})
  if(PREHEND_SANITIZE)
    math(EXPR ARG_TIMEOUT "5 * ${ARG_TIMEOUT}")
  endif()
  add_executable(test_${NAME} ${ARG_SOURCES})
  target_link_libraries(test_${NAME} PRIVATE prehend_compile_flags ${ARG_DEPENDS} PkgConfig::EIGEN
                                             GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_options(test_${NAME} PRIVATE ${PREHEND_QUICK_COMPILING})
  prehend_build_fast(test_${NAME} tests)
  set(environment "PREHEND_SHARED_DATA=${PREHEND_SHARED_DATA}" "PREHEND_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY}"
                  "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/thread_sanitizer.supp")
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  set(tests "")
  foreach(shard RANGE 1 ${ARG_SHARDS})
    set(test ${NAME})
    set(share "")
    if(ARG_SHARDS GREATER 1)
      set(test ${NAME}_${shard})
      math(EXPR index "${shard} - 1")
      set(share "GTEST_TOTAL_SHARDS=${ARG_SHARDS}" "GTEST_SHARD_INDEX=${index}")
    endif()
    list(APPEND tests ${test})
    add_test(NAME ${test} COMMAND test_${NAME} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${test} PROPERTIES TIMEOUT ${ARG_TIMEOUT} COST ${cost}
                                             ENVIRONMENT "${environment};${share}")
    if(ARG_LAUNCHES)
      set_tests_properties(${test} PROPERTIES RESOURCE_LOCK launches)
    endif()
    if(ARG_SERIAL)
      set_tests_properties(${test} PROPERTIES RUN_SERIAL ON)
    endif()
    if(ARG_REALTIME)
      set_tests_properties(${test} PROPERTIES LABELS realtime)
    endif()
  endforeach()
  prehend_quick_test(${NAME} ${tests})
endfunction()

set(PREHEND_SHARED_DATA "")
if(EXISTS ${PROJECT_SOURCE_DIR}/../shared/data/README.md)
  set(PREHEND_SHARED_DATA ${PROJECT_SOURCE_DIR}/../shared/data)
endif()
