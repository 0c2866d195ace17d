# SPDX-License-Identifier: Apache-2.0
# Run at build time: writes OUTPUT, a header with the project version and the git commit of SOURCE ("unknown" outside a
# checkout), and touches it only when the content changes.
set(commit "unknown")
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE}/.git)
  set(ENV{GIT_OPTIONAL_LOCKS} 0)  # a build must not get in the way of a commit
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                  OUTPUT_VARIABLE described ERROR_QUIET RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed AND described)
    set(commit ${described})
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[
// SPDX-License-Identifier: Apache-2.0
#pragma once
#define NDG_PROJECT_VERSION "@VERSION@"
#define NDG_PROJECT_COMMIT "@commit@"
]] @ONLY)
