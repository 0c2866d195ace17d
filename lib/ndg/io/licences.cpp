// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/licences.h"

#include "ndg/io/h5_handles.h"

#include <algorithm>
#include <sstream>
#include <vector>

namespace ndg {

std::string merge_licences(const Provenance& provenance)
{
    std::vector<std::string> lines;
    const auto add = [&lines](const std::string& text) {
        std::istringstream stream(text);
        for (std::string line; std::getline(stream, line);) {
            if (!line.empty() && std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
        }
    };
    add(provenance.licences);
    for (const Provenance::Input& input : provenance.inputs) {
        std::string licences = input.licences;
        if (licences.empty() && h5::is_h5(input.path)) {
            const h5::Handle file = h5::open_file(input.path);
            h5::read_text_attribute(file, input.path, "licences", licences);
        }
        add(licences);
    }
    std::string merged;
    for (const std::string& line : lines) merged += (merged.empty() ? "" : "\n") + line;
    return merged;
}

}  // namespace ndg
