#include "nodes/grasp_cycle/cycle_node.h"
#include "prehend/graph/node.h"

int main(int argc, char** argv) {
  int exit_code = 0;
  const int run_code = prehend::graph::run_node(
      argc, argv,
      {"grasp_cycle",
       "Executes the best planned grasp: approach, grasp by touch, lift, move, release. Publishes "
       "what was predicted against what was felt (/surprise), where it is (/cycle/state) and how "
       "it ended (/cycle/result). The service /cycle/start starts again on the newest plans. "
       "With exit_when_done it exits 0 on success, 2 on failure, 3 when nothing can be grasped."},
      [&exit_code](prehend::graph::Node& node) {
        prehend::nodes::CycleNode cycle(node);
        node.spin();
        exit_code = cycle.exit_code();
      });
  return run_code != 0 ? run_code : exit_code;
}
