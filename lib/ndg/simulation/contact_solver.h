// SPDX-License-Identifier: Apache-2.0
// Equilibrium of a body whose skin keeps from itself: Newton's method on the energy with contact, in rounds between
// which the pairs of skin that can meet are found anew.
#pragma once

#include "ndg/body/template.h"
#include "ndg/elastic/contact_term.h"
#include "ndg/elastic/elastic_body.h"
#include "ndg/simulation/newton.h"

namespace ndg {

class ContactSolver {
public:
    /// Adds its term to `elastic`, to which it keeps a reference as to `body_template`; outside solve() the term has no
    /// elements.
    ContactSolver(const Template& body_template, ElasticBody& elastic, const ContactOptions& options);

    /// From an equilibrium without contact, reached as `result` tells, to one with it. Skin that crosses itself is
    /// untangled first; no step passes skin through skin. Pairs of triangles that untangling leaves crossed are left to
    /// pass. Up to twice as many iterations as `options` has are added to those of `result`, which keeps all else
    /// where no skin is near skin.
    void solve(Points& vertices, const NewtonOptions& options, NewtonResult& result);

private:
    const Template& template_;
    ElasticBody& elastic_;
    double distance_;
    Triangles skin_;  ///< among all vertices
    SurfaceParts parts_;
    ContactTerm* term_;
};

}  // namespace ndg
