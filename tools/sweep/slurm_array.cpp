#include "tools/sweep/slurm_array.h"

#include <fmt/format.h>

#include "tools/programs.h"
#include "tools/sweep/case_program.h"

namespace prehend::tools {

std::string slurm_array(int parts, const std::string& name, const std::vector<std::string>& words,
                        const std::filesystem::path& logs) {
  std::string command = shell_word(program_folder() + "/prehend") + " sweep";
  for (const std::string& word : words) command += " " + shell_word(word);
  return fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name={name}\n"
      "#SBATCH --array=1-{parts}\n"
      "#SBATCH --output={logs}/%a.txt\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --requeue\n"
      "# Options of sbatch go before this file: sbatch --cpus-per-task=8 --time=2:00:00 FILE.\n"
      "# Submitted again, each part goes on where it ended.\n"
      "cd {here} || exit 1\n"
      "exec {command} --workers=${{SLURM_CPUS_PER_TASK:-1}} --part=$SLURM_ARRAY_TASK_ID/{parts}\n",
      fmt::arg("name", name), fmt::arg("parts", parts), fmt::arg("logs", logs.string()),
      fmt::arg("here", shell_word(std::filesystem::current_path().string())),
      fmt::arg("command", command));
}

}  // namespace prehend::tools
