#pragma once

#include <exception>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "prehend/graph/node.h"

namespace prehend::graph {

/// A kind of node that can be run: alone as a program of its own, or with others in one process
/// (see run_container). `run` must keep nothing in global variables: it may run several times at
/// once.
struct NodeProgram {
  NodeDescription description;
  /// Sets the node up, spins it, and returns the exit code.
  std::function<int(Node&)> run;
  /// True: SIGINT and SIGTERM do not shut the node down, `run` looks at stop_requested() (see
  /// stop_signals.h) and ends in its own time.
  bool stops_itself = false;
};

/// One at namespace scope makes a program known under its description's name:
///
///     const graph::RegisteredNodeProgram registered({"shape_completion", "Predicts ..."}, run);
///
/// `run`: takes a Node&, returns nothing or the exit code.
class RegisteredNodeProgram {
 public:
  template <class Run>
  RegisteredNodeProgram(NodeDescription description, Run run, bool stops_itself = false) {
    NodeProgram program{std::move(description), {}, stops_itself};
    if constexpr (std::is_void_v<std::invoke_result_t<Run, Node&>>) {
      program.run = [run = std::move(run)](Node& node) {
        run(node);
        return 0;
      };
    } else {
      program.run = std::move(run);
    }
    add(std::move(program));
  }

 private:
  static void add(NodeProgram program);
};

/// Exit code of a node that refuses its parameters, or a file they name: to start it again as it is
/// mends nothing.
inline constexpr int kWrongInput = 2;

/// Exit code of a node that has done its work and whose answer is no, e.g. that nothing can be
/// grasped: no success, and no failure either. It is that of the launch which such a node ends.
inline constexpr int kAnswerIsNo = 3;

/// Prints a node's last words, one line, and returns its exit code: kWrongInput for
/// text::InputError and std::invalid_argument, else 1.
int report_end(const std::string& node, const std::exception& error);

/// All that are linked into this process, sorted by name.
std::vector<const NodeProgram*> node_programs();

/// The main function of a node's program; see run_node for its command line. Exit code: that of
/// `run`, or as report_end says.
int run_program(int argc, char** argv, const NodeProgram& program);

/// The main function of a program that runs any of node_programs() in one process:
///
///     container -- shape_completion --name a --param shifts:=40 -- poisson_meshing ...
///
/// Each node has a thread and the command line of a program of its own. Ends when all nodes have
/// ended, with 0; when one fails, its error line names it, all others are shut down, and its exit
/// code is the process'. SIGINT and SIGTERM shut all down; a second one kills.
/// `--help` lists the programs, `--list` gives their names alone.
int run_container(int argc, char** argv);

}  // namespace prehend::graph
