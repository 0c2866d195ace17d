// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/provenance.h"

#include "ndg/core/hash.h"

#include <fmt/ranges.h>

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

std::vector<std::string> data_hashes(const Provenance& provenance)
{
    std::vector<std::string> hashes;
    for (const Provenance::Input& input : provenance.inputs) {
        if (!input.is_config) hashes.push_back(input.sha256);
    }
    return hashes;
}

std::string run_key(const std::string& method, int version, const std::string& options_key,
                    const std::vector<std::string>& input_sha256)
{
    return sha256(fmt::format("{} {}\n{}\n{}", method, version, options_key, fmt::join(input_sha256, "\n")));
}

}  // namespace ndg
