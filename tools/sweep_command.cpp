#include <memory>

#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/programs.h"
#include "tools/sweep/choices.h"

namespace prehend::tools {

// A program of its own, as only who asks pays for loading SQLite.
void add_sweep_command(CLI::App& app) {
  auto choices = std::make_shared<SweepChoices>();
  CLI::App* command = app.add_subcommand(
      "sweep",
      "Run a program for every combination of its options that a file describes, on this machine, "
      "as a Slurm array or over ranks of MPI; keep the results, go on where it ended, make one "
      "table of them");
  add_sweep_options(*command, *choices);
  command->footer(
      "Examples:\n"
      "  prehend sweep my_sweep.yaml --out my_sweep --export my_sweep.csv\n"
      "  prehend sweep my_sweep.yaml --out my_sweep --again failed\n"
      "  prehend sweep my_sweep.yaml --out my_sweep --slurm 16   # then: sbatch my_sweep/array.sh\n"
      "  mpirun -n 17 prehend sweep my_sweep.yaml --out my_sweep --mpi\n"
      "  prehend sweep my_sweep.yaml --out my_sweep --status\n"
      "  prehend sweep my_sweep.yaml --out my_sweep --merge --export my_sweep.csv");
  // The options write to the choices, which have to live as long.
  command->callback([command, choices] { become_program("sweep", given_words(*command)); });
}

}  // namespace prehend::tools
