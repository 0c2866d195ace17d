// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/viewer_bundle.h"

// The assembler copies the file into the object: no generated source of half a megabyte, no file to find at run time.
asm(".pushsection .rodata\n"
    "ndg_viewer_bundle_begin:\n"
    ".incbin \"" NDG_VIEWER_BUNDLE
    "\"\n"
    "ndg_viewer_bundle_end:\n"
    ".popsection\n");

extern "C" const char ndg_viewer_bundle_begin[], ndg_viewer_bundle_end[];

namespace ndg {

std::string_view viewer_bundle()
{
    return {ndg_viewer_bundle_begin, std::size_t(ndg_viewer_bundle_end - ndg_viewer_bundle_begin)};
}

}  // namespace ndg
