#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::tools {

/// A script for sbatch: an array of `parts` jobs, each of which runs `prehend sweep WORDS --part
/// K/N` in the present folder with one worker a processor that Slurm gives it, and prints to
/// LOGS/K.txt. `name` is the jobs' name.
std::string slurm_array(int parts, const std::string& name, const std::vector<std::string>& words,
                        const std::filesystem::path& logs);

}  // namespace prehend::tools
