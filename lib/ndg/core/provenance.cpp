// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/provenance.h"

#include "ndg_commit.h"  // made by commit.cmake at build time

namespace ndg {

std::string project_version()
{
    return NDG_PROJECT_VERSION;
}

std::string project_commit()
{
    return NDG_PROJECT_COMMIT;
}

}  // namespace ndg
