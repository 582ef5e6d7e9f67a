#pragma once

#include <glpk.h>

#include <memory>

namespace prehend::grasp {

struct GlpkDeleter {
  void operator()(glp_prob* problem) const { glp_delete_prob(problem); }
};

/// A linear programme of GLPK.
using GlpkProblem = std::unique_ptr<glp_prob, GlpkDeleter>;

}  // namespace prehend::grasp
