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
        std::string licences;    ///< licence and credit lines carried over from the input; empty if none
        bool is_config = false;  ///< the config file, whose values are in config_json
    };
    std::string tool;                ///< executable name
    std::string config_json = "{}";  ///< resolved parameters of the tool
    std::vector<Input> inputs;
    std::string licences;  ///< licence and credit lines of data this tool brought in itself
};

/// SHA-256 of every input but the config file.
std::vector<std::string> data_hashes(const Provenance& provenance);

/// What the finished parts of a resumable run depend on alike, as one SHA-256: the method and its version, which is
/// raised by hand when the same options and inputs come to give something else; options_key of its options; hashes of
/// its inputs. The program's commit is no part of it: a rebuilt program goes on where the last one stopped.
std::string run_key(const std::string& method, int version, const std::string& options_key,
                    const std::vector<std::string>& input_sha256);

}  // namespace ndg
