// Any nodes of this folder in one process. See run_container.

#include "prehend/graph/node_program.h"

int main(int argc, char** argv) { return prehend::graph::run_container(argc, argv); }
