#pragma once

// The generators that generator.h names, for generator.cpp alone.

#include <memory>

#include "prehend/grasp/generators/generator.h"

namespace prehend::grasp {

std::unique_ptr<CandidateGenerator> make_circles(const GeneratorOptions& options);
std::unique_ptr<CandidateGenerator> make_segments(const GeneratorOptions& options);
std::unique_ptr<CandidateGenerator> make_box_rays(const GeneratorOptions& options);
std::unique_ptr<CandidateGenerator> make_antipodal(const GeneratorOptions& options);
std::unique_ptr<CandidateGenerator> make_medial_axis(const GeneratorOptions& options);

}  // namespace prehend::grasp
