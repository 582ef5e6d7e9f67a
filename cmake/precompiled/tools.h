// What the prehend command's files include: messages, the graph from outside, command lines.
#include "cmake/precompiled/messages.h"

#include <CLI/CLI.hpp>

#include "prehend/graph/introspection.h"
