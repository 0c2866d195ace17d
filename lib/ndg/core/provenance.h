// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

/// Project version and git commit this binary was built from ("unknown" outside a checkout).
std::string project_version();
std::string project_commit();

/// Where a file came from; stored as attributes in every output.
struct Provenance {
    struct Input {
        std::string path;
        std::string sha256;
        std::string licences;  ///< licence and credit lines carried over from the input; empty if none
    };
    std::string tool;                ///< executable name
    std::string config_json = "{}";  ///< resolved parameters of the tool
    std::vector<Input> inputs;
    std::string licences;  ///< licence and credit lines of data this tool brought in itself
};

}  // namespace ndg
