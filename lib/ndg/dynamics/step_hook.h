// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/simulation/newton.h"

namespace ndg {

/// Where a body is and how it moves.
struct DynamicState {
    Points positions;   ///< N_v x 3, world, m
    Points velocities;  ///< N_v x 3, m/s
};

/// What takes part in steps beside energies that are always there, as contact does: elements that come and go, ways
/// that are not free. What it does may depend on nothing but what it is given, so that a run that goes on from a stored
/// state is the same.
class StepHook {
public:
    virtual ~StepHook() = default;

    /// Before the step that begins at `state` and ends `time_step` later, at `end_time`, s. `start`: N_v x 3, where
    /// Newton's method will begin; held vertices are where they go. May move the others.
    virtual void begin_step(const DynamicState& state, double end_time, double time_step, Points& start) = 0;
    /// Before every round of Newton's method: chooses its elements. True where those of a term have changed.
    virtual bool choose_elements(const Points& positions) = 0;
    /// For the round. Empty: all ways are free.
    virtual StepFilter filter() = 0;
    /// After a round. True asks for another.
    virtual bool goes_on(const Points& positions, const NewtonResult& round) = 0;
};

}  // namespace ndg
