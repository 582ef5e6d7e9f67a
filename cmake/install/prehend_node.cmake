# prehend_node(NAME SOURCES a.cpp ... DEPENDS prehend::msgs ...): the program of a node of one's own, that
# has a RegisteredNodeProgram NAME. Launch files find it in the folders of PREHEND_NODE_PATH.
function(prehend_node NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES} ${prehend_DIR}/node_main.cpp)
  target_link_libraries(${NAME} PRIVATE prehend::graph ${ARG_DEPENDS})
endfunction()
