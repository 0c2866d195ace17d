// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace ndg {

/// Progress with rate and time left: a bar where stderr is a terminal, a plain line every few seconds where not.
/// `advance` may be called from several threads.
class Progress {
public:
    Progress(std::string task, std::size_t total);
    ~Progress();
    void advance(std::size_t count = 1);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
