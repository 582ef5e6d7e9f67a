#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// What attempts and looks before made of objects that were seen again: each as it was predicted
/// and as it is believed, with the places where it was touched; or why nothing was made of them.
void add_beliefs(report::Page& page, const Collected& collected);

/// What looks in the hand made of a prediction, after each of them. @pre there are some
void add_held(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
