// SPDX-License-Identifier: Apache-2.0
// Time steps of everything that can touch: obstacles that move as they are told, bodies, thrown solids, garments, all
// stacked in one array of vertices, the given ones first: [obstacles; held vertices; the rest]. Incremental potential
// contact (Li et al. 2020): a barrier keeps surfaces apart, no straight way that vertices go in Newton's method passes
// through a surface, and Coulomb friction acts with the forces of the step's start.
#pragma once

#include "ndg/dynamics/contact_anchors.h"
#include "ndg/dynamics/contact_surfaces.h"
#include "ndg/dynamics/step_hook.h"
#include "ndg/elastic/elastic_body.h"
#include "ndg/elastic/friction_term.h"

#include <utility>
#include <vector>

namespace ndg {

/// What the last step took.
struct ContactCounts {
    int rounds = 0;         ///< in which near pairs were found anew
    int anchor_solves = 0;  ///< to bring given vertices where they are to be through what they push
    int anchor_iterations = 0;
    int candidates = 0, elements = 0;  ///< pairs that could meet, and those in the energy, in the last round
    double search_seconds = 0;         ///< processor time of finding pairs
};

class ContactScene : public StepHook {
public:
    /// Adds its terms to `elastic`, to which it keeps a reference; other terms may be added until the first step. The
    /// rest shape is that of `elastic`, which is to be set afterwards. Throws Error for surfaces with a common vertex.
    ContactScene(ElasticBody& elastic, std::vector<ContactSurface> surfaces, const ContactSceneOptions& options);

    const std::vector<ContactSurface>& surfaces() const { return surfaces_; }

    /// Given vertices are brought where `start` has them: at once where the way is free, else drawn there by springs
    /// that grow stiffer, together with what they push. Whatever hangs together goes as far towards `start` as it can
    /// by the same share. Parts of a surface that pass through that surface already are left to pass. Throws Error,
    /// naming surfaces and time, where given vertices cannot arrive.
    void begin_step(const DynamicState& state, double end_time, double time_step, Points& start) override;
    bool choose_elements(const Points& positions) override;
    StepFilter filter() override;
    bool goes_on(const Points& positions, const NewtonResult& round) override;

    /// Has no energy until the next step begins.
    void set_silent(bool silent);

    const ContactCounts& counts() const { return counts_; }
    /// Of contact (not of friction) on every vertex, with the elements of the last round: N_v x 3, newton.
    Points contact_forces(const Points& positions) const;

private:
    bool given(int vertex) const { return vertex < elastic_.num_fixed_vertices(); }
    void find_components();
    /// All that can come within `reach`, without those of given vertices only and those that were crossed.
    std::vector<SurfacePair> close_pairs(const Points& positions, double reach, const Eigen::VectorXd& radii);
    void jump(Points& positions);
    std::vector<int> late_vertices(const Points& positions) const;
    void bring_given(Points& positions);
    NewtonResult draw_late(Points& positions, const std::vector<int>& late, double stiffness);
    /// Of a spring that draws a given vertex, newton.
    double largest_pull() const;
    void find_round(const Points& positions);
    void select_elements(const Points& positions);
    void set_friction(const Points& lagged);
    [[noreturn]] void stuck(const Points& positions, const std::vector<int>& late) const;

    ElasticBody& elastic_;
    std::vector<ContactSurface> surfaces_;
    ContactSceneOptions options_;
    std::vector<SurfaceParts> parts_;
    std::vector<int> surface_of_, component_of_;  ///< of every vertex; surface -1: none
    int num_components_ = 0;
    ContactTerm* contact_;
    FrictionTerm* friction_;
    ContactAnchors* anchors_;

    // Of the step.
    std::vector<std::vector<std::pair<int, int>>> crossings_;  ///< of every surface with itself at the step's start
    Points step_start_, wanted_;
    double end_time_ = 0, time_step_ = 0;
    int friction_solves_ = 0;
    ContactCounts counts_;
    // Of the round.
    Points round_start_;
    Eigen::VectorXd radii_;
    std::vector<SurfacePair> found_, elements_;
    std::vector<char> is_element_;  ///< of every pair found
    bool elements_changed_ = true;  ///< since choose_elements() told
};

}  // namespace ndg
