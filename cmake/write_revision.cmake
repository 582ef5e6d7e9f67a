# Writes the header OUT with the version and the revision of the checkout SOURCE; only when they have changed, so that
# nothing is compiled anew for it. Without git, or outside of a checkout, the revision is empty.
#   cmake -DSOURCE=... -DOUT=... -DVERSION=... -P write_revision.cmake
find_program(GIT git)
set(revision "")
if(GIT AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --exclude=*
                  OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
set(text "#pragma once

namespace prehend {

inline constexpr const char* kVersion = \"${VERSION}\";
inline constexpr const char* kRevision = \"${revision}\";  // empty: not known

}  // namespace prehend
")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
