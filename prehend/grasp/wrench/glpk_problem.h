#pragma once

#include <glpk.h>

#include <memory>

namespace prehend::grasp {

struct GlpkDeleter {
  void operator()(glp_prob* problem) const { glp_delete_prob(problem); }
};

/// A linear programme of GLPK.
using GlpkProblem = std::unique_ptr<glp_prob, GlpkDeleter>;

/// An empty programme. GLPK keeps memory for each thread that uses it, which is freed at the
/// thread's end: programmes must not outlive the thread that made them.
inline GlpkProblem make_glpk_problem() {
  struct OfThisThread {
    ~OfThisThread() { glp_free_env(); }
  };
  static thread_local const OfThisThread of_this_thread;
  static_cast<void>(of_this_thread);
  return GlpkProblem(glp_create_prob());
}

}  // namespace prehend::grasp
