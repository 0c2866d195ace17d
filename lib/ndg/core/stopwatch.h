// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ndg {

/// Processor time this thread has used, in seconds: other work on the machine does not count.
double thread_seconds();

/// Adds the processor time of its life to a sum.
class Stopwatch {
public:
    explicit Stopwatch(double& sum) : sum_(sum), start_(thread_seconds()) {}
    ~Stopwatch() { sum_ += thread_seconds() - start_; }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    double& sum_;
    double start_;
};

}  // namespace ndg
