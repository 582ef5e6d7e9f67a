// The main function of every program that is one node.

#include "prehend/graph/node_program.h"

int main(int argc, char** argv) {
  return prehend::graph::run_program(argc, argv, *prehend::graph::node_programs().at(0));
}
