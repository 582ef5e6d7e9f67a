#include "tools/sweep/choices.h"
#include "prehend/text/command_line.h"

namespace prehend::tools {

void add_sweep_options(CLI::App& app, SweepChoices& choices) {
  app.add_option("file", choices.file, "Description of the cases (YAML, docs/sweeps.md)")
      ->required();
  CLI::Option* out = app.add_option(
      "--out", choices.out,
      "Folder of results.db and of what cases write; what is there is not run again");
  CLI::Option* workers =
      app.add_option("--workers", choices.workers, "Cases at a time; 0: one a processor")
          ->check(text::in_range(0, 10000))
          ->capture_default_str();
  app.add_option("--only", choices.only, "Cases whose names match, 'object=mug,*'");
  CLI::Option* again =
      app.add_option("--again", choices.again,
                     "Run these once more and no others: failed, all, or names as for --only");
  app.add_option("--costs", choices.costs,
                 "Folder of an earlier sweep: how long its cases took says which begin first");
  CLI::Option* part = app.add_option("--part", choices.part,
                                     "K/N: the cases of part K of N, with results of its own, 1/8");
  CLI::Option* slurm =
      app.add_option("--slurm", choices.slurm,
                     "Run nothing; write OUT/array.sh, a Slurm array of so many parts")
          ->check(text::in_range(1, 100000));
  CLI::Option* mpi =
      app.add_flag("--mpi", choices.mpi,
                   "Under mpirun or srun: the first rank hands out, each other runs a case at a "
                   "time");
  app.add_option("--lost-after", choices.lost_after,
                 "Seconds of a rank's silence after which another gets its case")
      ->check(text::in_range(2.0, 86400.0))
      ->capture_default_str()
      ->needs(mpi);
  CLI::Option* merge = app.add_flag("--merge", choices.merge,
                                    "Run nothing; take the results of parts into results.db");
  CLI::Option* status =
      app.add_flag("--status", choices.status, "Run nothing; say what is done and what failed");
  CLI::Option* list = app.add_flag("--list", choices.list, "Run nothing; print the cases' names");
  app.add_option("--export", choices.export_file,
                 "Write the table of all results, FILE.csv or FILE.h5 (HDF5), after what runs");
  app.add_option("--export-costs", choices.export_costs,
                 "Write how long each case took, FILE.csv, after what runs");
  part->excludes(slurm)->excludes(merge)->excludes(again);
  slurm->excludes(merge)->excludes(status)->needs(out);
  status->excludes(again)->excludes(merge)->excludes(part);
  list->excludes(again);
  mpi->needs(out)->excludes(workers)->excludes(part)->excludes(slurm);
  mpi->excludes(merge)->excludes(status)->excludes(list);
}

}  // namespace prehend::tools
