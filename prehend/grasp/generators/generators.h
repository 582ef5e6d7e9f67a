#pragma once

// The generators that are built in, for generator_registry.cpp alone. Who calls owns.

#include "prehend/grasp/generators/generator.h"

namespace prehend::grasp {

CandidateGenerator* create_circles();
CandidateGenerator* create_segments();
CandidateGenerator* create_box_rays();
CandidateGenerator* create_antipodal();
CandidateGenerator* create_medial_axis();

}  // namespace prehend::grasp
